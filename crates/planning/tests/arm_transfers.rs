//! The arm among obstacles: its shape, distances by hand, transfers among ten obstacles over 100
//! seeds, and bad input.
#![allow(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "the helpers of tests, too, may fail loudly"
)]

use std::sync::atomic::{AtomicU32, Ordering};

use kinematics::serial::{JointValues, SerialArm, SerialError};
use kinematics::{Pose, Xyzwpr};
use planning::arm::{
    ArmError, ArmPath, ArmShape, Capsule, Obstacle, Scene, Touch, Touched, Workplace,
};
use planning::{Sampling, Wanted};
use units::{Degrees, Millimeters};

const MARGIN: Millimeters = Millimeters(20.0);

fn arm() -> &'static SerialArm {
    SerialArm::builtin("fanuc-m20ia").unwrap()
}

fn joints(degrees: [f64; 6]) -> JointValues {
    arm().joints(&degrees).unwrap()
}

fn shape() -> ArmShape {
    ArmShape::skeleton(arm(), Millimeters(90.0)).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    let position = [x, y, z].map(Millimeters);
    Pose::try_from_xyzwpr(&Xyzwpr::new(position, [Degrees(0.0); 3])).unwrap()
}

fn cuboid(middle: [f64; 3], size: [f64; 3]) -> Obstacle {
    let [x, y, z] = middle;
    Obstacle::Box {
        pose: at(x, y, z),
        size: size.map(Millimeters),
    }
}

fn pillar(x: f64, y: f64, radius: f64, height: f64) -> Obstacle {
    Obstacle::Cylinder {
        pose: at(x, y, height / 2.0 - 400.0),
        radius: Millimeters(radius),
        height: Millimeters(height),
    }
}

/// A table on each side, a fence, pillars, a shelf and a keep-out zone between them.
fn ten_obstacles() -> Vec<Obstacle> {
    vec![
        cuboid([900.0, 900.0, -200.0], [500.0, 500.0, 400.0]),
        cuboid([900.0, -900.0, -200.0], [500.0, 500.0, 400.0]),
        cuboid([1300.0, 0.0, 300.0], [100.0, 300.0, 1400.0]),
        pillar(800.0, 250.0, 60.0, 900.0),
        pillar(800.0, -250.0, 60.0, 900.0),
        pillar(1100.0, 400.0, 50.0, 1000.0),
        pillar(1100.0, -400.0, 50.0, 1000.0),
        cuboid([-800.0, 0.0, 600.0], [200.0, 2000.0, 1200.0]),
        cuboid([1000.0, 0.0, 1500.0], [600.0, 600.0, 50.0]),
        Obstacle::KeepOut {
            min: [700.0, -100.0, -500.0].map(Millimeters),
            max: [1000.0, 100.0, 500.0].map(Millimeters),
        },
    ]
}

fn start_and_goal() -> (JointValues, JointValues) {
    (
        joints([45.0, 20.0, -20.0, 0.0, -70.0, 0.0]),
        joints([-45.0, 20.0, -20.0, 0.0, -70.0, 0.0]),
    )
}

fn among<'a>(shape: &'a ArmShape, scene: &'a Scene, margin: Millimeters) -> Workplace<'a> {
    Workplace {
        arm: arm(),
        shape,
        scene,
        margin,
    }
}

/// A transfer that does not move: is the arm free there?
fn stand(
    shape: &ArmShape,
    scene: &Scene,
    joints: &JointValues,
    margin: f64,
) -> Result<ArmPath, ArmError> {
    let margin = Millimeters(margin);
    among(shape, scene, margin).transfer(joints, joints, &Sampling::default(), Wanted::ALWAYS)
}

/// What is touched at the start.
fn touch_at(shape: &ArmShape, scene: &Scene, joints: &JointValues, margin: f64) -> Touch {
    match stand(shape, scene, joints, margin).unwrap_err() {
        ArmError::Touches {
            end: "start",
            touch,
        } => touch,
        other => panic!("{other}"),
    }
}

