use plots::{
    Color, HeatMap, Item, Level, Line, Look, Map, Moment, Panel, Skeleton, Stick, heat_map, map,
    panels, skeleton,
};

use crate::seen::seen;

const BLUE: &str = "#0072B2";
const VERMILION: &str = "#D55E00";

fn panel(title: &str, unit: &str, joints: usize) -> Panel {
    let lines = (0..joints).map(|joint| {
        let points = (0..=100)
            .map(|n| {
                let time = f64::from(n) / 50.0;
                (time, (time * 3.0).sin() * 10.0)
            })
            .collect();
        Line::new(format!("J{}", joint + 1), Color::of(joint), points)
    });
    Panel {
        title: title.to_owned(),
        x_label: "time in s".to_owned(),
        y_label: format!("{} in {unit}", title.to_lowercase()),
        lines: lines.collect(),
        levels: vec![Level::limit("limit 25", 25.0)],
        moments: vec![Moment {
            name: "via 1".to_owned(),
            at: 0.5,
        }],
    }
}

#[test]
fn each_panel_has_its_curves_labels_and_limits_and_the_legend_is_there_once() {
    let all = [panel("Position", "°", 6), panel("Velocity", "°/s", 6)];
    let drawing = panels("A move of an arm", "2 s", &all, 2).unwrap();
    let seen = seen(&drawing);
    for text in [
        "A move of an arm",
        "2 s",
        "Position",
        "position in °",
        "Velocity",
        "velocity in °/s",
    ] {
        assert_eq!(seen.count(text), 1, "{text}");
    }
    assert_eq!(seen.count("time in s"), 2);
    assert_eq!(seen.count("limit 25"), 2);
    assert_eq!(seen.count("via 1"), 2);
    for joint in ["J1", "J2", "J3", "J4", "J5", "J6"] {
        assert_eq!(seen.count(joint), 1, "{joint} in the legend");
    }
    // One curve a joint and a panel; the limit is a straight line as wide as the panel and above the curves.
    let curves = seen.drawn(BLUE, 1.8);
    assert_eq!(curves.len(), 2);
    assert!(curves[0].len() > 20, "{}", curves[0].len());
    let limits = seen.drawn(VERMILION, 1.2);
    assert_eq!(limits.len(), 2);
    let &[(left, y), (right, same)] = limits[0] else {
        panic!("{limits:?}")
    };
    assert!((y - same).abs() < 1e-9);
    let top = curves[0].iter().map(|point| point.1).fold(1e9, f64::min);
    assert!(y < top, "the limit at {y} is above {top}");
    assert!((curves[0][0].0 - left).abs() < 0.2);
    assert!((curves[0][curves[0].len() - 1].0 - right).abs() < 0.2);
}

#[test]
fn a_curve_is_where_its_numbers_are() {
    // 0 to 10 in y, 0 to 4 in x: the middle of the line is in the middle of its ends.
    let line = Line::new(
        "J1",
        Color::of(0),
        vec![(0.0, 0.0), (1.0, 10.0), (4.0, 0.0)],
    );
    let panel = Panel {
        title: "Position".to_owned(),
        lines: vec![line],
        ..Panel::default()
    };
    let drawing = panels("A corner", "", &[panel], 1).unwrap();
    let seen = seen(&drawing);
    let curves = seen.drawn(BLUE, 1.8);
    let &[a, b, c] = curves[0] else {
        panic!("{curves:?}")
    };
    assert!((a.1 - c.1).abs() < 0.2 && b.1 < a.1, "{curves:?}");
    let share = (b.0 - a.0) / (c.0 - a.0);
    assert!((share - 0.25).abs() < 0.001, "{share}");
    // A single curve needs no legend.
    assert!(!seen.says("J1"));
}

#[test]
fn on_a_map_a_circle_is_round_and_a_square_is_square() {
    let square = vec![(0.0, 0.0), (1000.0, 0.0), (1000.0, 1000.0), (0.0, 1000.0)];
    let drawing = map(&Map {
        title: "A floor".to_owned(),
        x_label: "X in mm".to_owned(),
        y_label: "Y in mm".to_owned(),
        items: vec![
            Item::Region {
                name: "floor".to_owned(),
                points: vec![
                    (-500.0, 0.0),
                    (4000.0, 0.0),
                    (4000.0, 1500.0),
                    (-500.0, 1500.0),
                ],
                look: Look::Bounds,
            },
            Item::Region {
                name: "obstacle".to_owned(),
                points: square,
                look: Look::Obstacle,
            },
            Item::Ring {
                name: "robot".to_owned(),
                center: (2000.0, 500.0),
                radius: 500.0,
                look: Look::Start,
            },
        ],
        ..Map::default()
    })
    .unwrap();
    let seen = seen(&drawing);
    for text in [
        "A floor", "X in mm", "Y in mm", "floor", "obstacle", "robot",
    ] {
        assert_eq!(seen.count(text), 1, "{text}");
    }
    assert_eq!(seen.polygons.len(), 1);
    let outlines = seen.drawn("#1C2026", 1.0);
    let outline = outlines.iter().find(|line| line.len() == 5).unwrap();
    let (wide, high) = (outline[1].0 - outline[0].0, outline[0].1 - outline[2].1);
    assert!((wide - high).abs() < 0.3, "{wide} x {high}");
    let ring = seen.circles.iter().find(|circle| circle.2 > 20.0).unwrap();
    assert!((2.0 * ring.2 - wide).abs() < 0.5, "{ring:?}, {wide}");
}

