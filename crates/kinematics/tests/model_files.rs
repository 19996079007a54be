//! Model files: what is read, what is refused, and that any covered arm works.

mod support;

use std::error::Error;
use std::fmt::Write;

use kinematics::serial::SerialArm;
use kinematics::{ArmModel, Axis, Seed};
use proptest::prelude::*;
use support::{apart_but_for_turns, arm, assert_same_pose, inside, joints};
use units::{DegPerSec, DegPerSec3, Degrees};

const M20IA: &str = include_str!("../models/fanuc_m20ia.toml");

/// The M-20iA's file with the `nth` occurrence of `key` changed.
fn with(key: &str, nth: usize, value: &str) -> String {
    let mut seen = 0;
    let mut line = |line: &str| {
        if !line.starts_with(&format!("{key} = ")) {
            return line.to_owned();
        }
        seen += 1;
        if seen == nth {
            format!("{key} = {value}")
        } else {
            line.to_owned()
        }
    };
    M20IA.lines().map(&mut line).collect::<Vec<_>>().join("\n")
}

/// The error and its causes.
fn refused(text: &str) -> String {
    let error = ArmModel::from_toml(text).expect_err(text);
    let mut told = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        told = format!("{told}: {error}");
        cause = error.source();
    }
    told
}

#[test]
fn every_built_in_model_is_valid() {
    for name in ArmModel::builtin_names() {
        assert_eq!(ArmModel::builtin(name).unwrap().name(), *name);
    }
    assert!(ArmModel::builtin("no-such-arm").is_none());
}

#[test]
fn a_capsule_that_is_none_is_refused_by_number_and_item() {
    let refused_by_both = |text: &str, wanted: &str| {
        assert_eq!(refused(text), wanted);
        let serial = SerialArm::from_toml(text).unwrap_err();
        assert_eq!(serial.to_string(), wanted);
    };
    refused_by_both(
        &with("radius_mm", 2, "0.0"),
        "capsule 2: radius is 0; sizes are positive, coordinates within 100 m",
    );
    refused_by_both(
        &with("radius_mm", 1, "nan"),
        "capsule 1: radius is NaN; sizes are positive, coordinates within 100 m",
    );
    refused_by_both(
        &with("from_mm", 4, "[0.0, -inf, 0.0]"),
        "capsule 4: from is -inf; sizes are positive, coordinates within 100 m",
    );
    refused_by_both(
        &with("to_mm", 3, "[0.0, 0.0, 2e5]"),
        "capsule 3: to is 200000; sizes are positive, coordinates within 100 m",
    );
    refused_by_both(
        &with("link", 8, "7"),
        "capsule 8 is on link 7; links are 0 to 6",
    );
    let many = "[[capsules]]\nlink = 1\nfrom_mm = [0.0, 0.0, 0.0]\nto_mm = [0.0, 0.0, 0.0]\nradius_mm = 1.0\n";
    refused_by_both(
        &format!("{M20IA}\n{}", many.repeat(64)),
        "72 capsules; an arm has at most 64",
    );
    assert!(refused(&with("from_mm", 1, "[0.0, 0.0]")).starts_with("reading the model file"));
    assert_eq!(arm().capsules().len(), 8);
    let serial = SerialArm::builtin("fanuc-m20ia").unwrap();
    assert_eq!(serial.capsules(), arm().capsules());
}

#[test]
fn the_m20ia_is_as_its_sources_say() {
    assert_eq!(arm().manufacturer(), "FANUC");
    assert_eq!(arm().limits(Axis::J3).max, Degrees(200.0));
    assert_eq!(arm().max_speed(Axis::J6), DegPerSec(550.0));
    // Not in the file: ten times the acceleration. In it: what it says.
    assert_eq!(arm().max_jerk(Axis::J1), DegPerSec3(3900.0));
    let given = with(
        "max_acceleration_deg_s2",
        1,
        "390.0\nmax_jerk_deg_s3 = 1234.0",
    );
    let given = ArmModel::from_toml(&given).unwrap();
    assert_eq!(given.max_jerk(Axis::J1), DegPerSec3(1234.0));
    assert_eq!(arm().home(), joints([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]));
    assert!((arm().dh()[1].a.0 - 790.0).abs() < 1e-12);
}

