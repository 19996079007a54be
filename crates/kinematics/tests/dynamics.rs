//! Inverse dynamics: two links by hand, and arms of any joints against what moves point masses.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

use std::fmt::Write as _;

use kinematics::Instructions;
use kinematics::dynamics::{
    DynamicsError, InertiaError, InverseDynamics, JointState, LinkInertia, Load, STANDARD_GRAVITY,
};
use kinematics::serial::{JointKind, SerialArm, SerialModelError};
use nalgebra::{Matrix3, Matrix4, Vector3};
use proptest::prelude::*;

/// A row of a table; lengths in millimeters, angles in degrees.
#[derive(Clone, Debug)]
struct Row {
    kind: JointKind,
    a: f64,
    alpha: f64,
    /// d of a joint that turns, theta of one that slides.
    still: f64,
    sign: i8,
    offset: f64,
    /// To the joint before.
    coupling: f64,
}

impl Row {
    fn turning(a: f64, alpha: f64, d: f64) -> Self {
        Self {
            kind: JointKind::Revolute,
            a,
            alpha,
            still: d,
            sign: 1,
            offset: 0.0,
            coupling: 0.0,
        }
    }
}

/// The model file of a table, with `more` behind each joint.
fn file(convention: &str, rows: &[Row], more: &[String]) -> String {
    let mut text = format!(
        "name = \"drawn\"\nmanufacturer = \"nobody\"\nconvention = \"{convention}\"\n\
         [base]\nx_mm = 100.0\ny_mm = 20.0\nz_mm = 300.0\nw_deg = 20.0\np_deg = -30.0\nr_deg = 40.0\n\
         [flange]\nx_mm = 10.0\ny_mm = 20.0\nz_mm = 30.0\nw_deg = 50.0\np_deg = 60.0\nr_deg = 70.0\n"
    );
    let mut before: Option<(usize, JointKind)> = None;
    for (index, row) in rows.iter().enumerate() {
        let Row {
            a,
            alpha,
            still,
            sign,
            offset,
            coupling,
            ..
        } = row;
        let (kind, unit, key) = match row.kind {
            JointKind::Revolute => ("revolute", "deg", "d_mm"),
            JointKind::Prismatic => ("prismatic", "mm", "theta_deg"),
        };
        writeln!(
            text,
            "[[joints]]\naxis = \"J{index}\"\nkind = \"{kind}\"\na_mm = {a}\nalpha_deg = {alpha}\n{key} = {still}\n\
             sign = {sign}\noffset_{unit} = {offset}\nmin_{unit} = -180.0\nmax_{unit} = 180.0\nhome_{unit} = 0.0\n\
             max_speed_{unit}_s = 90.0\nmax_acceleration_{unit}_s2 = 90.0"
        )
        .unwrap();
        if let Some((before, kind)) = before {
            // Millimeters and radians: a coupling of a screw is of another size.
            let factor = match (row.kind, kind) {
                (JointKind::Revolute, JointKind::Prismatic) => coupling * 1e-3,
                (JointKind::Prismatic, JointKind::Revolute) => coupling * 1e2,
                _ => *coupling,
            };
            writeln!(
                text,
                "couplings = [{{ joint = \"J{before}\", factor = {factor} }}]"
            )
            .unwrap();
        }
        before = Some((index, row.kind));
        text.push_str(more.get(index).map_or("", String::as_str));
    }
    text
}

/// Masses at points of a link's frame, in kilograms and meters.
type Points = Vec<(f64, Vector3<f64>)>;

fn inertia(points: &Points) -> LinkInertia {
    let mass: f64 = points.iter().map(|(mass, _)| mass).sum();
    let center = points.iter().map(|(m, r)| r * *m).sum::<Vector3<f64>>() / mass;
    let mut inertia = Matrix3::zeros();
    for (mass, r) in points {
        let r = r - center;
        inertia += (Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose()) * *mass;
    }
    let rows = inertia.transpose().data.0;
    LinkInertia::try_new(mass, center.into(), rows).unwrap()
}

