//! The four planners on the floor: shapes with a known shortest way, the published bug trap and
//! narrow passage over 100 seeds, and bad input.
#![allow(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "the helpers of tests, too, may fail loudly"
)]

use planning::plane::{
    Field, Floor, PlaneError, Point, Polygon, PolygonError, Route, Sampling, potential, quadtree,
    roadmap, trapezoids,
};

const RADIUS: f64 = 30.0;

fn rectangle(x: [f64; 2], y: [f64; 2]) -> Polygon {
    let ([x0, x1], [y0, y1]) = (x, y);
    Polygon::try_new(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).unwrap()
}

fn floor(obstacles: Vec<Polygon>) -> Floor {
    Floor::try_new([0.0, 0.0], [1000.0, 1000.0], obstacles, RADIUS).unwrap()
}

/// The floor, the start and the goal.
type Problem = (Floor, Point, Point);

/// A U that opens away from the goal.
fn bug_trap() -> Problem {
    let trap = Polygon::try_new(vec![
        [300.0, 300.0],
        [650.0, 300.0],
        [650.0, 700.0],
        [300.0, 700.0],
        [300.0, 660.0],
        [610.0, 660.0],
        [610.0, 340.0],
        [300.0, 340.0],
    ])
    .unwrap();
    (floor(vec![trap]), [500.0, 500.0], [900.0, 500.0])
}

/// A wall with a gap of 70 for a robot of 60.
fn narrow_passage() -> Problem {
    let walls = vec![
        rectangle([450.0, 550.0], [0.0, 465.0]),
        rectangle([450.0, 550.0], [535.0, 1000.0]),
    ];
    (floor(walls), [200.0, 200.0], [800.0, 800.0])
}

