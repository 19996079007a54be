//! The tool along a path, a disc among polygons.

use api::PoseBody;
use api::arms::{ArmFrames, ArmTask};
use api::paths::{FloorBody, PlanRouteBody, PolygonBody, RouteMethod, RouteSearch};
use api::trajectory::{ToolPathBody, ToolPathKind};

use crate::common::{assert_near, forward_of, pose};

pub(crate) fn line(goal: [f64; 6]) -> ToolPathBody {
    ToolPathBody {
        kind: ToolPathKind::Line,
        poses: vec![pose([985.0, 0.0, 940.0, 180.0, 0.0, 0.0]), pose(goal)],
        start_deg_mm: None,
        task: None,
        speed_mm_s: 200.0,
        acceleration_mm_s2: None,
        jerk_mm_s3: None,
        turning_deg_s: None,
        period_s: None,
        frames: ArmFrames::default(),
    }
}

/// By hand: 400 mm at 200 mm/s, acceleration 1000 mm/s2, jerk 10000 mm/s3: 2 s at the speed, and 0.2 s for the
/// acceleration and 0.1 s for the jerk: 2.3 s.
#[test]
fn a_line_takes_the_time_by_hand() {
    let question = line([985.0, 400.0, 940.0, 180.0, 0.0, 0.0]);
    let answer = robotics::tool_path("fanuc-m20ia", &question).unwrap();
    assert!(answer.feasible && answer.failure.is_none());
    // The last sample is at the end of its period.
    assert_near(&[answer.duration_s, answer.slowed], [2.3, 1.0], 0.021);
    let middle = &answer.samples[answer.samples.len() / 2];
    assert_near(&middle.tcp_mm, [985.0, 200.0, 940.0], 3.0);
    // Over 2.32 s, that is.
    assert_near(&[middle.tcp_speed_mm_s], [200.0 * 2.3 / 2.32], 0.5);
    for sample in &answer.samples {
        // On the line, to the rounding of what is shown.
        assert_near(&[sample.tcp_mm[0], sample.tcp_mm[2]], [985.0, 940.0], 1e-6);
    }
    assert_eq!(answer.path_mm.len(), 101);
    // As fast as can be, a joint slows it.
    let fast = ToolPathBody {
        speed_mm_s: 20_000.0,
        ..question
    };
    let answer = robotics::tool_path("fanuc-m20ia", &fast).unwrap();
    assert!(answer.slowed > 1.0 && answer.limited_by.is_some());
    for peaks in &answer.peaks {
        let most = peaks.max_velocity_deg_mm_s * 1.001;
        assert!(peaks.velocity_deg_mm_s <= most, "{peaks:?}");
    }
}

#[test]
fn a_path_that_cannot_be_followed_says_where() {
    // 1812 mm to the wrist at most; the flange looks down.
    let question = line([2500.0, 0.0, 940.0, 180.0, 0.0, 0.0]);
    let answer = robotics::tool_path("fanuc-m20ia", &question).unwrap();
    assert!(!answer.feasible && answer.samples.is_empty());
    let failure = answer.failure.unwrap();
    assert!((0.3..0.7).contains(&failure.parameter), "{failure:?}");
    assert!(failure.reason.contains("out of reach"), "{failure:?}");
    assert_near(&answer.path_mm[100], [2500.0, 0.0, 940.0], 1e-6);
    // Not even its beginning.
    let mut far = question;
    far.poses.swap(0, 1);
    let answer = robotics::tool_path("fanuc-m20ia", &far).unwrap();
    assert_near(&[answer.failure.unwrap().parameter], [0.0], 0.0);
}