/// An arm of point masses, and how it moves.
#[derive(Debug)]
struct Drawn {
    arm: SerialArm,
    links: Vec<Points>,
    payload: Points,
    /// Values in radians and meters.
    state: Vec<[f64; 3]>,
}

impl Drawn {
    fn load(&self) -> Load {
        Load {
            payload: Some(inertia(&self.payload)),
            ..Load::default()
        }
    }

    /// In the arm's own units.
    fn joint_state(&self) -> JointState {
        let own = |part: fn(&[f64; 3]) -> f64| -> Vec<f64> {
            let kinds = self.arm.joint_list().iter().map(|joint| joint.kind);
            kinds
                .zip(&self.state)
                .map(|(kind, state)| in_own_unit(kind, part(state)))
                .collect()
        };
        let joints = self.arm.joints_from_radians(&own(|[q, ..]| *q)).unwrap();
        let (rates, accelerations) = (own(|[_, v, _]| *v), own(|[.., a]| *a));
        self.arm.state(&joints, &rates, &accelerations).unwrap()
    }

    /// The state after `time`, with constant accelerations, and one joint `off`.
    fn values_at(&self, time: f64, off: (usize, f64)) -> Vec<f64> {
        let moved = self.state.iter().enumerate().map(|(index, [q, v, a])| {
            let off = if index == off.0 { off.1 } else { 0.0 };
            q + v * time + a * time * time / 2.0 + off
        });
        moved.collect()
    }

    /// All point masses in the world.
    fn points_at(&self, values: &[f64]) -> Points {
        let kinds = self.arm.joint_list().iter().map(|joint| joint.kind);
        let own: Vec<f64> = kinds.zip(values).map(|(k, v)| in_own_unit(k, *v)).collect();
        let joints = self.arm.joints_from_radians(&own).unwrap();
        let frames = self.arm.frames(&joints).unwrap();
        let bodies = self.links.iter().chain([&self.payload]);
        let placed = frames
            .iter()
            .skip(1)
            .zip(bodies)
            .flat_map(|(frame, points)| {
                let place = frame.isometry();
                points.iter().map(move |(mass, r)| {
                    let world = place.rotation * r + place.translation.vector / 1000.0;
                    (*mass, world)
                })
            });
        placed.collect()
    }

    fn points_after(&self, time: f64) -> Points {
        self.points_at(&self.values_at(time, (usize::MAX, 0.0)))
    }

    /// Kinetic and potential energy.
    fn energy_after(&self, time: f64) -> f64 {
        let parts = slopes(|t| self.points_after(time + t));
        let here = self.points_after(time);
        let energies = here
            .iter()
            .zip(&parts)
            .map(|((mass, r), v)| mass * (v.norm_squared() / 2.0 + STANDARD_GRAVITY * r.z));
        energies.sum()
    }
}

fn in_own_unit(kind: JointKind, value: f64) -> f64 {
    match kind {
        JointKind::Revolute => value,
        JointKind::Prismatic => value * 1000.0,
    }
}

/// The step of differences of the fourth order.
const STEP: f64 = 2e-3;

/// First derivatives at 0.
fn slopes(at: impl Fn(f64) -> Points) -> Vec<Vector3<f64>> {
    let around = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * STEP));
    let [a, b, c, d] = &around;
    let all = a.iter().zip(b).zip(c).zip(d);
    all.map(|(((a, b), c), d)| ((a.1 - d.1) + (c.1 - b.1) * 8.0) / (12.0 * STEP))
        .collect()
}

