//! `cellctl arm`, `plan` and `route`: answered by the program itself and by the real server, which must say the same.

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use anyhow::Result;
use tests::{CELL, Look, TestCell, wait_until};

/// What a run left behind.
#[derive(Debug, PartialEq)]
struct Ran {
    code: Option<i32>,
    said: String,
    wrong: String,
}

/// Runs the real `cellctl` in `folder` with the words of a line; with a server if there is one.
fn cellctl(folder: &Path, server: Option<&str>, line: &str) -> Result<Ran> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cellctl"));
    let words = line.split(' ');
    let _ = command.env_clear().current_dir(folder).args(words);
    if let Some(server) = server {
        let _ = command.args(["--server", server]);
    }
    let Output {
        status,
        stdout,
        stderr,
    } = command.output()?;
    Ok(Ran {
        code: status.code(),
        said: String::from_utf8(stdout)?,
        wrong: String::from_utf8(stderr)?,
    })
}

/// One command for each question; with what exit code it ends.
const COMMANDS: &[(&str, i32)] = &[
    ("arm list", 0),
    ("arm describe seven-joint --plot P.svg", 0),
    (
        "arm fk fanuc-m20ia 30 20 -20 0 -70 0 --tool 0,0,150,0,0,0 --plot P.svg",
        0,
    ),
    ("arm ik fanuc-m20ia 900 350 700 170 20 30 --plot P.svg", 0),
    (
        "arm ik fanuc-m20ia 985 0 940 180 0 0 --near 0,0,0,0,-90,0 --method quartic --json",
        0,
    ),
    (
        "arm jacobian scara 30 60 100 0 --task position --plot P.svg",
        0,
    ),
    (
        "arm rates seven-joint 0 30 0 60 0 45 0 --linear 0,50,0 --null 10,0,0,0,0,0,0 --plot P.svg",
        0,
    ),
    (
        "arm rates fanuc-m20ia 0 20 -20 0 -70 0 --linear 9000,0,0",
        1,
    ),
    (
        "arm move-velocity five-link 0 45 -60 0 30 --velocity -30,5,-2 --time 2 --plot P.svg",
        0,
    ),
    (
        "arm move-velocity five-link 0 45 -60 0 30 --velocity 60,30,20 --time 8 --plot P.svg --view joints",
        1,
    ),
    (
        "arm torques five-link 0 45 -60 0 30 --velocities 30,-10,0,20,0 --accelerations 0,90,0,0,-90 --payload 0.5 --payload-center 0,0.02,0.05 --gravity 0,1,-9.7",
        0,
    ),
    (
        "arm calibrate fanuc-m20ia --tip 5.947,-3.744,-10.630,0,-79.370,-5.947 --tip 5.280,5.018,-11.157,-2.294,-103.739,-5.333 --tip 9.238,-7.147,-11.451,18.346,-69.022,25.580 --plot P.svg",
        0,
    ),
    (
        "arm reach fanuc-m20ia --plane xz --u 0,1600 --v 0,1200 --step 200 --turn 180,0,0 --plot P.svg",
        0,
    ),
    (
        "arm reach fanuc-m20ia --plane XY --across 5000 --u 0,400 --v 0,400 --step 200",
        1,
    ),
    (
        "arm transfer fanuc-m20ia --from 60,20,-20,0,-70,0 --to -60,20,-20,0,-70,0 --keep-out 700,-100,-500,1000,100,500 --cylinder 0,1500,0,50,300 --plot P.svg",
        0,
    ),
    (
        "arm transfer fanuc-m20ia --from 60,20,-20,0,-70,0 --to-pose 985,-700,640,180,0,0 --tool 0,0,150,0,0,0 --keep-out 700,-100,-500,1000,100,500 --plot P.svg",
        0,
    ),
    (
        "arm transfer scara --from -40,30,150,0 --to 40,30,150,0 --keep-out 60,-10,0,800,10,280 --margin 5 --plot P.svg",
        0,
    ),
    (
        "plan trajectory fanuc-m20ia --kind jerk-limited --from 0,0,0,0,-90,0 --to 60,20,-20,0,-70,0 --plot P.svg",
        0,
    ),
    (
        "plan trajectory fanuc-m20ia --kind quintic --from 0,0,0,0,-90,0 --to 60,20,-20,0,-70,0 --duration 0.6 --plot P.svg --view arm",
        1,
    ),
    (
        "plan tool-path fanuc-m20ia --kind line --pose 985,0,940,180,0,0 --pose 985,300,700,180,0,0 --speed 300 --plot P.svg --view tool",
        0,
    ),
    (
        "plan tool-path fanuc-m20ia --kind line --pose 985,0,940,180,0,0 --pose 985,2300,700,180,0,0 --speed 300 --plot P.svg",
        1,
    ),
    (
        "plan tool-path scara --kind line --pose 400,-200,300,180,0,0 --pose 400,200,300,180,0,90 --speed 500 --plot P.svg",
        0,
    ),
    (
        "plan tool-path seven-joint --kind line --pose 500,-100,500,180,0,0 --pose 500,200,400,180,0,0 --speed 200 --plot P.svg --view arm",
        0,
    ),
    (
        "route plan --floor 0,0,3000,2000 --radius 200 --start 500,500 --goal 2500,500 --obstacle 1200,0,1600,0,1600,1200,1200,1200 --method roadmap --seed 3 --plot P.svg",
        0,
    ),
    (
        "route plan --floor 0,0,3000,2000 --radius 200 --start 500,500 --goal 2500,500 --plot P.svg --view wheels --heading hold",
        0,
    ),
];