fn plan(scene: &Scene, seed: u64) -> Result<ArmPath, ArmError> {
    let (start, goal) = start_and_goal();
    let sampling = Sampling {
        seed,
        ..Sampling::default()
    };
    among(&shape(), scene, MARGIN).transfer(&start, &goal, &sampling, Wanted::ALWAYS)
}

#[test]
fn the_capsules_end_where_the_forward_kinematics_ends() {
    // A capsule of no length at the flange is touched by a small box exactly there.
    let ball = Capsule {
        link: 6,
        from: [0.0; 3],
        to: [0.0; 3],
        radius: 5.0,
    };
    let flange_only = ArmShape::try_new(arm(), vec![ball]).unwrap();
    for degrees in [
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        [30.0, -20.0, 40.0, 50.0, -60.0, 70.0],
    ] {
        let joints = joints(degrees);
        let p = arm().forward(&joints).unwrap();
        let p = p.isometry().translation.vector;
        // The face of the box is 40 above the flange: 35 from the ball.
        let scene = Scene::try_new(&[cuboid([p.x, p.y, p.z + 50.0], [20.0; 3])]).unwrap();
        assert!(stand(&flange_only, &scene, &joints, 34.9).is_ok());
        let touch = touch_at(&flange_only, &scene, &joints, 35.1);
        assert_eq!(touch.obstacle, Touched::Obstacle(1));
        assert!((touch.distance.0 - 35.0).abs() < 1e-6, "{touch}");
    }
}

#[test]
fn a_cylinder_stands_along_z() {
    let ball = Capsule {
        link: 0,
        from: [0.0; 3],
        to: [0.0; 3],
        radius: 1.0,
    };
    let base = ArmShape::try_new(arm(), vec![ball]).unwrap();
    let home = arm().home();
    let distance = |obstacle: Obstacle| {
        let scene = Scene::try_new(&[obstacle]).unwrap();
        touch_at(&base, &scene, &home, 1000.0).distance.0
    };
    let cylinder = |x: f64, z: f64| Obstacle::Cylinder {
        pose: at(x, 0.0, z),
        radius: Millimeters(10.0),
        height: Millimeters(200.0),
    };
    // Beside it: 100 - 10 - 1. Above it: 300 - 100 - 1.
    assert!((distance(cylinder(100.0, 0.0)) - 89.0).abs() < 1e-6);
    assert!((distance(cylinder(0.0, 300.0)) - 199.0).abs() < 1e-6);
}

#[test]
fn a_transfer_among_ten_obstacles_succeeds_with_every_seed() {
    let scene = Scene::try_new(&ten_obstacles()).unwrap();
    // The straight way is blocked.
    let (start, goal) = start_and_goal();
    let mut lengths = Vec::new();
    for seed in 0..100 {
        let path = plan(&scene, seed).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let points = path.points();
        assert_eq!((&points[0], &points[points.len() - 1]), (&start, &goal));
        assert!(points.len() > 2);
        lengths.push(path.length_deg());
        if seed < 5 {
            touches_nothing(&path, &scene);
        }
    }
    lengths.sort_by(f64::total_cmp);
    println!(
        "transfer: median {:.0}\u{b0}, longest {:.0}\u{b0}",
        lengths[50], lengths[99]
    );
    assert!(lengths[50] < 400.0);
}

/// In steps ten times finer than the planner's, with the smallest margin there is.
fn touches_nothing(path: &ArmPath, scene: &Scene) {
    // Thinner by the margin less 1, measured with the margin 1.
    let thin = ArmShape::skeleton(arm(), Millimeters(89.0)).unwrap();
    is_free_all_the_way(path, &thin, scene);
}

fn is_free_all_the_way(path: &ArmPath, shape: &ArmShape, scene: &Scene) {
    for pair in path.points().windows(2) {
        for step in 0..=400 {
            let joints = pair[0].toward(&pair[1], f64::from(step) / 400.0);
            assert!(arm().check_ranges(&joints).unwrap().is_empty());
            let here = stand(shape, scene, &joints, 1.0);
            assert!(here.is_ok(), "{}", here.unwrap_err());
        }
    }
}