/// Second derivatives at 0.
fn bends(at: impl Fn(f64) -> Points) -> Vec<Vector3<f64>> {
    let around = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| at(k * STEP));
    let [a, b, here, c, d] = &around;
    let all = a.iter().zip(b).zip(here).zip(c).zip(d);
    all.map(|((((a, b), here), c), d)| {
        (-(a.1 + d.1) + (b.1 + c.1) * 16.0 - here.1 * 30.0) / (12.0 * STEP * STEP)
    })
    .collect()
}

fn any_row() -> impl Strategy<Value = Row> {
    let angle = prop_oneof![
        Just(0.0),
        Just(90.0),
        Just(-90.0),
        Just(180.0),
        -180.0..180.0
    ];
    let length = || prop_oneof![Just(0.0), -800.0..800.0];
    let kind = prop_oneof![
        3 => Just(JointKind::Revolute),
        1 => Just(JointKind::Prismatic)
    ];
    let sign = prop_oneof![Just(1_i8), Just(-1)];
    let coupling = prop_oneof![2 => Just(0.0), 1 => -1.0..1.0];
    let numbers = (length(), angle, length(), -90.0..90.0, coupling);
    (kind, numbers, sign).prop_map(|(kind, (a, alpha, still, offset, coupling), sign)| Row {
        kind,
        a,
        alpha,
        still,
        sign,
        offset,
        coupling,
    })
}

/// Never all in one plane.
fn any_points() -> impl Strategy<Value = Points> {
    let place = prop::array::uniform3(-0.5..0.5_f64).prop_map(Vector3::from);
    prop::collection::vec((0.2..5.0_f64, place), 3).prop_map(|mut points| {
        let corners = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        points.extend(corners.map(|corner| (0.5, corner * 0.3)));
        points
    })
}

