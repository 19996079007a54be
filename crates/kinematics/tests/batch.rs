//! Many poses at once give what one at a time gives.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::num::NonZeroUsize;

use kinematics::serial::SerialArm;
use kinematics::{ArmModel, Axis, PendantJoints, Pose, Reach, ReachError};
use support::{apart_but_for_turns, arm, assert_same_pose, builds, inside};

/// Poses all over the ranges, every seventh one singular, every eleventh out of reach.
fn poses(count: u32) -> Vec<Pose> {
    let part = |k: u32, i: u32| (f64::from(k) * 0.618_034 * f64::from(i)).fract();
    (1..=count)
        .map(|k| {
            let joints = inside(arm(), [1, 2, 3, 5, 7, 11].map(|i| part(k, i)));
            let [j1, j2, j3, j4, j5, j6] = joints.degrees();
            let j5 = if k % 7 == 0 { 0.0 } else { j5 };
            let joints = PendantJoints::from_degrees([j1, j2, j3, j4, j5, j6]);
            let pose = arm().forward(&joints);
            if k % 11 == 0 {
                let mut far = *pose.isometry();
                far.translation.vector *= 4.0;
                return Pose::try_from_isometry(far).unwrap();
            }
            pose
        })
        .collect()
}

#[test]
fn a_batch_gives_the_joint_sets_of_one_pose_at_a_time() {
    for arm in builds() {
        assert_batch_is_one_at_a_time(&arm);
    }
}

fn assert_batch_is_one_at_a_time(arm: &ArmModel) {
    let poses = poses(2001);
    let mut seen = 0;
    arm.inverse_batch(&poses, |index, sets| {
        assert_eq!(index, seen);
        seen += 1;
        let pose = poses.get(index).unwrap();
        let alone: Vec<_> = arm.inverse_all(pose).map_or(Vec::new(), |found| {
            found.iter().map(|solution| solution.joints).collect()
        });
        assert_eq!(sets.len(), alone.len(), "{index}");
        assert_eq!(sets.is_empty(), alone.is_empty());
        for joints in sets.iter() {
            assert_same_pose(&arm.forward(&joints), pose, "batch");
            let near = alone
                .iter()
                .any(|other| apart_but_for_turns(other, &joints) < 1e-6);
            assert!(near, "{joints}");
        }
    });
    assert_eq!(seen, poses.len());
}

#[test]
fn poses_and_jacobians_of_a_batch_are_those_of_one_set_at_a_time() {
    let part = |k: u32, i: u32| (f64::from(k) * 0.618_034 * f64::from(i)).fract();
    for arm in builds() {
        // One more than a whole number of groups, and one set many turns away.
        let mut joints: Vec<_> = (1..=200)
            .map(|k| inside(&arm, [1, 2, 3, 5, 7, 11].map(|i| part(k, i))))
            .collect();
        joints.push(PendantJoints::from_degrees([
            1e8, 10.0, 20.0, 30.0, 40.0, 50.0,
        ]));
        let mut seen = 0;
        arm.forward_batch(&joints, |index, pose| {
            assert_eq!(index, seen);
            seen += 1;
            let wanted = arm.forward(joints.get(index).unwrap());
            let (apart, turned) = pose.distance_to(&wanted);
            assert!(apart.0 < 1e-11 && turned.0 < 1e-14, "{apart} {turned}");
        });
        assert_eq!(seen, joints.len());
        seen = 0;
        arm.jacobian_batch(&joints, |index, jacobian| {
            assert_eq!(index, seen);
            seen += 1;
            let wanted = arm.jacobian(joints.get(index).unwrap());
            assert!((jacobian - wanted).amax() < 1e-11);
        });
        assert_eq!(seen, joints.len());
        arm.forward_batch(&[], |_, _| panic!("there is none"));
    }
}

#[test]
fn the_jacobian_is_that_of_the_arm_of_any_joints() {
    let part = |k: u32, i: u32| (f64::from(k) * 0.618_034 * f64::from(i)).fract();
    for name in ArmModel::builtin_names() {
        let (closed, any) = (
            ArmModel::builtin(name).unwrap(),
            SerialArm::builtin(name).unwrap(),
        );
        for k in 1..100 {
            let joints = inside(closed, [1, 2, 3, 5, 7, 11].map(|i| part(k, i)));
            let wanted = any
                .jacobian(&any.joints(&joints.degrees()).unwrap())
                .unwrap();
            let difference = wanted - closed.jacobian(&joints);
            assert!(
                difference.amax() < 1e-10,
                "{name} at {joints}: {difference}"
            );
        }
    }
}

#[test]
fn a_reachability_map_counts_what_the_selection_would_take() {
    let poses = poses(1003);
    let threads = |count| NonZeroUsize::new(count).unwrap();
    let map = arm().reachability(&poses, threads(1)).unwrap();
    assert_eq!(map, arm().reachability(&poses, threads(3)).unwrap());
    for (pose, reach) in poses.iter().zip(&map) {
        let wanted = arm().inverse_all(pose).map_or(Reach::default(), |found| {
            let is_inside = |joints: &PendantJoints| {
                Axis::ALL.into_iter().all(|axis| {
                    let (limits, value) = (arm().limits(axis), joints.of(axis).0);
                    (-1..=1).any(|turn| {
                        let value = value + 360.0 * f64::from(turn);
                        value >= limits.min.0 - 1e-9 && value <= limits.max.0 + 1e-9
                    })
                })
            };
            let inside = found.iter().filter(|s| is_inside(&s.joints)).count();
            Reach {
                solutions: u8::try_from(found.len()).unwrap(),
                inside: u8::try_from(inside).unwrap(),
            }
        });
        assert_eq!(*reach, wanted, "{}", pose.xyzwpr());
    }
    assert!(arm().reachability(&[], threads(4)).unwrap().is_empty());
    let error = arm().reachability(&poses, threads(1000)).unwrap_err();
    assert_eq!(
        error,
        ReachError::Threads {
            threads: 1000,
            max: 256
        }
    );
}