/// Drives the path in small steps and measures.
fn is_driveable(floor: &Floor, route: &Route, start: Point, goal: Point) {
    let points = route.points();
    assert_eq!((points[0], points[points.len() - 1]), (start, goal));
    for pair in points.windows(2) {
        for step in 0..=200 {
            let share = f64::from(step) / 200.0;
            let at = [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
            assert!(
                floor.clearance(at) >= -1e-5,
                "{at:?}: {}",
                floor.clearance(at)
            );
        }
    }
}

/// Over 100 seeds: how many were solved, and the median and longest path.
fn over_seeds(
    (floor, start, goal): &(Floor, Point, Point),
    plan: impl Fn(u64) -> Result<Route, PlaneError>,
) -> (usize, f64, f64) {
    let mut lengths: Vec<f64> = (0..100)
        .filter_map(|seed| plan(seed).ok())
        .map(|route| {
            is_driveable(floor, &route, *start, *goal);
            route.length()
        })
        .collect();
    lengths.sort_by(f64::total_cmp);
    (
        lengths.len(),
        lengths[lengths.len() / 2],
        lengths[lengths.len() - 1],
    )
}

/// The shortest way out of the trap, by hand: a tangent of sqrt(200^2 + 160^2 - 30^2) = 254.4 to the
/// circle around the corner (300, 340), 40 down, 350 along, a tangent of sqrt(250^2 + 200^2 - 30^2) =
/// 318.7 from the circle around (650, 300), and arcs of 58.07, 90 and 44.03 degrees: 100.6.
const TRAP_LEAST: f64 = 1063.7;
/// Through the gap: tangents of sqrt(250^2 + 265^2 - 30^2) = 363.07 to the circles around (450, 465)
/// and (550, 535), the crossing tangent of sqrt(100^2 + 70^2 - 60^2) = 106.3 between them, and two
/// arcs of 45.84 degrees: 48.0.
const PASSAGE_LEAST: f64 = 880.4;
/// The numbers above are rounded.
const ROUNDED: f64 = 0.2;

/// The shortest way of each problem, and 3 % more.
fn trap_and_passage() -> [(Problem, f64, f64); 2] {
    [
        (bug_trap(), TRAP_LEAST, 1.03 * TRAP_LEAST),
        (narrow_passage(), PASSAGE_LEAST, 1.03 * PASSAGE_LEAST),
    ]
}

fn solves_trap_and_passage(plan: impl Fn(&Problem) -> Result<Route, PlaneError>) {
    for (problem, least, most) in trap_and_passage() {
        let route = plan(&problem).unwrap();
        let (floor, start, goal) = &problem;
        is_driveable(floor, &route, *start, *goal);
        assert!(
            route.length() >= least - ROUNDED && route.length() <= most,
            "{}",
            route.length()
        );
    }
}

#[test]
fn the_exact_decomposition_solves_trap_and_passage() {
    solves_trap_and_passage(|(floor, start, goal)| trapezoids(floor, *start, *goal));
}

#[test]
fn the_approximate_decomposition_solves_trap_and_passage() {
    solves_trap_and_passage(|(floor, start, goal)| quadtree(floor, *start, *goal, 2.0));
}

#[test]
fn the_roadmap_solves_trap_and_passage_with_every_seed() {
    for (problem, least, most) in trap_and_passage() {
        let (floor, start, goal) = &problem;
        let (solved, median, longest) = over_seeds(&problem, |seed| {
            let sampling = Sampling {
                seed,
                ..Sampling::default()
            };
            roadmap(floor, *start, *goal, &sampling)
        });
        println!("roadmap: {solved} of 100, median {median:.0} mm, longest {longest:.0} mm");
        assert!(
            solved == 100 && median >= least - ROUNDED && median <= most,
            "{solved} {median}"
        );
    }
}

#[test]
fn random_walks_leave_the_trap_with_every_seed() {
    let problem = bug_trap();
    let (floor, start, goal) = &problem;
    let walked = |seed: u64, walk: u32| {
        let field = Field {
            seed,
            walk,
            ..Field::default()
        };
        potential(floor, *start, *goal, &field)
    };
    let (solved, median, longest) = over_seeds(&problem, |seed| walked(seed, 400));
    println!("potential, trap: {solved} of 100, median {median:.0} mm, longest {longest:.0} mm");
    assert!(
        solved >= 95 && (TRAP_LEAST - ROUNDED..1.05 * TRAP_LEAST).contains(&median),
        "{solved} {median}"
    );
    // The descent alone stays in the trap: what the textbook warns of.
    let stuck = Field {
        walk: 0,
        most_steps: 2000,
        ..Field::default()
    };
    assert!(matches!(
        potential(floor, *start, *goal, &stuck),
        Err(PlaneError::GaveUp { .. })
    ));
}

#[test]
fn random_walks_find_the_narrow_passage() {
    let problem = narrow_passage();
    let (floor, start, goal) = &problem;
    let (solved, median, longest) = over_seeds(&problem, |seed| {
        // Obstacles must not be felt across the gap: its middle has a clearance of 5.
        let field = Field {
            seed,
            influence: 5.0,
            repulsion: 1e3,
            ..Field::default()
        };
        potential(floor, *start, *goal, &field)
    });
    println!("potential, passage: {solved} of 100, median {median:.0} mm, longest {longest:.0} mm");
    assert!(
        solved >= 95 && (PASSAGE_LEAST - ROUNDED..1.05 * PASSAGE_LEAST).contains(&median),
        "{solved} {median}"
    );
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let (floor, start, goal) = bug_trap();
    let map = || roadmap(&floor, start, goal, &Sampling::default()).unwrap();
    assert_eq!(map(), map());
    let field = || potential(&floor, start, goal, &Field::default()).unwrap();
    assert_eq!(field(), field());
}

#[test]
fn a_closed_door_is_reported() {
    // A gap of 58 for a robot of 60.
    let walls = vec![
        rectangle([450.0, 550.0], [0.0, 471.0]),
        rectangle([450.0, 550.0], [529.0, 1000.0]),
    ];
    let floor = floor(walls);
    let (start, goal) = ([200.0, 200.0], [800.0, 800.0]);
    assert!(matches!(
        trapezoids(&floor, start, goal),
        Err(PlaneError::NoPath { .. })
    ));
    assert!(matches!(
        quadtree(&floor, start, goal, 2.0),
        Err(PlaneError::NoPath { .. })
    ));
    let sampling = Sampling {
        most: 500,
        ..Sampling::default()
    };
    assert!(matches!(
        roadmap(&floor, start, goal, &sampling),
        Err(PlaneError::GaveUp { effort: 500, .. })
    ));
}

#[test]
fn around_one_square_the_shortest_way_is_known() {
    // From (100, 500) to (900, 500) around a square from 400 to 600: tangents of sqrt(300^2 + 100^2 -
    // 30^2) = 314.8, 200 along the side, and arcs of 18.43 + 5.44 degrees: 25.0. Together 854.6.
    let floor = floor(vec![rectangle([400.0, 600.0], [400.0, 600.0])]);
    let (start, goal) = ([100.0, 500.0], [900.0, 500.0]);
    let exact = trapezoids(&floor, start, goal).unwrap();
    is_driveable(&floor, &exact, start, goal);
    assert!(
        exact.length() > 854.4 && exact.length() < 1.01 * 854.6,
        "{}",
        exact.length()
    );
}

#[test]
fn bad_polygons_are_refused_by_name() {
    let refused = |corners: &[Point]| Polygon::try_new(corners.to_vec()).unwrap_err();
    assert_eq!(refused(&[]), PolygonError::Corners { count: 0 });
    assert_eq!(
        refused(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]]).to_string(),
        "corner 2 has the coordinate NaN; it must be a number from -1000000 to 1000000"
    );
    assert!(matches!(
        refused(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]),
        PolygonError::Empty { .. }
    ));
    // A bow tie with one large wing: its edges 2 and 4 cross.
    assert_eq!(
        refused(&[
            [0.0, 0.0],
            [10.0, 0.0],
            [2.0, 10.0],
            [10.0, 10.0],
            [0.0, 6.0]
        ]),
        PolygonError::Crossing {
            first: 2,
            second: 4
        }
    );
    assert_eq!(
        refused(&[[0.0, 0.0], [10.0, 0.0], [4.0, 0.0], [4.0, 5.0]]),
        PolygonError::Crossing {
            first: 1,
            second: 2
        }
    );
}