fn nothing() -> Scene {
    Scene::try_new(&[]).unwrap()
}

#[test]
fn every_arm_that_can_be_planned_for_has_a_shape() {
    for arm in SerialArm::catalog() {
        let name = arm.name();
        let shape = if arm.capsules().is_empty() {
            ArmShape::skeleton(arm, Millimeters(20.0)).unwrap()
        } else {
            let own = ArmShape::of_model(arm).unwrap();
            assert_eq!(own.capsules(), arm.capsules());
            own
        };
        let (scene, home) = (nothing(), arm.home());
        let place = Workplace {
            arm,
            shape: &shape,
            scene: &scene,
            margin: MARGIN,
        };
        let here = place.transfer(&home, &home, &Sampling::default(), Wanted::ALWAYS);
        assert!(here.is_ok(), "{name}: {}", here.unwrap_err());
    }
}

#[test]
fn a_model_file_without_capsules_has_no_shape() {
    let text = include_str!("../../kinematics/models/fanuc_m20ia.toml");
    let bare = text.split("[[capsules]]").next().unwrap();
    let error = ArmShape::of_model(&SerialArm::from_toml(bare).unwrap()).unwrap_err();
    assert!(matches!(error, ArmError::Capsules { count: 0, .. }));
}

#[test]
fn an_arm_folded_into_its_foot_is_refused() {
    // Both angles -70 degrees, all in the plane of x and z: the elbow joint is at 150 - 790 sin 70
    // and 790 cos 70, the forearm's axis begins 250 beside it and points 70 degrees down for 835:
    // the wrist is at (-71.847, -428.943). From there to the lower end of the foot, (0, -375), it
    // is 85.964 across the forearm's axis; less the radii 150 and 70 that is -134.036.
    let folded = joints([0.0, -70.0, -70.0, 0.0, -90.0, 0.0]);
    let shape = ArmShape::of_model(arm()).unwrap();
    let touch = touch_at(&shape, &nothing(), &folded, 20.0);
    assert_eq!((touch.capsule, touch.obstacle), (1, Touched::Capsule(7)));
    assert!((touch.distance.0 + 134.036).abs() < 1e-2, "{touch}");
    assert_eq!(
        touch.to_string(),
        "capsule 1 is -134.0 mm from capsule 7 of the arm itself; the margin is 20 mm"
    );
    // A large margin to obstacles is not one to the arm itself.
    assert!(stand(&shape, &nothing(), &arm().home(), 900.0).is_ok());
}

#[test]
fn a_tool_is_kept_from_the_arm() {
    // Half a meter out of the flange, and bent back: with J5 at 140 degrees it points at the
    // forearm.
    let hook = Capsule {
        link: 6,
        from: [0.0, 0.0, 150.0],
        to: [0.0, 0.0, 500.0],
        radius: 30.0,
    };
    let bare = ArmShape::of_model(arm()).unwrap();
    let shape = bare.with(arm(), &[hook]).unwrap();
    let tool_at = |j5: f64| joints([0.0, 0.0, 0.0, 0.0, j5, 0.0]);
    assert!(stand(&shape, &nothing(), &tool_at(-90.0), 20.0).is_ok());
    assert!(stand(&bare, &nothing(), &tool_at(-140.0), 20.0).is_ok());
    // The tool's near end is at 250 from the wrist center, 40 degrees off the forearm's axis:
    // 250 sin 40 = 160.7 from it, less the radii 70 and 30; the other end is farther.
    let long = Capsule {
        radius: 100.0,
        ..hook
    };
    let shape = bare.with(arm(), &[long]).unwrap();
    let touch = touch_at(&shape, &nothing(), &tool_at(-140.0), 20.0);
    assert_eq!((touch.capsule, touch.obstacle), (7, Touched::Capsule(9)));
    let wanted = 250.0 * 40.0_f64.to_radians().sin() - 70.0 - 100.0;
    assert!((touch.distance.0 - wanted).abs() < 1e-6, "{touch}");
}

