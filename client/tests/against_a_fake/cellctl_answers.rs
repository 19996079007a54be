//! What `cellctl` sends, and what it prints when all goes well.

use serde_json::json;

use crate::fake::{Answer, Fake, cellctl, cellctl_in};
use crate::samples;

#[tokio::test]
async fn a_move_sends_the_pose_as_it_was_given() {
    let fake = Fake::always(Answer::Json(samples::motion("accepted"))).await;
    let in_a_row = [
        "move", "600", "200", "600", "-180", "30", "-.5", "--speed", "150",
    ];
    let by_name = [
        "move", "--speed", "150", "--x", "600", "--y", "200", "--z", "600", "--w", "-180", "--p",
        "30", "--r", "-.5",
    ];
    for arguments in [&in_a_row[..], &by_name[..]] {
        let ran = fake.cellctl(arguments).await;
        assert_eq!(ran.code, 0, "{ran:?}");
        assert!(ran.stdout.starts_with("The controller took the motion"));
        assert!(ran.stdout.contains(samples::MOTION_ID));
    }
    for seen in fake.seen() {
        assert_eq!(seen.line, "POST /api/v1/cells/demo/robots/r1/motions");
        assert_eq!(
            seen.body,
            json!({
                "type": "JOINT",
                "target": {"pose": {"x_mm": 600.0, "y_mm": 200.0, "z_mm": 600.0,
                    "w_deg": -180.0, "p_deg": 30.0, "r_deg": -0.5}},
                "speed_mm_s": 150.0,
            })
        );
    }
}

#[tokio::test]
async fn a_move_to_joints_and_a_move_home_say_so() {
    let fake = Fake::always(Answer::Json(samples::motion("accepted"))).await;
    let joints = [
        "move", "--joints", "0", "-10", "0", "0", "-90", "0", "--reason", "test",
    ];
    let home = ["home", "--speed", "50", "--deadline-ms", "2000"];
    assert_eq!(fake.cellctl(&joints).await.code, 0);
    assert_eq!(fake.cellctl(&home).await.code, 0);
    let bodies: Vec<_> = fake.seen().into_iter().map(|seen| seen.body).collect();
    assert_eq!(bodies[0]["target"]["joints"]["j2_deg"], json!(-10.0));
    assert_eq!(bodies[0]["reason"], json!("test"));
    assert_eq!(
        bodies[1],
        json!({"type": "HOME", "speed_mm_s": 50.0, "deadline_ms": 2000})
    );
}

#[tokio::test]
async fn a_delta_counts_from_the_last_accepted_target() {
    let fake = Fake::start(|seen| {
        Answer::Json(match seen.line.as_str() {
            "GET /api/v1/cells/demo/robots/r1/state" => samples::state(Some(&samples::pose())),
            _ => samples::motion("accepted"),
        })
    })
    .await;
    let ran = fake
        .cellctl(&["delta", "0", "0", "-10", "0", "0", "1.5"])
        .await;
    assert_eq!(ran.code, 0, "{ran:?}");
    let sent = &fake.seen()[1].body["target"]["pose"];
    assert_eq!(sent["z_mm"], json!(590.0));
    assert_eq!(sent["r_deg"], json!(1.5));
    assert_eq!(sent["x_mm"], json!(600.0));
}

#[tokio::test]
async fn json_is_the_answer_itself() {
    let fake = Fake::always(Answer::Json(samples::motion("accepted"))).await;
    let ran = fake.cellctl(&["--json", "home"]).await;
    assert_eq!(ran.code, 0);
    let mut expected = samples::motion("accepted");
    let _ = expected
        .as_object_mut()
        .unwrap()
        .remove("a_key_of_tomorrow");
    assert_eq!(ran.json(), expected);
}