#[tokio::test]
async fn a_server_answers_as_the_program_itself_does() -> Result<()> {
    let cell = TestCell::start().await?;
    let server = format!("http://{}", cell.server_address());
    let ran = tokio::task::spawn_blocking(move || -> Result<()> {
        for (line, code) in COMMANDS {
            let (here, there) = (tempfile::tempdir()?, tempfile::tempdir()?);
            let own = cellctl(here.path(), None, line)?;
            assert_eq!(
                (own.code, &*own.wrong),
                (Some(*code), ""),
                "{line}: {}",
                own.said
            );
            assert!(own.said.len() > 20, "{line}: {}", own.said);
            let asked = cellctl(there.path(), Some(&server), line)?;
            assert_eq!(own, asked, "{line}");
            if line.contains("P.svg") {
                assert!(own.said.ends_with("Wrote P.svg\n"), "{line}: {}", own.said);
                let own = std::fs::read_to_string(here.path().join("P.svg"))?;
                assert!(own.starts_with("<svg "), "{line}");
                assert_eq!(
                    own,
                    std::fs::read_to_string(there.path().join("P.svg"))?,
                    "{line}"
                );
            }
        }
        // Both refuse the same question with the same item and exit code.
        let folder = tempfile::tempdir()?;
        for (line, item) in [
            ("arm fk fanuc-m20ia 0 0 0", "joints_deg_mm"),
            ("arm fk no-such-arm 0 0 0", "no-such-arm"),
            ("arm ik fanuc-m20ia 5000 0 940 180 0 0", "3298.630 mm"),
            (
                "arm torques scara 0 0 0 0",
                "scara has no mass_kg, center_of_mass_m and inertia_kg_m2 of J1, J2, Z, J4",
            ),
        ] {
            for server in [None, Some(&*server)] {
                let ran = cellctl(folder.path(), server, line)?;
                assert_eq!(ran.code, Some(1), "{line}: {ran:?}");
                assert!(ran.wrong.contains(item), "{line}: {ran:?}");
            }
        }
        Ok(())
    });
    ran.await??;
    cell.shutdown().await
}