#[test]
fn neighbors_and_what_touches_at_home_are_left_out() {
    let ball = |link: usize, x: f64| Capsule {
        link,
        from: [x, 0.0, 0.0],
        to: [x, 0.0, 0.0],
        radius: 50.0,
    };
    let free = |capsules: Vec<Capsule>| {
        let shape = ArmShape::try_new(arm(), capsules).unwrap();
        stand(&shape, &nothing(), &arm().home(), 20.0).is_ok()
    };
    // Frames 4 and 5 have one origin: two balls around it, neighbors, and built so in any case.
    assert!(free(vec![ball(4, 0.0), ball(5, 0.0)]));
    assert!(free(vec![ball(3, 0.0), ball(4, 0.0), ball(5, 0.0)]));
}

#[test]
fn the_arm_finds_a_way_around_itself() {
    let shape = ArmShape::of_model(arm()).unwrap();
    // A bar beside the flange that points back along the arm: half a turn of J6 swings it through
    // the forearm.
    let tool = Capsule {
        link: 6,
        from: [0.0, 200.0, 0.0],
        to: [0.0, 200.0, -400.0],
        radius: 30.0,
    };
    let shape = shape.with(arm(), &[tool]).unwrap();
    let start = joints([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let goal = joints([0.0, 0.0, 0.0, 0.0, -90.0, -180.0]);
    let on_the_way = |share: f64| start.toward(&goal, share);
    let blocked = (0..=100)
        .map(|step| on_the_way(f64::from(step) / 100.0))
        .filter(|joints| stand(&shape, &nothing(), joints, 20.0).is_err())
        .count();
    println!("{blocked} of 101 points of the straight way touch the arm itself");
    let (scene, sampling) = (nothing(), Sampling::default());
    let place = among(&shape, &scene, MARGIN);
    let path = place.transfer(&start, &goal, &sampling, Wanted::ALWAYS);
    let path = path.unwrap();
    assert!(blocked > 0 && path.points().len() > 2);
    is_free_all_the_way(&path, &shape, &nothing());
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let scene = Scene::try_new(&ten_obstacles()).unwrap();
    assert_eq!(plan(&scene, 7).unwrap(), plan(&scene, 7).unwrap());
}

#[test]
fn bad_input_is_refused_by_name() {
    let box_of = |size: [f64; 3]| Scene::try_new(&[cuboid([0.0; 3], size)]).unwrap_err();
    assert_eq!(
        box_of([1.0, 0.0, 1.0]).to_string(),
        "obstacle 1: size y is 0 mm; sizes are positive, all within 100 m"
    );
    assert!(matches!(
        box_of([f64::NAN, 1.0, 1.0]),
        ArmError::Obstacle { item: "size x", .. }
    ));
    let reversed = Scene::try_new(&[Obstacle::KeepOut {
        min: [Millimeters(10.0); 3],
        max: [Millimeters(0.0); 3],
    }]);
    assert!(matches!(
        reversed,
        Err(ArmError::Obstacle {
            obstacle: 1,
            item: "size x",
            ..
        })
    ));

    let capsule = |link: usize, radius: f64| {
        let capsule = Capsule {
            link,
            from: [0.0; 3],
            to: [0.0; 3],
            radius,
        };
        ArmShape::try_new(arm(), vec![capsule]).unwrap_err()
    };
    assert_eq!(
        capsule(7, 1.0),
        ArmError::Link {
            capsule: 1,
            link: 7,
            last: 6
        }
    );
    assert!(matches!(
        capsule(1, -1.0),
        ArmError::Capsule { item: "radius", .. }
    ));
    assert!(matches!(
        ArmShape::try_new(arm(), Vec::new()),
        Err(ArmError::Capsules { .. })
    ));

    let scene = Scene::try_new(&ten_obstacles()).unwrap();
    let (start, goal) = start_and_goal();
    let refused = |start: &JointValues, goal: &JointValues, margin: f64| {
        let (shape, sampling) = (shape(), Sampling::default());
        let place = among(&shape, &scene, Millimeters(margin));
        let refused = place.transfer(start, goal, &sampling, Wanted::ALWAYS);
        refused.unwrap_err()
    };
    let beyond = joints([171.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    match refused(&beyond, &goal, 20.0) {
        ArmError::Limits {
            end: "start",
            outside,
        } => assert_eq!(outside.joint, "J1"),
        other => panic!("{other}"),
    }
    let nan = arm().joints(&[0.0, f64::NAN, 0.0, 0.0, -90.0, 0.0]);
    assert!(matches!(nan, Err(SerialError::NotAValue { .. })));
    let scara = SerialArm::builtin("scara").unwrap().home();
    assert!(matches!(
        refused(&start, &scara, 20.0),
        ArmError::Joints { end: "goal", .. }
    ));
    let inside = joints([0.0, 20.0, -20.0, 0.0, -70.0, 0.0]);
    assert!(matches!(
        refused(&start, &inside, 20.0),
        ArmError::Touches { end: "goal", .. }
    ));
    assert!(matches!(
        refused(&start, &goal, f64::NAN),
        ArmError::Margin { .. }
    ));
}

/// A SCARA's quill goes up, over a wall and down again: its capsule moves as far as it slides.
#[test]
fn an_arm_that_slides_goes_over_a_wall() {
    let arm = SerialArm::builtin("scara").unwrap();
    let shape = ArmShape::skeleton(arm, Millimeters(20.0)).unwrap();
    let at = |j1: f64, z: f64| arm.joints(&[j1, 30.0, z, 0.0]).unwrap();
    let (start, goal) = (at(-40.0, 150.0), at(40.0, 150.0));
    // The tool hangs at 400 - 20 - z = 230 mm; the wall is as high as 280, from near the column to beyond the reach.
    let wall = cuboid([430.0, 0.0, 140.0], [740.0, 20.0, 280.0]);
    let scene = Scene::try_new(&[wall]).unwrap();
    let place = Workplace {
        arm,
        shape: &shape,
        scene: &scene,
        margin: MARGIN,
    };
    for seed in 0..20 {
        let sampling = Sampling {
            seed,
            ..Sampling::default()
        };
        let path = place.transfer(&start, &goal, &sampling, Wanted::ALWAYS);
        let path = path.unwrap();
        assert!(path.points().len() > 2 && path.length_mm() > 50.0, "{seed}");
        for pair in path.points().windows(2) {
            for step in 0..=200 {
                let joints = pair[0].toward(&pair[1], f64::from(step) / 200.0);
                let here = Workplace {
                    margin: Millimeters(1.0),
                    ..place
                };
                let here = here.transfer(&joints, &joints, &Sampling::default(), Wanted::ALWAYS);
                assert!(here.is_ok(), "seed {seed}: {}", here.unwrap_err());
            }
        }
    }
}

#[test]
fn a_transfer_that_nobody_waits_for_is_broken_off() {
    // A closed wall around the base: every sample is in vain.
    let scene = Scene::try_new(&[
        cuboid([600.0, 0.0, 0.0], [50.0, 3000.0, 4000.0]),
        cuboid([-600.0, 0.0, 0.0], [50.0, 3000.0, 4000.0]),
    ]);
    let (scene, shape) = (
        scene.unwrap(),
        ArmShape::skeleton(arm(), Millimeters(5.0)).unwrap(),
    );
    let start = joints([90.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let goal = joints([-90.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let asked = AtomicU32::new(0);
    let still = || asked.fetch_add(1, Ordering::Relaxed) < 50;
    let place = among(&shape, &scene, MARGIN);
    let end = place.transfer(
        &start,
        &goal,
        &Sampling::default(),
        Wanted::while_true(&still),
    );
    assert!(matches!(end, Err(ArmError::BrokenOff(_))), "{end:?}");
    assert_eq!(asked.into_inner(), 51);
}
