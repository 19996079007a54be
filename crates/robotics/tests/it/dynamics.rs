//! Torques of the joints for a motion.

use api::arms::{ArmInertia, ArmInverseDynamicsBody};
use robotics::RefusalKind;

use crate::common::assert_near;

fn motion(joints: &[f64], velocities: &[f64], accelerations: &[f64]) -> ArmInverseDynamicsBody {
    ArmInverseDynamicsBody {
        joints_deg_mm: joints.to_vec(),
        velocities_deg_mm_s: Some(velocities.to_vec()),
        accelerations_deg_mm_s2: Some(accelerations.to_vec()),
        ..ArmInverseDynamicsBody::default()
    }
}

fn ball(mass_kg: f64) -> ArmInertia {
    ArmInertia {
        mass_kg,
        center_of_mass_m: [0.0; 3],
        inertia_kg_m2: Some([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]),
    }
}

/// By hand: the quill and the flange, 3 kg, go down with 4 m/s^2 at 0.5 m/s: 3 (4 - 9.80665) = -17.41995 N, and half as
/// many watts.
#[test]
fn the_quill_of_a_scara_is_as_by_hand() {
    let body = ArmInverseDynamicsBody {
        links: Some(vec![ball(9.0), ball(8.0), ball(2.0), ball(1.0)]),
        ..motion(
            &[10.0, 20.0, 100.0, 30.0],
            &[0.0, 0.0, 500.0, 0.0],
            &[0.0, 0.0, 4000.0, 0.0],
        )
    };
    let answer = robotics::inverse_dynamics("scara", &body).unwrap();
    assert_near(&answer.torques_nm_n, [0.0, 0.0, -17.419_95, 0.0], 1e-8);
    assert_near(&answer.gravity_nm_n, [0.0, 0.0, -29.419_95, 0.0], 1e-8);
    assert_near(&answer.velocity_nm_n, [0.0; 4], 1e-8);
    assert_near(&answer.acceleration_nm_n, [0.0, 0.0, 12.0, 0.0], 1e-8);
    assert_near(&[answer.power_w], [-8.709_975], 1e-8);
}

/// What the model says, and nothing that it does not.
#[test]
fn only_arms_whose_links_weigh_something_have_torques() {
    let still = ArmInverseDynamicsBody {
        joints_deg_mm: vec![0.0; 5],
        ..ArmInverseDynamicsBody::default()
    };
    let answer = robotics::inverse_dynamics("five-link", &still).unwrap();
    assert_near(&answer.torques_nm_n, [0.0; 5], 1e-8);
    let described = robotics::describe("five-link").unwrap();
    let masses = described
        .joints
        .iter()
        .map(|joint| joint.inertia.map(|i| i.mass_kg));
    assert_eq!(
        masses.collect::<Vec<_>>(),
        [4.0, 3.0, 1.5, 2.0, 0.8].map(Some)
    );

    let still = ArmInverseDynamicsBody {
        joints_deg_mm: vec![0.0; 6],
        ..ArmInverseDynamicsBody::default()
    };
    let refusal = robotics::inverse_dynamics("fanuc-m20ia", &still).unwrap_err();
    assert_eq!(
        (refusal.kind, &*refusal.path),
        (RefusalKind::Invalid, "links")
    );
    assert!(
        refusal
            .detail
            .contains("inertia_kg_m2 of J1, J2, J3, J4, J5, J6"),
        "{refusal}"
    );
}

#[test]
fn what_is_no_motion_is_refused_with_its_item() {
    let none = [0.0; 5];
    let good = motion(&none, &none, &none);
    let mut heavy = ball(1.0);
    heavy.inertia_kg_m2 = Some([[1.0, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 0.5]]);
    let light = ArmInertia {
        inertia_kg_m2: None,
        ..ball(1.0)
    };
    for (body, path) in [
        (motion(&none[..4], &none, &none), "joints_deg_mm"),
        (motion(&none, &none[..3], &none), "velocities_deg_mm_s"),
        (
            motion(&none, &none, &[0.0, 1e9, 0.0, 0.0, 0.0]),
            "accelerations_deg_mm_s2[1]",
        ),
        (
            ArmInverseDynamicsBody {
                gravity_m_s2: Some([0.0, f64::NAN, 0.0]),
                ..good.clone()
            },
            "gravity_m_s2",
        ),
        (
            ArmInverseDynamicsBody {
                payload: Some(ball(0.0)),
                ..good.clone()
            },
            "payload.mass_kg",
        ),
        (
            ArmInverseDynamicsBody {
                payload: Some(heavy),
                ..good.clone()
            },
            "payload.inertia_kg_m2",
        ),
        (
            ArmInverseDynamicsBody {
                links: Some(vec![ball(1.0); 4]),
                ..good.clone()
            },
            "links",
        ),
        (
            ArmInverseDynamicsBody {
                links: Some(vec![ball(1.0), light, ball(1.0), ball(1.0), ball(1.0)]),
                ..good.clone()
            },
            "links[1].inertia_kg_m2",
        ),
    ] {
        let refusal = robotics::inverse_dynamics("five-link", &body).unwrap_err();
        assert_eq!(
            (refusal.kind, &*refusal.path),
            (RefusalKind::Invalid, path),
            "{refusal}"
        );
    }
}