/// Questions that make no sense: with what exit code they end, and what is said of them.
const BAD: &[(&str, i32, &str)] = &[
    // What the program sees before any calculation.
    ("arm fk fanuc-m20ia", 2, "required"),
    ("arm fk fanuc-m20ia 0 0 x", 2, "not a number"),
    ("arm fk fanuc-m20ia 0 0 nan 0 0 0", 2, "not a finite number"),
    (
        "arm fk fanuc-m20ia 0 0 0 0 0 0 --plot a.pdf",
        2,
        "must end in `.svg` or `.png`",
    ),
    (
        "arm fk fanuc-m20ia 0 0 0 0 0 0 --tool 1,2,3",
        2,
        "3 numbers were given; it must be 6",
    ),
    (
        "arm fk fanuc-m20ia 0 0 0 0 0 0 --file unknown.json",
        2,
        "cannot be used with",
    ),
    (
        "arm fk fanuc-m20ia --file none.json",
        2,
        "reading none.json: No such file",
    ),
    (
        "arm fk fanuc-m20ia --file unknown.json",
        2,
        "unknown.json: speed: unknown field `speed`",
    ),
    (
        "arm fk fanuc-m20ia --file type.toml",
        2,
        "type.toml: joints_deg_mm[1]: invalid type",
    ),
    (
        "arm fk fanuc-m20ia --file twice.json",
        2,
        "trailing characters",
    ),
    ("arm fk fanuc-m20ia --file half.toml", 2, "half.toml: "),
    (
        "arm fk fanuc-m20ia --file words.txt",
        2,
        "`.json` or a `.toml`",
    ),
    ("arm ik fanuc-m20ia 1 2 3", 2, "6 values required"),
    ("arm ik fanuc-m20ia", 2, "the pose X Y Z W P R is missing"),
    (
        "arm move-velocity five-link 0 45 -60 0 30 --along 20",
        2,
        "--time is missing",
    ),
    ("arm reach fanuc-m20ia --plane XW", 2, "invalid value"),
    (
        "plan trajectory fanuc-m20ia --kind quintic --to 1,2,3,4,5,6",
        2,
        "--from is missing",
    ),
    (
        "route plan --floor 0,0,9,9 --radius 1 --start 2,2 --goal 7,7 --obstacle 1,2,3",
        2,
        "obstacle 1 has 3 numbers",
    ),
    (
        "route plan --floor 0,0,9,9 --radius 1 --start 2,2 --goal 7,7 --view wheels",
        2,
        "--plot",
    ),
    // What the calculation refuses.
    ("arm describe robbie", 1, "robbie"),
    ("arm fk five-link 0 0", 1, "joints_deg_mm: 2 "),
    ("arm fk fanuc-m20ia 1e9 0 0 0 0 0", 1, "joints_deg_mm[0]"),
    ("arm ik scara 9000 0 0 180 0 0", 1, "not reached"),
    (
        "arm ik fanuc-m20ia 0 0 0 0 0 0 --method five-link",
        1,
        "method",
    ),
    (
        "arm ik five-link --e 86,278,-765 --f 120,339,-900",
        1,
        "the link EF is 100",
    ),
    (
        "arm move-velocity five-link 0 45 -60 0 30 --along -1 --time 1",
        1,
        "along_tool_mm_s",
    ),
    (
        "arm move-velocity five-link 0 45 -60 0 30 --along 20 --time 1e9",
        1,
        "3600",
    ),
    (
        "arm reach fanuc-m20ia --plane XY --u 0,1 --v 0,1 --step 0",
        1,
        "step_mm",
    ),
    (
        "arm reach fanuc-m20ia --plane XY --u 0,1e6 --v 0,1e6 --step 1",
        1,
        "249999",
    ),
    (
        "arm transfer scara --from 0,0,0,0 --to 1,1,1",
        1,
        "scara has 4 joints",
    ),
    ("arm transfer scara --from 0,0,0,0", 2, "--to or --to-pose"),
    (
        "arm calibrate fanuc-m20ia --tip 0,0,0,0,0,0 --tip 0,0,0,0,0,0",
        1,
        "tip",
    ),
    (
        "plan trajectory fanuc-m20ia --kind quintic --from 0,0,0,0,0,0 --to 1,0,0,0,0,0 --duration 0",
        1,
        "durations_s",
    ),
    (
        "plan trajectory fanuc-m20ia --kind 4-3-4 --from 0,0,0,0,0,0 --to 1,0,0,0,0,0 --duration 1,1,1",
        1,
        "via_deg_mm",
    ),
    (
        "plan tool-path fanuc-m20ia --kind line --pose 985,0,940,180,0,0 --speed 100",
        1,
        "poses",
    ),
    (
        "plan tool-path fanuc-m20ia --kind line --pose 985,0,940,180,0,0 --pose 985,0,900,180,0,0 --speed 0",
        1,
        "speed_mm_s",
    ),
    (
        "route plan --floor 0,0,9,9 --radius 100 --start 2,2 --goal 7,7",
        1,
        "start_mm",
    ),
    (
        "route plan --floor 0,0,900,900 --radius 10 --start 50,50 --goal 800,800 --obstacle 100,100,200,200,200,100,100,200",
        1,
        "obstacles[0]",
    ),
];