#[test]
fn arcs_circles_and_splines_are_followed() {
    let poses = [[985.0, 0.0], [1085.0, 100.0], [985.0, 200.0]]
        .map(|[x, y]| pose([x, y, 800.0, 180.0, 0.0, 0.0]));
    for (kind, end) in [
        (ToolPathKind::Arc, [985.0, 200.0, 800.0]),
        (ToolPathKind::Circle, [985.0, 0.0, 800.0]),
        (ToolPathKind::Spline, [985.0, 200.0, 800.0]),
    ] {
        let question = ToolPathBody {
            kind,
            poses: poses.to_vec(),
            ..line([0.0; 6])
        };
        let answer = robotics::tool_path("fanuc-m20ia", &question).unwrap();
        assert!(answer.feasible, "{:?}", answer.failure);
        assert_near(&answer.samples.last().unwrap().tcp_mm, end, 1e-6);
        if kind != ToolPathKind::Spline {
            // The radius is 100 about (985, 100).
            for [x, y, _] in &answer.path_mm {
                assert_near(&[(x - 985.0).hypot(y - 100.0)], [100.0], 1e-6);
            }
        }
    }
}

/// Between two postures of each arm; what its joints can give of the pose is kept, and its place is on the line.
#[test]
fn every_arm_follows_a_line() {
    for (model, from, to) in [
        (
            "textbook-6r",
            vec![20.0, 60.0, -40.0, 10.0, -50.0, 60.0],
            vec![40.0, 70.0, -55.0, 20.0, -40.0, 50.0],
        ),
        (
            "five-link",
            vec![20.0, 45.0, -60.0, 30.0, 40.0],
            vec![10.0, 55.0, -50.0, 20.0, 30.0],
        ),
        (
            "scara",
            vec![30.0, 60.0, 100.0, 0.0],
            vec![-20.0, 80.0, 50.0, 40.0],
        ),
        (
            "seven-joint",
            vec![10.0, 40.0, 0.0, -70.0, 0.0, 50.0, 0.0],
            vec![30.0, 50.0, 5.0, -60.0, 5.0, 40.0, 10.0],
        ),
        // A task that the closed form does not know is searched for.
        (
            "fanuc-m20ia",
            vec![0.0, 20.0, -20.0, 0.0, -70.0, 0.0],
            vec![20.0, 30.0, -30.0, 10.0, -60.0, 90.0],
        ),
    ] {
        let at = |joints: &[f64]| robotics::forward(model, &forward_of(joints)).unwrap().tcp;
        let (start, goal) = (at(&from), at(&to));
        let question = ToolPathBody {
            poses: vec![start, goal],
            start_deg_mm: Some(from.clone()),
            task: (model == "fanuc-m20ia").then_some(ArmTask::PositionAndAxis),
            ..line([0.0; 6])
        };
        let answer = robotics::tool_path(model, &question).unwrap();
        assert!(answer.feasible, "{model}: {:?}", answer.failure);
        let samples = &answer.samples;
        assert_eq!(samples[0].position_deg_mm, from, "{model}");
        let place = |pose: &PoseBody| nalgebra::Vector3::new(pose.x_mm, pose.y_mm, pose.z_mm);
        let (a, b) = (place(&start), place(&goal));
        for sample in samples {
            let off = nalgebra::Vector3::from(sample.tcp_mm) - a;
            let off = off.cross(&(b - a)).norm() / (b - a).norm();
            assert!(off < 1e-5, "{model}: {off} mm beside the line");
        }
        let last = samples.last().unwrap();
        assert_near(&last.tcp_mm, b.into(), 1e-5);
        // An arm without a joint to spare ends in the posture that the pose is of.
        if matches!(model, "textbook-6r" | "five-link" | "scara") {
            let off = last.position_deg_mm.iter().zip(&to);
            let off = off
                .map(|(is, wanted)| (is - wanted).abs())
                .fold(0.0, f64::max);
            assert!(off < 1e-3, "{model}: {last:?}");
        }
        for peaks in &answer.peaks {
            let [least, most] = peaks.range_deg_mm;
            assert!(peaks.min_deg_mm >= least - 1e-6 && peaks.max_deg_mm <= most + 1e-6);
            let most = peaks.max_velocity_deg_mm_s * 1.001;
            assert!(peaks.velocity_deg_mm_s <= most, "{model}: {peaks:?}");
        }
    }
}