#[test]
fn a_heat_map_has_a_color_for_each_count_and_its_place() {
    let drawing = heat_map(&HeatMap {
        title: "Reach".to_owned(),
        x_label: "X in mm".to_owned(),
        y_label: "Z in mm".to_owned(),
        counted: "branches".to_owned(),
        x: vec![0.0, 100.0, 200.0, 300.0],
        y: vec![0.0, 100.0],
        counts: vec![vec![0, 2, 2, 4], vec![0, 0, 0, 4]],
        ..HeatMap::default()
    })
    .unwrap();
    let seen = seen(&drawing);
    for text in ["0 branches", "2", "4"] {
        assert_eq!(seen.count(text), 1, "{text}");
    }
    // Two and two of the same count are one rectangle; the highest is yellow.
    let large: Vec<_> = seen
        .rectangles
        .iter()
        .filter(|(color, area)| *area > 400.0 && color != "#FFFFFF")
        .collect();
    assert_eq!(large.len(), 3, "{large:?}");
    let yellow = large.iter().filter(|(color, _)| color == "#FDE725").count();
    assert_eq!(yellow, 2);
    assert!((large[0].1 / large[1].1 - 2.0).abs() < 0.05, "{large:?}");
}

#[test]
fn an_arm_is_seen_four_times_and_alike_in_all() {
    let points = vec![[0.0, 0.0, 0.0], [50.0, 0.0, 300.0], [400.0, 200.0, 300.0]];
    let drawing = skeleton(&Skeleton {
        title: "An arm".to_owned(),
        unit: "mm".to_owned(),
        sticks: vec![Stick {
            name: "links".to_owned(),
            color: Color::MAIN,
            pixels: 4.0,
            points,
            letters: ["A", "B", "C"].map(str::to_owned).to_vec(),
        }],
        ..Skeleton::default()
    })
    .unwrap();
    let seen = seen(&drawing);
    // The fifth is the legend's.
    assert_eq!(seen.drawn(BLUE, 4.0).len(), 5);
    for (text, times) in [("A", 4), ("X in mm", 3), ("Y in mm", 3), ("Z in mm", 3)] {
        assert_eq!(seen.count(text), times, "{text}");
    }
    for text in [
        "XZ, seen against Y",
        "XY, seen from above",
        "YZ, seen from X",
    ] {
        assert!(seen.says(text), "{text}");
    }
    // 300 mm up in XZ are as long as 300 mm up in YZ, and 400 mm across in XY by the same scale.
    let arms: Vec<_> = seen
        .drawn(BLUE, 4.0)
        .into_iter()
        .filter(|line| line.len() == 3)
        .collect();
    let (xz, xy, yz) = (arms[1], arms[2], arms[3]);
    let up = xz[0].1 - xz[1].1;
    assert!((up - (yz[0].1 - yz[1].1)).abs() < 0.3, "{xz:?} {yz:?}");
    let across = xy[2].0 - xy[0].0;
    assert!((across / up - 4.0 / 3.0).abs() < 0.01, "{across} / {up}");
}

#[test]
fn a_png_is_the_same_drawing_twice_as_large_with_its_letters() {
    let words = panels("Words", "", &[panel("Position", "°", 2)], 1).unwrap();
    let silent = panels("W", "", &[panel("P", "", 2)], 1).unwrap();
    let size = |drawing: &plots::Drawing| {
        let png = drawing.png().unwrap();
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        (f64::from(number(16)), f64::from(number(20)), png.len())
    };
    let (width, height, bytes) = size(&words);
    let seen = seen(&words);
    assert!((width - 2.0 * seen.width).abs() < 1e-9);
    assert!((height - 2.0 * seen.height).abs() < 1e-9);
    // The letters are drawn, on a machine with fonts and on one without.
    assert!(bytes > size(&silent).2, "{bytes}");
}

#[test]
fn what_is_drawn_once_is_drawn_alike_again() {
    let all = [panel("Position", "°", 3)];
    let draw = || panels("A move", "note", &all, 1).unwrap();
    assert_eq!(draw(), draw());
    assert!(draw().svg().contains("<title>A move</title>"));
}

#[test]
fn words_are_no_markup() {
    let drawing = panels("a < b & \"c\"", "", &[panel("P", "°", 1)], 1).unwrap();
    assert!(seen(&drawing).says("a < b & \"c\""));
}