fn any_arm() -> impl Strategy<Value = Drawn> {
    let rows = prop::collection::vec(any_row(), 1..11);
    let convention = prop_oneof![Just("standard"), Just("modified")];
    let drawn = (rows, convention).prop_filter_map("one line", |(rows, convention)| {
        SerialArm::from_toml(&file(convention, &rows, &[])).ok()
    });
    drawn.prop_flat_map(|arm| {
        let count = arm.degrees_of_freedom();
        let links = prop::collection::vec(any_points(), count);
        let motion = prop::array::uniform3(-1.5..1.5_f64);
        let state = prop::collection::vec(motion, count);
        (Just(arm), links, any_points(), state).prop_map(|(arm, links, payload, state)| {
            let inertias: Vec<LinkInertia> = links.iter().map(inertia).collect();
            Drawn {
                arm: arm.with_inertias(&inertias).unwrap(),
                links,
                payload,
                state,
            }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// D'Alembert: what the joints do on a small way is what accelerates and lifts every point.
    #[test]
    fn torques_are_what_moves_the_points(drawn in any_arm()) {
        let dynamics = InverseDynamics::of(&drawn.arm, &drawn.load()).unwrap();
        let torques = dynamics.torques(&drawn.joint_state()).unwrap();
        let accelerations = bends(|time| drawn.points_after(time));
        let here = drawn.points_after(0.0);
        for (joint, torque) in torques.iter().enumerate() {
            let ways = slopes(|off| drawn.points_at(&drawn.values_at(0.0, (joint, off))));
            let mut wanted = 0.0;
            let mut size = 1.0;
            for (((mass, _), acceleration), way) in here.iter().zip(&accelerations).zip(&ways) {
                let force = (acceleration + Vector3::z() * STANDARD_GRAVITY) * *mass;
                wanted += force.dot(way);
                size += force.norm() * way.norm();
            }
            prop_assert!((torque - wanted).abs() < 1e-7 * size, "{joint}: {torque} {wanted}");
        }
    }

    /// The drives' power is what the kinetic and the potential energy grow by.
    #[test]
    fn power_becomes_energy(drawn in any_arm()) {
        let dynamics = InverseDynamics::of(&drawn.arm, &drawn.load()).unwrap();
        let torques = dynamics.torques(&drawn.joint_state()).unwrap();
        let power: f64 = torques.iter().zip(&drawn.state).map(|(torque, [_, rate, _])| torque * rate).sum();
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| drawn.energy_after(k * STEP));
        let growth = ((a - d) + (c - b) * 8.0) / (12.0 * STEP);
        let size = 1.0 + drawn.energy_after(0.0).abs() + power.abs();
        prop_assert!((power - growth).abs() < 1e-6 * size, "{power} {growth}");
    }

    /// A still arm's torques for its payload are the Jacobian's transpose times the weight.
    #[test]
    fn a_still_arm_holds_its_payload_by_the_jacobian(drawn in any_arm()) {
        let held = LinkInertia::point(2.5, [0.0; 3]).unwrap();
        let torques = |payload: Option<LinkInertia>| {
            let load = Load { payload, ..Load::default() };
            let dynamics = InverseDynamics::of(&drawn.arm, &load).unwrap();
            let state = drawn.joint_state();
            let values: Vec<f64> = state.as_slice().iter().map(|[q, ..]| *q).collect();
            let joints = drawn.arm.joints_from_radians(&values).unwrap();
            let none = vec![0.0; values.len()];
            let still = drawn.arm.state(&joints, &none, &none).unwrap();
            (joints, dynamics.torques(&still).unwrap())
        };
        let (joints, with) = torques(Some(held));
        let (_, without) = torques(None);
        let jacobian = drawn.arm.jacobian(&joints).unwrap();
        let columns = jacobian.row(2).iter().copied().collect::<Vec<_>>();
        let kinds = drawn.arm.joint_list().iter().map(|joint| joint.kind);
        for (((with, without), up), kind) in with.iter().zip(&without).zip(columns).zip(kinds) {
            // The Jacobian has millimeters for each radian or millimeter.
            let up = match kind {
                JointKind::Revolute => up / 1000.0,
                JointKind::Prismatic => up,
            };
            prop_assert!((with - without - up * 2.5 * STANDARD_GRAVITY).abs() < 1e-9);
        }
    }

    /// Four at a time and one by one, with each kind of instructions.
    #[test]
    fn a_batch_gives_the_torques_of_one_state_at_a_time(drawn in any_arm(), count in 0_usize..10) {
        let dynamics = InverseDynamics::of(&drawn.arm, &drawn.load()).unwrap();
        let states: Vec<JointState> = (0_u32..).take(count).map(|index| {
            let later = drawn.values_at(f64::from(index) * 0.1, (usize::MAX, 0.0));
            let state = later.iter().zip(&drawn.state).map(|(q, [_, v, a])| [*q, *v, *a]);
            Drawn { arm: drawn.arm.clone(), links: Vec::new(), payload: Vec::new(), state: state.collect() }.joint_state()
        }).collect();
        for kind in [Instructions::Portable, Instructions::Avx2, Instructions::Best] {
            let Some(dynamics) = dynamics.with(kind) else { continue };
            let mut seen = 0;
            dynamics.torques_batch(&states, |index, torques| {
                assert_eq!(index, seen);
                seen += 1;
                let alone = dynamics.torques(&states[index]).unwrap();
                assert_eq!(alone.len(), torques.len());
                for (alone, torque) in alone.iter().zip(torques) {
                    assert!((alone - torque).abs() < 1e-9 * (1.0 + alone.abs()), "{alone} {torque}");
                }
            }).unwrap();
            prop_assert_eq!(seen, states.len());
        }
    }
}

/// Two links in a vertical plane: 1 m long, 2 and 1 kg, centers in their middles, 0.2 and 0.1 kg m^2
/// about them. With c2 = cos q2 and so on:
///
/// ```text
/// M11 = 2 * 0.25 + 0.2 + 1 * (1 + 0.25 + c2) + 0.1 = 2.05 + c2
/// M12 = 1 * (0.25 + 0.5 c2) + 0.1 = 0.35 + 0.5 c2        M22 = 0.25 + 0.1 = 0.35
/// t1 = M11 q1'' + M12 q2'' - 0.5 s2 (2 q1' q2' + q2'^2) + (2 * 0.5 + 1) g c1 + 0.5 g c12
/// t2 = M12 q1'' + M22 q2'' + 0.5 s2 q1'^2 + 0.5 g c12
/// ```
#[test]
fn two_links_are_as_by_hand() {
    let link = |mass: f64, about: f64| {
        let slim = about / 2.0;
        let moments = [[slim, 0.0, 0.0], [0.0, about, 0.0], [0.0, 0.0, about]];
        // In the table's frame, which is at the link's end.
        LinkInertia::try_new(mass, [-0.5, 0.0, 0.0], moments).unwrap()
    };
    let rows = [
        Row::turning(1000.0, 0.0, 0.0),
        Row::turning(1000.0, 0.0, 0.0),
    ];
    let arm = SerialArm::from_toml(&file("standard", &rows, &[])).unwrap();
    let arm = arm
        .with_inertias(&[link(2.0, 0.2), link(1.0, 0.1)])
        .unwrap();
    // Down is -Y of the base, and g is 10.
    let load = Load {
        gravity_m_s2: arm.base().isometry().rotation * Vector3::new(0.0, -10.0, 0.0),
        payload: None,
    };
    let dynamics = InverseDynamics::of(&arm, &load).unwrap();
    for (joints, rates, accelerations, wanted) in [
        // c1 = 1, c2 = 0, s2 = 1, c12 = 0: 2.05 * 3 + 0.35 * 4 - 0.5 * (4 + 4) + 20, and
        // 0.35 * 3 + 0.35 * 4 + 0.5.
        ([0.0, 90.0], [1.0, 2.0], [3.0, 4.0], [23.55, 2.95]),
        // c1 = c2 = c12 = 1, s2 = 0: 3.05 * 3 + 0.85 * 4 + 20 + 5, and 0.85 * 3 + 0.35 * 4 + 5.
        ([0.0, 0.0], [1.0, 2.0], [3.0, 4.0], [37.55, 8.95]),
        // Upright and still: nothing to hold.
        ([90.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]),
        // c1 = 0, c2 = 0, s2 = 1, c12 = -1: 0.5 * -(2 * -1 * 3 + 9) - 5, and 0.5 - 5.
        ([90.0, 90.0], [-1.0, 3.0], [0.0, 0.0], [-6.5, -4.5]),
    ] {
        let joints = arm.joints(&joints).unwrap();
        let state = arm.state(&joints, &rates, &accelerations).unwrap();
        let found = dynamics.torques(&state).unwrap();
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
    }
}

/// A quill of 3 kg with a payload of 2 kg: its weight and what accelerates it, whatever the arm
/// before it weighs.
#[test]
fn a_quill_that_slides_down_is_as_by_hand() {
    let arm = SerialArm::builtin("scara").unwrap();
    let ball = |mass| {
        let moments = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
        LinkInertia::try_new(mass, [0.0; 3], moments).unwrap()
    };
    let arm = arm
        .with_inertias(&[ball(9.0), ball(8.0), ball(2.0), ball(1.0)])
        .unwrap();
    let load = Load {
        payload: Some(LinkInertia::point(2.0, [0.0, 0.0, 0.1]).unwrap()),
        ..Load::default()
    };
    let joints = arm.joints(&[10.0, 20.0, 100.0, 30.0]).unwrap();
    // The quill's value counts downwards: 5 kg fall with 4 m/s^2.
    let state = arm
        .state(&joints, &[0.0; 4], &[0.0, 0.0, 4000.0, 0.0])
        .unwrap();
    let torques = InverseDynamics::of(&arm, &load)
        .unwrap()
        .torques(&state)
        .unwrap();
    let wanted = [0.0, 0.0, 5.0 * (4.0 - STANDARD_GRAVITY), 0.0];
    for (found, wanted) in torques.iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    }
}

/// The file's frames are those of its own table, Craig's links in the modified convention.
#[test]
fn a_modified_file_has_its_inertias_in_its_own_frames() {
    let rows = [
        Row::turning(0.0, 0.0, 340.0),
        Row::turning(50.0, -90.0, 20.0),
        Row::turning(400.0, 30.0, -60.0),
    ];
    let (mass, center) = (3.0, Vector3::new(0.1, -0.2, 0.3));
    let matrix = Matrix3::new(0.30, 0.02, 0.01, 0.02, 0.40, -0.03, 0.01, -0.03, 0.50);
    let more = "mass_kg = 3.0\ncenter_of_mass_m = [0.1, -0.2, 0.3]\n\
                inertia_kg_m2 = [[0.30, 0.02, 0.01], [0.02, 0.40, -0.03], [0.01, -0.03, 0.50]]\n";
    let more = vec![more.to_owned(); 3];
    let arm = SerialArm::from_toml(&file("modified", &rows, &more)).unwrap();
    let shown = [20.0, -50.0, 80.0];
    let frames = arm.frames(&arm.joints(&shown).unwrap()).unwrap();
    // The file's base; the arm's has the way of the first row in it.
    let as_standard = SerialArm::from_toml(&file("standard", &rows[..1], &[])).unwrap();
    let mut product = as_standard.base().isometry().to_homogeneous();
    for (index, (row, q)) in rows.iter().zip(shown).enumerate() {
        let ((sa, ca), (s, c)) = (row.alpha.to_radians().sin_cos(), q.to_radians().sin_cos());
        // Craig, Introduction to Robotics, (3.6).
        #[rustfmt::skip]
        let link = Matrix4::new(
            c,      -s,      0.0, row.a,
            s * ca, c * ca,  -sa, -sa * row.still,
            s * sa, c * sa,  ca,  ca * row.still,
            0.0,    0.0,     0.0, 1.0,
        );
        product *= link;
        let found = arm.joint_list()[index]
            .inertia
            .unwrap()
            .seen_from(&frames[index + 1]);
        let place = product.fixed_view::<3, 1>(0, 3) / 1000.0;
        let turn = product.fixed_view::<3, 3>(0, 0);
        assert!((found.mass_kg() - mass).abs() < 1e-12);
        assert!((found.center_of_mass_m() - (turn * center + place)).norm() < 1e-12);
        let turned = turn * matrix * turn.transpose();
        assert!((found.inertia_kg_m2() - turned).amax() < 1e-12);
    }
}

/// The five-link arm's numbers are an assumption; what they have to hold is not.
#[test]
fn the_five_link_arm_hangs_still_and_has_to_be_held_when_lifted() {
    let arm = SerialArm::builtin("five-link").unwrap();
    let dynamics = InverseDynamics::of(arm, &Load::default()).unwrap();
    let still = |shown: [f64; 5]| {
        let joints = arm.joints(&shown).unwrap();
        let state = arm.state(&joints, &[0.0; 5], &[0.0; 5]).unwrap();
        dynamics.torques(&state).unwrap()
    };
    assert!(still([0.0; 5]).iter().all(|torque| torque.abs() < 1e-12));
    // B lifts the arm to the level: every weight times its way out from B's axis. Link B's center
    // is 0.11 m out, link C's 0.3 m, D's 0.4 m, E's 0.64 m.
    let b = still([0.0, 90.0, 0.0, 0.0, 0.0])[1];
    let wanted = STANDARD_GRAVITY * (3.0 * 0.11 + 1.5 * 0.3 + 2.0 * 0.4 + 0.8 * 0.64);
    assert!((b.abs() - wanted).abs() < 1e-9, "{b} {wanted}");
}

#[test]
fn arms_without_inertias_say_whose_are_missing() {
    let arm = SerialArm::builtin("fanuc-m20ia").unwrap();
    let error = InverseDynamics::of(arm, &Load::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "fanuc-m20ia has no mass_kg, center_of_mass_m and inertia_kg_m2 of J1, J2, J3, J4, J5, J6; every link needs them"
    );
    let arm = SerialArm::builtin("five-link").unwrap();
    let load = Load {
        gravity_m_s2: Vector3::new(0.0, f64::NAN, 0.0),
        payload: None,
    };
    let error = InverseDynamics::of(arm, &load).unwrap_err();
    assert!(
        matches!(error, DynamicsError::Gravity { axis: "y", .. }),
        "{error}"
    );
    let dynamics = InverseDynamics::of(arm, &Load::default()).unwrap();
    let scara = SerialArm::builtin("scara").unwrap();
    let other = scara.state(&scara.home(), &[0.0; 4], &[0.0; 4]).unwrap();
    assert!(dynamics.torques(&other).is_err());
    assert!(dynamics.torques_batch(&[other], |_, _| ()).is_err());
    assert!(scara.state(&scara.home(), &[0.0; 3], &[0.0; 4]).is_err());
    assert!(
        scara
            .state(&scara.home(), &[0.0, f64::NAN, 0.0, 0.0], &[0.0; 4])
            .is_err()
    );
}

#[test]
fn inertias_that_no_link_has_are_refused_with_link_value_and_limit() {
    let rows = [
        Row::turning(100.0, 90.0, 0.0),
        Row::turning(100.0, 0.0, 0.0),
    ];
    let good = [
        "1.0",
        "[0.1, 0.0, 0.0]",
        "[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]",
    ];
    let read = |mass: &str, center: &str, inertia: &str| {
        let more =
            format!("mass_kg = {mass}\ncenter_of_mass_m = {center}\ninertia_kg_m2 = {inertia}\n");
        SerialArm::from_toml(&file("standard", &rows, &[String::new(), more]))
    };
    let [mass, center, inertia] = good;
    assert!(read(mass, center, inertia).is_ok());
    for (found, wanted) in [
        (
            read("0.0", center, inertia),
            "J1: mass_kg is 0; it must be above 0 and not above 1000000",
        ),
        (
            read(mass, "[0.0, 200.0, 0.0]", inertia),
            "J1: center_of_mass_m has 200 for y; it must be a number from -100 to 100",
        ),
        (
            read(
                mass,
                center,
                "[[0.1, 0.0, nan], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]",
            ),
            "J1: inertia_kg_m2 has NaN for xz; it must be a number from -1000000000 to 1000000000",
        ),
        (
            read(
                mass,
                center,
                "[[0.1, 0.01, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]",
            ),
            "J1: inertia_kg_m2 has 0.01 for xy and 0 across the diagonal; they must be the same",
        ),
        (
            read(
                mass,
                center,
                "[[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]",
            ),
            "J1: inertia_kg_m2 has the principal moment 0; each must be above 0",
        ),
        (
            read(
                mass,
                center,
                "[[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.25]]",
            ),
            "J1: inertia_kg_m2 has the principal moment 1; it must not be above the sum of the other two, 0.75",
        ),
    ] {
        assert_eq!(found.unwrap_err().to_string(), wanted);
    }
    let part = file("standard", &rows, &["mass_kg = 2.0\n".to_owned()]);
    let error = SerialArm::from_toml(&part).unwrap_err();
    assert_eq!(
        error.to_string(),
        "J0: center_of_mass_m is missing; mass_kg, center_of_mass_m and inertia_kg_m2 are given together"
    );
    assert!(matches!(error, SerialModelError::InertiaPart { .. }));
    let heavy = LinkInertia::point(f64::INFINITY, [0.0; 3]);
    assert!(matches!(heavy, Err(InertiaError::Mass { .. })));
}
