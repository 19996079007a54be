use plots::{
    Color, HeatMap, Line, Map, Panel, PlotError, Skeleton, Stick, heat_map, map, panels, skeleton,
};

fn titled(points: Vec<(f64, f64)>) -> Panel {
    Panel {
        title: "Velocity".to_owned(),
        lines: vec![Line::new("J1", Color::of(0), points)],
        ..Panel::default()
    }
}

#[test]
fn nothing_is_no_drawing() {
    for error in [
        panels("A move", "", &[], 1).unwrap_err(),
        panels("A move", "", &[titled(Vec::new())], 1).unwrap_err(),
        map(&Map::default()).unwrap_err(),
        heat_map(&HeatMap::default()).unwrap_err(),
        skeleton(&Skeleton::default()).unwrap_err(),
    ] {
        assert!(matches!(error, PlotError::Empty { .. }), "{error}");
    }
}

#[test]
fn what_is_no_number_is_named() {
    let error = panels(
        "A move",
        "",
        &[titled(vec![(0.0, 1.0), (1.0, f64::NAN)])],
        1,
    );
    assert_eq!(
        error.unwrap_err().to_string(),
        "Velocity has a value that is not a finite number: NaN"
    );
}

#[test]
fn parts_that_do_not_fit_are_named() {
    let error = heat_map(&HeatMap {
        title: "Reach".to_owned(),
        x: vec![0.0, 1.0],
        y: vec![0.0],
        counts: vec![vec![1]],
        ..HeatMap::default()
    });
    assert_eq!(
        error.unwrap_err().to_string(),
        "Reach: a row has 1 values where 2 are needed"
    );
    let error = skeleton(&Skeleton {
        title: "Arm".to_owned(),
        sticks: vec![Stick {
            name: "links".to_owned(),
            color: Color::MAIN,
            pixels: 2.0,
            points: vec![[0.0; 3]; 2],
            letters: vec!["A".to_owned()],
        }],
        ..Skeleton::default()
    });
    assert_eq!(
        error.unwrap_err().to_string(),
        "Arm: letters of links has 1 values where 2 are needed"
    );
}

#[test]
fn extreme_numbers_are_drawn_all_the_same() {
    for points in [
        vec![(0.0, 1e-300), (1.0, -1e-300)],
        vec![(0.0, 1e12), (1.0, -1e12)],
        vec![(5.0, 7.0)],
        vec![(0.0, 0.0), (0.0, 0.0)],
        vec![(1e9, 1e9), (1e9 + 1.0, 1e9)],
    ] {
        let drawn = panels("A move", "", &[titled(points.clone())], 1);
        assert!(drawn.is_ok(), "{points:?}: {drawn:?}");
    }
}