#[test]
fn a_search_that_does_not_get_there_says_how_near_it_came() {
    // The stretched arm reaches 600 mm.
    let question = ToolPathBody {
        poses: vec![
            pose([400.0, 0.0, 300.0, 180.0, 0.0, 0.0]),
            pose([800.0, 0.0, 300.0, 180.0, 0.0, 0.0]),
        ],
        ..line([0.0; 6])
    };
    let answer = robotics::tool_path("scara", &question).unwrap();
    let failure = answer.failure.unwrap();
    assert_near(&[failure.parameter], [0.5], 0.01);
    assert!(failure.reason.starts_with("not reached: "), "{failure:?}");
    // A start that is elsewhere, of a joint that slides: 400 - 20 - 80 = 300.
    let elsewhere = ToolPathBody {
        start_deg_mm: Some(vec![30.0, 60.0, 81.0, 0.0]),
        ..question
    };
    let refusal = robotics::tool_path("scara", &elsewhere).unwrap_err();
    assert!(refusal.path.starts_with("start_deg_mm["), "{refusal}");
}

pub(crate) fn floor(method: RouteMethod) -> PlanRouteBody {
    PlanRouteBody {
        floor: FloorBody {
            min_mm: [0.0, 0.0],
            max_mm: [1000.0, 1000.0],
        },
        obstacles: vec![PolygonBody {
            name: Some("wall".to_owned()),
            corners_mm: vec![[400.0, 0.0], [500.0, 0.0], [500.0, 700.0], [400.0, 700.0]],
        }],
        radius_mm: 50.0,
        start_mm: [100.0, 100.0],
        goal_mm: [900.0, 100.0],
        search: RouteSearch {
            method: Some(method),
            ..RouteSearch::default()
        },
    }
}

const METHODS: [RouteMethod; 4] = [
    RouteMethod::Trapezoidal,
    RouteMethod::Quadtree,
    RouteMethod::PotentialField,
    RouteMethod::Roadmap,
];

/// By hand: the wall's corners, with 50 around them, are passed at (350..550, 700..750). The shortest way bends around
/// (400, 700) and (500, 700) at 50: at least from (100, 100) to there, 100 across, and down again:
/// 2 sqrt(hypot(300, 600)^2 - 50^2) + 100 = 1438.
#[test]
fn every_method_goes_around_the_wall() {
    for method in METHODS {
        let question = floor(method);
        let answer = robotics::plan_route(&question).unwrap();
        assert!(
            (1438.0..1700.0).contains(&answer.length_mm),
            "{method:?}: {}",
            answer.length_mm
        );
        assert!(
            answer.clearance_mm > -1e-3,
            "{method:?}: {}",
            answer.clearance_mm
        );
        assert_eq!(answer.points_mm.first(), Some(&question.start_mm));
        assert_eq!(answer.points_mm.last(), Some(&question.goal_mm));
        assert_eq!(answer, robotics::plan_route(&question).unwrap());
        // What it looked at, for a drawing.
        let of_cells = matches!(method, RouteMethod::Trapezoidal | RouteMethod::Quadtree);
        assert_eq!(!answer.cells.is_empty(), of_cells, "{method:?}");
        assert_eq!(!answer.graph_mm.is_empty(), !of_cells, "{method:?}");
        // The middle of a free cell is at least the robot's radius from the wall.
        for cell in answer.cells.iter().filter(|cell| cell.free) {
            let middle = |axis: usize| cell.corners_mm.iter().map(|c| c[axis]).sum::<f64>() / 4.0;
            let (x, y) = (middle(0), middle(1));
            let (beside, above) = ((x - 450.0).abs() - 50.0, y - 700.0);
            let away = beside.max(0.0).hypot(above.max(0.0));
            assert!(away >= 50.0 - 1e-6, "{method:?}: {cell:?}");
        }
    }
}

#[test]
fn a_closed_wall_has_no_way_around() {
    for method in METHODS {
        let mut question = floor(method);
        question.obstacles[0].corners_mm =
            vec![[400.0, 0.0], [500.0, 0.0], [500.0, 1000.0], [400.0, 1000.0]];
        question.search.samples = Some(500);
        question.search.steps = Some(5000);
        let refused = robotics::plan_route(&question).unwrap_err();
        assert_eq!(
            refused.kind,
            robotics::RefusalKind::NoWay,
            "{method:?}: {refused}"
        );
    }
}