#[test]
fn bad_floors_starts_and_goals_are_refused_by_name() {
    let size = Floor::try_new([0.0, 0.0], [0.0, 10.0], Vec::new(), 1.0).unwrap_err();
    assert!(
        matches!(
            size,
            PlaneError::Range {
                item: "greatest x of the floor",
                ..
            }
        ),
        "{size}"
    );
    let radius = Floor::try_new([0.0, 0.0], [10.0, 10.0], Vec::new(), f64::NAN).unwrap_err();
    assert!(
        matches!(
            radius,
            PlaneError::Range {
                item: "radius of the robot",
                ..
            }
        ),
        "{radius}"
    );

    let (floor, start, goal) = bug_trap();
    let inside = [630.0, 500.0];
    let every = |start: Point, goal: Point| {
        [
            trapezoids(&floor, start, goal),
            quadtree(&floor, start, goal, 5.0),
            potential(&floor, start, goal, &Field::default()),
            roadmap(&floor, start, goal, &Sampling::default()),
        ]
    };
    for refused in every(start, inside) {
        let PlaneError::InObstacle {
            point: "goal",
            obstacle: 1,
            distance,
            ..
        } = refused.unwrap_err()
        else {
            panic!("not in an obstacle");
        };
        assert!((distance + 20.0).abs() < 1e-9);
    }
    for refused in every([5.0, 500.0], goal) {
        assert_eq!(
            refused.unwrap_err().to_string(),
            "the start is 5.000 mm from the edge of the floor; the robot needs 30 mm"
        );
    }
    for refused in every([f64::INFINITY, 0.0], goal) {
        assert!(matches!(
            refused,
            Err(PlaneError::Range { item: "start", .. })
        ));
    }
    let resolution = quadtree(&floor, start, goal, 0.0).unwrap_err();
    assert!(matches!(
        resolution,
        PlaneError::Range {
            item: "resolution",
            ..
        }
    ));
    let step = Field {
        step: -1.0,
        ..Field::default()
    };
    let step = potential(&floor, start, goal, &step).unwrap_err();
    assert!(matches!(
        step,
        PlaneError::Range {
            item: "step of the field",
            ..
        }
    ));
}
