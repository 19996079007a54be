//! The kinematics routes: whole answers, and nothing sent.

use serde_json::{Value, json};

use crate::support::{FakeRobot, TestServer, robot_section};

const FORWARD: &str = "/api/v1/cells/c1/robots/r1/kinematics/forward";
const INVERSE: &str = "/api/v1/cells/c1/robots/r1/kinematics/inverse";
const HOME: &str = r#"{"joints": {"j1_deg": 0, "j2_deg": 0, "j3_deg": 0, "j4_deg": 0, "j5_deg": -90, "j6_deg": 0}}"#;

fn pose(x: f64, z: f64, w: f64, p: f64) -> String {
    json!({"pose": {"x_mm": x, "y_mm": 0, "z_mm": z, "w_deg": w, "p_deg": p, "r_deg": 0}})
        .to_string()
}

fn assert_close(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!((value - expected).abs() < 1e-6, "{value} is not {expected}");
}

#[tokio::test]
async fn forward_gives_the_pose_in_the_user_frame_at_the_tool() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let plain = server.post(FORWARD, HOME).await.json();
    assert_close(&plain["pose"]["x_mm"], 985.0);
    assert_close(&plain["pose"]["z_mm"], 940.0);
    assert_eq!(plain["configuration"], "N U T, 0, 0, 0");
    assert_eq!(plain["within_limits"], true);
    assert_eq!(plain["margins"][4]["joint"], "J5");
    assert_eq!(plain["singularity"]["singular"], false);

    let mut section = robot_section(robot.address);
    section.tool.z_mm = 100.0;
    section.user_frame.x_mm = 500.0;
    let server = TestServer::with_robot(section).await;
    let framed = server.post(FORWARD, HOME).await.json();
    // The flange looks down: a tool of 100 mm is 100 mm lower.
    assert_close(&framed["pose"]["x_mm"], 485.0);
    assert_close(&framed["pose"]["z_mm"], 840.0);
    robot.assert_untouched();
}

#[tokio::test]
async fn inverse_gives_every_branch_and_the_controllers() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let result = server
        .post(INVERSE, &pose(985.0, 940.0, 180.0, 0.0))
        .await
        .json();
    let branches = result["branches"].as_array().unwrap();
    assert!(branches.len() >= 4, "{result}");
    let nearest = &branches[usize::try_from(result["nearest"].as_u64().unwrap()).unwrap()];
    assert_close(&nearest["joints"]["j5_deg"], -90.0);
    assert_close(&nearest["distance_deg"], 0.0);
    let controller = &branches[usize::try_from(result["controller"].as_u64().unwrap()).unwrap()];
    assert_eq!(controller["configuration"], "N U T, 0, 0, 0");
    let inside: Vec<_> = branches
        .iter()
        .map(|branch| branch["within_limits"] == true)
        .collect();
    assert!(inside.is_sorted_by(|a, b| a >= b), "{inside:?}");
    for branch in branches {
        let body = json!({"joints": branch["joints"]}).to_string();
        let back = server.post(FORWARD, &body).await.json();
        assert_close(&back["pose"]["x_mm"], 985.0);
        assert_close(&back["pose"]["z_mm"], 940.0);
    }
    robot.assert_untouched();
}

#[tokio::test]
async fn a_branch_is_told_as_forward_kinematics_tells_its_joints_even_half_a_turn_from_zero() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let mut half_turns = 0;
    for w in [180.0, -180.0, 0.0] {
        let result = server.post(INVERSE, &pose(985.0, 940.0, w, 0.0)).await;
        for branch in result.json()["branches"].as_array().unwrap() {
            let j4 = branch["joints"]["j4_deg"].as_f64().unwrap();
            half_turns += usize::from((j4.abs() - 180.0).abs() < 1e-9);
            let body = json!({"joints": branch["joints"]}).to_string();
            let forward = server.post(FORWARD, &body).await.json();
            for key in ["configuration", "within_limits", "margins", "singularity"] {
                assert_eq!(branch[key], forward[key], "{key} of {branch}");
            }
        }
    }
    assert!(half_turns > 0, "no branch has J4 at half a turn");
}

#[tokio::test]
async fn a_joint_value_of_more_than_a_hundred_turns_is_refused_not_answered_with_null() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let joints = HOME.replace("\"j5_deg\": -90", "\"j5_deg\": 1.7e308");
    let problem = server
        .post(FORWARD, &joints)
        .await
        .problem(422, "validation", "NONE");
    assert_eq!(
        problem["detail"],
        "J5 is 1.7e308; it must be from -36000 to 36000 degrees"
    );
    let violation = &problem["violations"][0];
    assert_eq!(violation["item"], "joints.j5_deg");
    assert_eq!(violation["value"], 1.7e308);
    assert_eq!(violation["max"], 36_000.0);

    let near = joints.replacen("joints", "near", 1);
    let body =
        pose(985.0, 940.0, 180.0, 0.0).replacen('{', &format!("{},", &near[..near.len() - 1]), 1);
    let problem = server
        .post(INVERSE, &body)
        .await
        .problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "near.j5_deg");
}

#[tokio::test]
async fn inverse_of_a_pose_out_of_reach_says_so() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let reply = server.post(INVERSE, &pose(5000.0, 940.0, 180.0, 0.0)).await;
    let problem = reply.problem(422, "out-of-workspace", "NONE");
    // The title says that the pose is out of reach; the detail does not say it again.
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.starts_with("the wrist center would be "), "{detail}");
    assert!(detail.ends_with(" mm beyond the stretched arm"), "{detail}");
    let reply = server.post(INVERSE, &pose(2e6, 940.0, 180.0, 0.0)).await;
    let problem = reply.problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "pose.x_mm");
    assert_eq!(problem["violations"][0]["value"], 2e6);
}
