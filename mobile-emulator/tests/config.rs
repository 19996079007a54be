//! Configuration files and the command line.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

use std::process::{Command, Output};

use mobile_emulator::MobileConfig;

fn refusal(text: &str) -> String {
    match MobileConfig::from_toml(text) {
        Err(error) => error.to_string(),
        Ok(config) => config.check().unwrap_err().to_string(),
    }
}

fn cli(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mobile-emulator"))
        .args(arguments)
        .env_clear()
        .output()
        .unwrap()
}

#[test]
fn the_example_and_an_empty_file_make_a_robot() {
    MobileConfig::from_toml("").unwrap().check().unwrap();
    let example = include_str!("../mobile.example.toml");
    let config = MobileConfig::from_toml(example).unwrap();
    config.check().unwrap();
    assert_eq!(config.points.len(), 2);
}

#[test]
fn every_refusal_names_the_key_the_value_and_the_limit() {
    let cases = [
        ("speed_mm_s = 1", &["unknown field `speed_mm_s`"][..]),
        (
            "[drive]\nspeed_m_s = 1",
            &["`speed_m_s`", "`speed_mm_s`", "line 2"],
        ),
        (
            "[drive]\nspeed_mm_s = -1",
            &["`drive`", "-1 mm/s", "0.001 mm/s to 100000 mm/s"],
        ),
        (
            "[drive]\nacceleration_mm_s2 = 0",
            &["`drive`", "acceleration of the follower is 0"],
        ),
        ("[drive]\nspeed_mm_s = nan", &["`drive`", "NaN"]),
        ("id = ''", &["`id`", "1 to 64"]),
        ("id = 'a/b'", &["`id`", "`/`"]),
        (
            "step_ms = 0",
            &["`step_ms`", "is 0; it must be from 1 to 100"],
        ),
        (
            "heartbeat_s = 0.01",
            &["`heartbeat_s`", "0.01", "from 0.1 to 60"],
        ),
        (
            "[base]\nwheel_radius_mm = 0",
            &["`base`", "wheel radius is 0 mm"],
        ),
        (
            "[guard]\nstop_distance_mm = 200",
            &["`guard`", "resume distance is 150 mm", "200 mm"],
        ),
        (
            "[docking]\ntolerance_mm = 0",
            &["`docking.tolerance_mm`", "from 0.5 to 1000"],
        ),
        (
            "[battery]\nempty_percent = 30",
            &["`battery.empty_percent`", "from 0 to 20"],
        ),
        (
            "[link]\npoll_wait_s = 31",
            &["`link.poll_wait_s`", "from 0 to 30"],
        ),
        (
            "[link]\nretry_last_ms = 1",
            &["`link.retry_last_ms`", "250"],
        ),
        (
            "[[slots]]\nid='a'\n[[slots]]\nid='a'",
            &["`slots[1].id`", "two slots `a`"],
        ),
        (
            "[[slots]]\nid='a'\nload='x'\n[[slots]]\nid='b'\nload='x'",
            &["`slots[1].load`", "`x` lies in two slots"],
        ),
        (
            "[[points]]\nid='s/p'\npose={x_mm=0,y_mm=0,heading_deg=0}\nzone={min_x_mm=1,min_y_mm=0,max_x_mm=0,max_y_mm=1}",
            &["`points[0].zone`", "max_x_mm is 0", "min_x_mm, which is 1"],
        ),
        (
            "[[obstacles]]\nx_mm=0\ny_mm=0\nradius_mm=0",
            &["`obstacles[0]`", "radius of the obstacle is 0 mm"],
        ),
        (
            "[[faults]]\nfault='LATE'\ndelay_s=-1",
            &["`faults[0]`", "delay_s is -1"],
        ),
        (
            "[[faults]]\nfault='LOAD_MISSING'\nslot='z'",
            &["`faults[0]`", "no slot `z`"],
        ),
        ("[view]\naddress='here'", &["address"]),
    ];
    for (text, wanted) in cases {
        let said = refusal(text);
        for part in wanted {
            assert!(
                said.contains(part),
                "{text:?} says {said:?}, without {part:?}"
            );
        }
    }
}

#[test]
fn check_says_which_file_and_what() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.toml");
    let bad = folder.path().join("bad.toml");
    std::fs::write(&good, include_str!("../mobile.example.toml")).unwrap();
    std::fs::write(&bad, "[docking]\nstandoff_mm = 1").unwrap();
    let [good, bad] = [good, bad].map(|path| path.display().to_string());
    assert_eq!(cli(&["check", &good]).status.code(), Some(0));
    let output = cli(&["check", &good, &bad]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    for part in ["bad.toml", "`docking.standoff_mm`", "standoff_mm is 1"] {
        assert!(said.contains(part), "{said}");
    }
    assert!(!said.contains("good.toml"), "{said}");
}

#[test]
fn run_names_what_it_cannot_use() {
    let cases: [(&[&str], &str); 3] = [
        (
            &[
                "run",
                "--config",
                "/nowhere.toml",
                "--cell",
                "http://127.0.0.1:1",
            ],
            "reading /nowhere.toml",
        ),
        (&["run", "--cell", "http://127.0.0.1:1"], "--config"),
        (&["fly"], "fly"),
    ];
    for (arguments, wanted) in cases {
        let output = cli(arguments);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(wanted), "{said}");
    }
}
