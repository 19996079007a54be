//! Joints in time.

use api::trajectory::{JointStates, TrajectoryBody, TrajectoryKind};

use crate::common::assert_near;

pub(crate) fn trajectory(kind: TrajectoryKind, start: &[f64], goal: &[f64]) -> TrajectoryBody {
    let at = |position: &[f64]| JointStates {
        position_deg_mm: position.to_vec(),
        ..JointStates::default()
    };
    TrajectoryBody {
        kind,
        start: at(start),
        goal: at(goal),
        via_deg_mm: Vec::new(),
        durations_s: Vec::new(),
        max_velocity_deg_mm_s: None,
        max_acceleration_deg_mm_s2: None,
        max_jerk_deg_mm_s3: None,
        period_s: None,
        frames: api::arms::ArmFrames::default(),
    }
}

/// By hand: from rest to rest over T a quintic is d (10 u^3 - 15 u^4 + 6 u^5); the speed is highest in the middle,
/// 15/8 d/T, the acceleration 10/sqrt(3) d/T^2, the jerk 60 d/T^3 at the ends. d = 80, T = 2: 75, 115.47, 600.
#[test]
fn a_quintic_from_rest_to_rest_has_the_peaks_by_hand() {
    let question = TrajectoryBody {
        durations_s: vec![2.0],
        period_s: Some(0.1),
        ..trajectory(
            TrajectoryKind::Quintic,
            &[0.0, 0.0, 0.0, 0.0],
            &[80.0, 0.0, 100.0, 0.0],
        )
    };
    let answer = robotics::trajectory("scara", &question).unwrap();
    assert_eq!(answer.samples.len(), 21);
    let first = &answer.peaks[0];
    assert!((first.velocity_deg_mm_s - 75.0).abs() < 1e-6, "{first:?}");
    assert!(
        (first.acceleration_deg_mm_s2 - 115.470_053_8).abs() < 1e-6,
        "{first:?}"
    );
    assert!((first.jerk_deg_mm_s3 - 600.0).abs() < 0.01, "{first:?}");
    let middle = &answer.samples[10];
    assert_eq!(middle.position_deg_mm, [40.0, 0.0, 50.0, 0.0]);
    // J1 turns 600 mm of arm at 75 deg/s while the quill sinks at 93.75 mm/s: hypot(785.398, 93.75).
    assert!(
        (middle.tcp_speed_mm_s - 790.973_8).abs() < 1e-3,
        "{middle:?}"
    );
    assert!(answer.within_limits);
}

/// By hand: with 1 deg of speed, acceleration and jerk each a second, 6 deg take 8 s: 6 at the speed 1, and 1 s each
/// for acceleration and jerk.
#[test]
fn a_jerk_limited_move_takes_the_time_by_hand() {
    let ones = Some(vec![1.0; 6]);
    let question = TrajectoryBody {
        max_velocity_deg_mm_s: ones.clone(),
        max_acceleration_deg_mm_s2: ones.clone(),
        max_jerk_deg_mm_s3: ones,
        ..trajectory(
            TrajectoryKind::JerkLimited,
            &[0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
            &[6.0, 0.5, 0.0, 0.0, -90.0, 0.0],
        )
    };
    let answer = robotics::trajectory("fanuc-m20ia", &question).unwrap();
    assert!((answer.duration_s - 8.0).abs() < 1e-9);
    assert_eq!(answer.slowest.as_deref(), Some("J1"));
    assert!(answer.within_limits, "{:?}", answer.peaks);
    assert_eq!(answer.samples.len(), 101);
    // Exactly ten seconds instead.
    let slower = TrajectoryBody {
        durations_s: vec![10.0],
        ..question
    };
    let answer = robotics::trajectory("fanuc-m20ia", &slower).unwrap();
    assert!((answer.duration_s - 10.0).abs() < 1e-9);
    // And four are not possible: the next is the eight.
    let faster = TrajectoryBody {
        durations_s: vec![4.0],
        ..slower
    };
    let refused = robotics::trajectory("fanuc-m20ia", &faster).unwrap_err();
    assert_eq!(refused.path, "durations_s[0]");
    assert!((refused.min.unwrap() - 8.0).abs() < 1e-6, "{refused}");
}

#[test]
fn via_points_are_gone_through_and_past() {
    let via = vec![
        vec![10.0, 5.0, 0.0, 0.0, -80.0, 0.0],
        vec![30.0, 10.0, 0.0, 0.0, -75.0, 0.0],
    ];
    let (start, goal) = (
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        [40.0, 15.0, 0.0, 0.0, -70.0, 0.0],
    );
    for kind in [
        TrajectoryKind::FourThreeFour,
        TrajectoryKind::ThreeFiveThree,
    ] {
        let question = TrajectoryBody {
            via_deg_mm: via.clone(),
            durations_s: vec![0.5, 1.0, 0.5],
            period_s: Some(0.25),
            ..trajectory(kind, &start, &goal)
        };
        let answer = robotics::trajectory("fanuc-m20ia", &question).unwrap();
        assert_near(&[answer.duration_s], [2.0], 1e-12);
        // At 0.5 s and 1.5 s.
        for (sample, via) in [(2, &via[0]), (6, &via[1])] {
            for (is, wanted) in answer.samples[sample].position_deg_mm.iter().zip(via) {
                assert!((is - wanted).abs() < 1e-6, "{kind:?}");
            }
        }
        assert!(
            answer
                .via
                .iter()
                .all(|via| via.deviation_deg_mm.iter().all(|off| *off < 1e-6))
        );
    }
    let question = TrajectoryBody {
        via_deg_mm: via,
        ..trajectory(TrajectoryKind::Blended, &start, &goal)
    };
    let answer = robotics::trajectory("fanuc-m20ia", &question).unwrap();
    assert_eq!(answer.via.len(), 2);
    // Gone past: near, not through.
    let off = answer.via[0].deviation_deg_mm[0];
    assert!(off > 0.0 && off < 5.0, "{:?}", answer.via);
    assert!(answer.within_limits, "{:?}", answer.peaks);
}