#[test]
fn bad_questions_name_item_value_and_limit() -> Result<()> {
    let folder = tempfile::tempdir()?;
    for (name, text) in [
        (
            "unknown.json",
            r#"{"joints_deg_mm": [0, 0, 0, 0, 0, 0], "speed": 3}"#,
        ),
        ("type.toml", "joints_deg_mm = [0, \"x\"]\n"),
        ("twice.json", r#"{"joints_deg_mm": []} {}"#),
        ("half.toml", "joints_deg_mm = [0,\n"),
        ("words.txt", "0 0 0\n"),
    ] {
        std::fs::write(folder.path().join(name), text)?;
    }
    for &(line, code, complaint) in BAD {
        let ran = cellctl(folder.path(), None, line)?;
        assert_eq!(ran.code, Some(code), "{line}: {ran:?}");
        assert!(ran.wrong.contains(complaint), "{line}: {}", ran.wrong);
        assert_eq!(ran.said, "", "{line}");
    }
    Ok(())
}

#[test]
fn a_refusal_for_machines_names_the_item() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let line = "--json arm move-velocity five-link 0 45 -60 0 30 --along 20 --time 1e9";
    let ran = cellctl(folder.path(), None, line)?;
    assert_eq!((ran.code, &*ran.wrong), (Some(1), ""));
    let document: serde_json::Value = serde_json::from_str(&ran.said)?;
    assert_eq!(document["violations"][0]["item"], "time_s");
    assert_eq!(document["violations"][0]["value"], 1e9);
    assert_eq!(document["violations"][0]["max"], 3600.0);
    assert_eq!(document["outcome"], "NONE");
    Ok(())
}

#[test]
fn a_question_in_a_file_is_the_same_as_one_in_options() -> Result<()> {
    let folder = tempfile::tempdir()?;
    std::fs::write(
        folder.path().join("pose.toml"),
        "joints_deg_mm = [30, 20, -20, 0, -70, 0]\n[frames.tool]\nx_mm = 0\ny_mm = 0\nz_mm = 150\nw_deg = 0\np_deg = 0\nr_deg = 0\n",
    )?;
    let of_file = cellctl(folder.path(), None, "arm fk fanuc-m20ia --file pose.toml")?;
    let of_options = "arm fk fanuc-m20ia 30 20 -20 0 -70 0 --tool 0,0,150,0,0,0";
    assert_eq!(of_file, cellctl(folder.path(), None, of_options)?);
    assert_eq!(of_file.code, Some(0), "{of_file:?}");
    Ok(())
}