#[tokio::test]
async fn one_run_has_one_request_id() {
    let fake = Fake::start(|seen| {
        Answer::Json(match seen.line.as_str() {
            "GET /api/v1/cells" => samples::cells(&["r1"]),
            _ => samples::motion("accepted"),
        })
    })
    .await;
    let ran = cellctl(&["--server", &fake.url(), "home"]).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    let ids: Vec<_> = fake
        .seen()
        .into_iter()
        .map(|seen| seen.request_id)
        .collect();
    assert_eq!(ids.len(), 2);
    assert!(ids[0].is_some());
    assert_eq!(ids[0], ids[1]);
}

#[tokio::test]
async fn the_environment_names_server_cell_and_robot() {
    let fake = Fake::always(Answer::Json(samples::state(None))).await;
    let url = fake.url();
    let environment = [
        ("ROBOCELL_SERVER", url.as_str()),
        ("ROBOCELL_CELL", "a cell"),
        ("ROBOCELL_ROBOT", "r/2"),
    ];
    let ran = cellctl_in(&environment, &["state"]).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    // An id is one segment of the path, whatever is in it.
    assert_eq!(
        fake.lines(),
        ["GET /api/v1/cells/a%20cell/robots/r%2F2/state"]
    );
}

#[tokio::test]
async fn kinematics_come_as_tables() {
    let fake = Fake::start(|seen| {
        Answer::Json(if seen.line.ends_with("forward") {
            samples::forward()
        } else {
            samples::inverse()
        })
    })
    .await;
    let ran = fake.cellctl(&["fk", "0", "0", "0", "0", "-90", "0"]).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(
        ran.stdout.contains("X 600.000  Y 200.000"),
        "{}",
        ran.stdout
    );
    assert!(
        ran.stdout
            .contains("J5     -90.000  -125.000  125.000   35.000"),
        "{}",
        ran.stdout
    );

    let near = ["--near", "0", "0", "0", "0", "-90", "0"];
    let ran = fake
        .cellctl(&[&["ik", "600", "200", "600", "-180", "30", "0"], &near[..]].concat())
        .await;
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(
        ran.stdout.contains("The controller takes branch 1."),
        "{}",
        ran.stdout
    );
    assert!(ran.stdout.contains("controller, nearest"), "{}", ran.stdout);
    assert!(ran.stdout.contains("outside the limits"), "{}", ran.stdout);
    assert_eq!(fake.seen()[1].body["near"]["j5_deg"], json!(-90.0));
}

#[tokio::test]
async fn what_the_server_knows_is_told_in_sentences() {
    let fake = Fake::start(|seen| {
        let path = seen.line.trim_start_matches("GET /api/v1/cells");
        Answer::Json(match path {
            "" => samples::cells(&["r1"]),
            "/demo/robots/r1" => samples::description(),
            "/demo/robots/r1/state" => samples::state(Some(&samples::pose())),
            "/demo/robots/r1/motions?limit=1" => {
                json!({"motions": [samples::motion("in_doubt")], "next_cursor": "abc"})
            }
            _ => samples::motion("in_doubt"),
        })
    })
    .await;
    for (arguments, expected) in [
        (&["cells"][..], "demo  r1     Arm   fanuc-m20ia  seed"),
        (&["describe"], "controller     127.0.0.1:59002, tier seed"),
        (
            &["state"],
            "link   answering: the last command was answered",
        ),
        (
            &["motions", "--limit", "1"],
            "More: cellctl motions list --cursor abc",
        ),
        (
            &["motions", "list", "--limit", "1"],
            "2026-01-02T03:04:05Z  JOINT  in_doubt  200 mm/s",
        ),
        (
            &["motions", "show", samples::MOTION_ID],
            "state       in_doubt",
        ),
    ] {
        let ran = fake.cellctl(arguments).await;
        assert_eq!(ran.code, 0, "{ran:?}");
        assert!(
            ran.stdout.contains(expected),
            "{arguments:?}:\n{}",
            ran.stdout
        );
    }
}