#[test]
fn a_file_that_is_wrong_is_refused_by_key_and_value() {
    for (text, told) in [
        (
            with("min_deg", 1, "nan"),
            "J1: min_deg is NaN; it must be a number from -3600 to 3600",
        ),
        (
            with("d_mm", 4, "inf"),
            "J4: d_mm is inf; it must be a number from -100000 to 100000",
        ),
        (
            with("min_deg", 2, "95.0"),
            "J2: min_deg is 95, which is not below max_deg 90",
        ),
        (
            with("home_deg", 5, "150.0"),
            "J5: home_deg is 150; the limits are -140 to 140",
        ),
        (with("sign", 3, "2"), "J3: sign is 2; it must be 1 or -1"),
        (
            with("j2_coupling", 1, "5"),
            "J3: j2_coupling is 5; it must be -1, 0 or 1",
        ),
        (with("name", 1, "\" \""), "name is empty; it must be a text"),
        (
            with("max_acceleration_deg_s2", 6, "1.0\nmax_jerk_deg_s3 = -1.0"),
            "J6: max_jerk_deg_s3 is -1; it must be above 0 and not above 10000000",
        ),
        (
            with("max_speed_deg_s", 6, "0.0"),
            "J6: max_speed_deg_s is 0; it must be above 0 and not above 10000",
        ),
        (
            with("axis", 3, "\"J4\""),
            "joint number 3 of the file is called \"J4\"; it must be J3",
        ),
        (
            with("a_mm", 2, "0.0"),
            "J2: a_mm is 0, and the upper arm would have to be longer than 0",
        ),
        (with("alpha_deg", 2, "30.0"), "and it would have to be 0"),
        (
            with("alpha_deg", 1, "80.0"),
            "and it would have to be 90 or -90",
        ),
        (
            with("d_mm", 5, "80.0"),
            "J5: d_mm is 80, and it would have to be 0",
        ),
        (
            with("a_mm", 4, "20.0"),
            "J4: a_mm is 20, and it would have to be 0",
        ),
        (
            with("sign", 1, "\"up\""),
            "reading the model file: TOML parse error",
        ),
        (
            format!("colour = \"yellow\"\n{M20IA}"),
            "unknown field `colour`",
        ),
        (M20IA.replace("d_mm", "d_m"), "unknown field `d_m`"),
        (
            with("home_deg", 1, "0.0\nj2_coupling = 1"),
            "J1: j2_coupling is 1; it must be 0",
        ),
        (String::new(), "missing field `name`"),
    ] {
        let refusal = refused(&text);
        assert!(refusal.contains(told), "{told:?} is not in {refusal:?}");
    }
}

#[test]
fn a_wrist_that_is_not_spherical_is_said_to_be_not_covered() {
    let refusal = refused(&with("d_mm", 5, "80.0"));
    assert!(
        refusal.contains("the closed form covers arms with J2 and J3 parallel"),
        "{refusal}"
    );
}

#[test]
fn a_file_without_six_joints_is_refused() {
    let five = M20IA.rsplit_once("[[joints]]").unwrap().0;
    assert_eq!(refused(five), "the file has 5 joints; it must have 6");
    let seventh = M20IA.rsplit_once("[[joints]]").unwrap().1;
    let seven = format!("{M20IA}\n[[joints]]{seventh}");
    assert_eq!(refused(&seven), "the file has 7 joints; it must have 6");
}

/// A file of some other arm: any twists, any signs, a lateral offset.
fn any_arm() -> impl Strategy<Value = ArmModel> {
    let signs = prop::array::uniform10(prop::sample::select(vec![-1.0, 1.0]));
    let lengths = prop::array::uniform8(-300.0..300.0_f64);
    (signs, lengths, -1..=1_i8, prop::bool::ANY).prop_map(|(signs, lengths, coupling, positive)| {
        let [t1, t3, t4, t5, s1, s2, s3, s4, s5, s6] = signs;
        let [d1, d2, d3, d4, d6, a1, a2, a3] = lengths;
        let side = if positive { "positive" } else { "negative" };
        let mut text = format!("name = \"any\"\nmanufacturer = \"any\"\nno_flip_j5 = \"{side}\"\n");
        for (axis, d, a, alpha, sign, offset, coupling) in [
            ("J1", d1, a1, 90.0 * t1, s1, 10.0, 0),
            ("J2", d2 / 10.0, 400.0 + a2, 0.0, s2, 90.0, 0),
            ("J3", d3 / 10.0, a3, 90.0 * t3, s3, -90.0, coupling),
            (
                "J4",
                d4 + 400.0_f64.copysign(d4),
                0.0,
                90.0 * t4,
                s4,
                0.0,
                0,
            ),
            ("J5", 0.0, 0.0, 90.0 * t5, s5, 0.0, 0),
            ("J6", d6, 0.0, 0.0, s6, 180.0, 0),
        ] {
            let _ = write!(
                text,
                "[[joints]]\naxis = \"{axis}\"\nd_mm = {d:?}\na_mm = {a:?}\n\
                 alpha_deg = {alpha:?}\nsign = {sign}\noffset_deg = {offset:?}\n\
                 j2_coupling = {coupling}\nmin_deg = -175.0\nmax_deg = 170.0\n\
                 max_speed_deg_s = 100.0\nmax_acceleration_deg_s2 = 100.0\nhome_deg = 0.0\n"
            );
        }
        ArmModel::from_toml(&text).expect("a covered arm")
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_covered_arm_finds_its_way_back(
        arm in any_arm(),
        parts in prop::array::uniform6(0.0..1.0_f64),
    ) {
        let there = inside(&arm, parts);
        let pose = arm.forward(&there);
        let branches = arm.inverse_all(&pose).unwrap();
        for solution in branches.iter() {
            assert_same_pose(&arm.forward(&solution.joints), &pose, &there.to_string());
            prop_assert_eq!(solution.configuration, arm.configuration(&solution.joints));
        }
        let (_, measure) = arm.singularity(&there).nearest();
        let nearest = branches
            .iter()
            .map(|solution| apart_but_for_turns(&solution.joints, &there))
            .fold(f64::MAX, f64::min);
        prop_assert!(nearest < 1e-8 / measure.max(1e-3), "{} for {}, {}", nearest, there, measure);
        let seed = Seed::InConfiguration(arm.configuration(&there));
        prop_assert!(arm.inverse(&pose, seed).is_ok());
        let chain = arm.chain(&there);
        prop_assert!(apart_but_for_turns(&arm.pendant(&chain), &there) < 1e-9);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in ".{0,200}") {
        let _ = ArmModel::from_toml(&text);
    }
}