#[test]
fn a_png_is_a_picture() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let line = "arm fk five-link 0 45 -60 0 30 --plot arm.png";
    let ran = cellctl(folder.path(), None, line)?;
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let bytes = std::fs::read(folder.path().join("arm.png"))?;
    assert!(
        bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 20_000,
        "{}",
        bytes.len()
    );
    Ok(())
}

/// A robot at (3000, -1500) in the demo's cell, which tells where it is.
const ARRIVES: &str = r#"{
    "session": null, "seq": 1, "boot": 1, "signal": "MR_HEARTBEAT", "at": "2026-01-01T00:00:00Z",
    "data": {
        "pose": {"x_mm": 3000, "y_mm": -1500, "heading_deg": 0}, "driving": false, "localized": true,
        "battery_percent": 90, "mode": "AUTOMATIC", "loads": [{"slot": "left", "load": null}],
        "order": null, "at_point": null, "errors": []
    }
}"#;

/// The whole way: set-up, robot and question go to a running cell, and the answer is drawn here.
#[tokio::test]
async fn a_mobile_robots_route_is_the_cells_affair() -> Result<()> {
    let cell = TestCell::start().await?;
    let server = format!("http://{}", cell.server_address());
    let folder = tempfile::tempdir()?;
    std::fs::write(
        folder.path().join("demo.toml"),
        include_str!("../../cell/demo.setup.toml"),
    )?;
    let at = folder.path().to_owned();
    let asked = async |line: &'static str| -> Result<Ran> {
        let (at, server) = (at.clone(), server.clone());
        tokio::task::spawn_blocking(move || cellctl(&at, Some(&server), line)).await?
    };
    let ran = asked("cell import demo.toml").await?;
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let robot = cell.client().mobile_robot(CELL, "mr1");
    wait_until(
        "the set-up",
        Duration::from_secs(10),
        async || match robot.state().await {
            Ok(_) => Look::Ready(()),
            Err(error) => Look::not_yet(error.to_string()),
        },
    )
    .await?;

    // Nobody knows where it is, before it tells.
    let line = "route plan --mobile-robot mr1 --to handover/front --radius 400";
    let ran = asked(line).await?;
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert!(ran.wrong.contains("start_mm"), "{ran:?}");
    let _ = robot.post_signal(&serde_json::from_str(ARRIVES)?).await?;
    for (line, code, said) in [
        (line, 0, "3000.000  -1500.000"),
        (
            "route plan --mobile-robot mr1 --goal 1500,1200 --radius 350 --floor 500,-3000,5000,2000 --method roadmap --plot map.svg",
            0,
            "Wrote map.svg",
        ),
        (
            "route plan --mobile-robot mr1 --to handover/front --radius 400 --plot wheels.png --view wheels",
            0,
            "Wrote wheels.png",
        ),
        ("route plan --mobile-robot mr1 --to moon/base", 1, "goal: "),
        (
            "route plan --mobile-robot mr9 --to handover/front",
            1,
            "mr9",
        ),
    ] {
        let ran = asked(line).await?;
        assert_eq!(ran.code, Some(code), "{line}: {ran:?}");
        let all = [ran.said.as_str(), ran.wrong.as_str()].concat();
        assert!(all.contains(said), "{line}: {all}");
    }
    // What is in the way of it is the cell's, by name.
    let line = "--json route plan --mobile-robot mr1 --goal 1500,1200 --radius 350 --floor 500,-3000,5000,2000";
    let ran = asked(line).await?;
    let answer: api::paths::PlanRouteResult = serde_json::from_str(&ran.said)?;
    let names = answer.obstacles.iter().filter_map(|it| it.name.as_deref());
    let names: Vec<&str> = names.collect();
    assert!(
        names.contains(&"pedestal") && names.contains(&"front"),
        "{names:?}"
    );
    cell.shutdown().await
}
