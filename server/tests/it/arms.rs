//! Questions about arm models and floors over HTTP: `robotics` has the numbers, here is the way to it.

use journal::MemoryDisk;
use serde_json::{Value, json};

use crate::mobile_signals::{send, serve, signal};
use crate::support::{FakeRobot, TestServer, robot_section};

const ARM: &str = "/api/v1/arms/fanuc-m20ia";

fn assert_close(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!((value - expected).abs() < 1e-6, "{value} is not {expected}");
}

/// What was in the way.
fn obstacle_names(answer: &Value) -> Vec<&Value> {
    let obstacles = answer["obstacles"].as_array().unwrap();
    obstacles.iter().map(|obstacle| &obstacle["name"]).collect()
}

#[tokio::test]
async fn arm_models_are_listed_and_described() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let listed = server.get("/api/v1/arms").await.json();
    assert_eq!(listed["arms"].as_array().unwrap().len(), 6);
    let described = server.get(ARM).await.json();
    assert_eq!(described["solvers"][0], "closed-form");
    assert_close(&described["joints"][1]["a_mm"], 790.0);
    let reply = server.get("/api/v1/arms/kuka").await;
    let problem = reply.problem(404, "not-found", "NONE");
    assert!(problem["detail"].as_str().unwrap().contains("five-link"));
}

#[tokio::test]
async fn what_is_wrong_with_a_question_is_a_problem_that_names_the_item() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let home = json!([0, 0, 0, 0, -90, 0]);
    let at = |joint: f64| json!({"position_deg_mm": [joint, 0, 0, 0, -90, 0]});
    let pose =
        |x: f64| json!({"x_mm": x, "y_mm": 0, "z_mm": 940, "w_deg": 180, "p_deg": 0, "r_deg": 0});
    let wall = json!({"corners_mm": [[400, 0], [500, 0], [400, 700], [450, 600]]});
    let floor = json!({"min_mm": [0, 0], "max_mm": [1000, 1000]});
    for (path, body, status, code, item) in [
        (
            "arms/fanuc-m20ia/forward",
            json!({"joints_deg_mm": [1, 2]}),
            422,
            "validation",
            "joints_deg_mm",
        ),
        (
            "arms/fanuc-m20ia/forward",
            json!({"joints_deg_mm": home, "frames": {"tool": pose(2e6)}}),
            422,
            "validation",
            "frames.tool.x_mm",
        ),
        (
            "arms/fanuc-m20ia/inverse",
            json!({"pose": pose(5000.0)}),
            422,
            "out-of-workspace",
            "pose",
        ),
        (
            "arms/fanuc-m20ia/inverse",
            json!({"pose": pose(985.0), "method": "five-link"}),
            422,
            "validation",
            "method",
        ),
        (
            "arms/scara/rates",
            json!({"joints_deg_mm": [0, 0, 0, 0], "velocity": {"linear_mm_s": [1, 0, 0], "angular_deg_s": [0, 0, 0]}}),
            422,
            "singularity",
            "velocity",
        ),
        (
            "arms/fanuc-m20ia/trajectories",
            json!({"kind": "jerk-limited", "start": at(171.0), "goal": at(0.0)}),
            422,
            "joint-limit-exceeded",
            "start.position_deg_mm[0]",
        ),
        (
            "arms/fanuc-m20ia/trajectories",
            json!({"kind": "quintic", "start": at(1.0), "goal": at(0.0), "durations_s": [0]}),
            422,
            "validation",
            "durations_s[0]",
        ),
        (
            "arms/fanuc-m20ia/transfers",
            json!({"start_deg_mm": home, "goal_deg_mm": home,
                "obstacles": [{"kind": "box", "pose": pose(985.0), "size_mm": [50, 50, 50]}]}),
            422,
            "validation",
            "start_deg_mm",
        ),
        (
            "arms/fanuc-m20ia/reachability",
            json!({"grid": {"plane": "XZ", "across_mm": 0, "u_mm": [0, 1000], "v_mm": [0, 1000], "step_mm": 1,
                "w_deg": 180, "p_deg": 0, "r_deg": 0}}),
            422,
            "validation",
            "grid.step_mm",
        ),
        (
            "routes/plan",
            json!({"floor": floor, "radius_mm": 50, "start_mm": [100, 100], "goal_mm": [900, 100], "obstacles": [wall]}),
            422,
            "validation",
            "obstacles[0].corners_mm",
        ),
    ] {
        let path = format!("/api/v1/{path}");
        let reply = server.post(&path, &body.to_string()).await;
        let problem = reply.problem(status, code, "NONE");
        assert_eq!(problem["violations"][0]["item"], item, "{path}: {problem}");
    }
    let closed = json!({
        "floor": floor, "radius_mm": 50, "start_mm": [100, 100], "goal_mm": [900, 100],
        "obstacles": [{"corners_mm": [[400, 0], [500, 0], [500, 1000], [400, 1000]]}]
    });
    let reply = server
        .post("/api/v1/routes/plan", &closed.to_string())
        .await;
    let _problem = reply.problem(422, "no-way", "NONE");
    robot.assert_untouched();
}

/// The goal is walled in: the walk has a million steps among hundreds of edges.
#[tokio::test]
async fn a_caller_who_went_away_keeps_nobody_waiting() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let corners = |x: f64, y: f64, w: f64, h: f64| json!({"corners_mm": [[x, y], [x + w, y], [x + w, y + h], [x, y + h]]});
    let walls = [
        corners(4000.0, 4000.0, 2000.0, 100.0),
        corners(4000.0, 5900.0, 2000.0, 100.0),
        corners(4000.0, 4100.0, 100.0, 1800.0),
        corners(5900.0, 4100.0, 100.0, 1800.0),
    ];
    let question = json!({
        "floor": {"min_mm": [0, 0], "max_mm": [10_000, 10_000]}, "radius_mm": 50,
        "start_mm": [500, 500], "goal_mm": [5000, 5000], "obstacles": walls,
        "search": {"method": "potential-field", "steps": 1_000_000}
    });
    let question = question.to_string();
    let path = "/api/v1/routes/plan";
    let asked = server.post(path, &question);
    let gone = tokio::time::timeout(std::time::Duration::from_millis(300), asked).await;
    assert!(gone.is_err(), "the question is answered too soon: {gone:?}");
    // The one place for computing is free again long before the walk would have ended.
    let short = json!({
        "floor": {"min_mm": [0, 0], "max_mm": [1000, 1000]}, "radius_mm": 50,
        "start_mm": [100, 100], "goal_mm": [900, 900]
    });
    let short = short.to_string();
    let reply = server.post(path, &short);
    let reply = tokio::time::timeout(std::time::Duration::from_secs(3), reply).await;
    assert_eq!(reply.unwrap().status, 200);
}

/// Its flange looks down: a tool of 100 mm is 100 mm lower, and a degree of J1 moves it by 985 pi / 180 along Y.
#[tokio::test]
async fn a_robots_own_tool_and_frame_count_where_the_question_has_none() {
    let robot = FakeRobot::accepting().await;
    let mut section = robot_section(robot.address);
    section.tool.z_mm = 100.0;
    section.user_frame.x_mm = 500.0;
    let server = TestServer::with_robot(section).await;
    let path = "/api/v1/cells/c1/robots/r1/kinematics/jacobian";
    let home = json!({"joints_deg_mm": [0, 0, 0, 0, -90, 0]}).to_string();
    let answer = server.post(path, &home).await.json();
    assert_close(&answer["geometric"][1][0], 985.0_f64.to_radians());
    // A degree of J5 turns the tool about the wrist center, 200 above its tip.
    let across = answer["geometric"][0][4].as_f64().unwrap();
    assert!(
        (across.abs() - 200.0_f64.to_radians()).abs() < 1e-6,
        "{answer}"
    );

    let reach = "/api/v1/cells/c1/robots/r1/reachability";
    let pose = |x: f64, z: f64| json!({"x_mm": x, "y_mm": 0, "z_mm": z, "w_deg": 180, "p_deg": 0, "r_deg": 0});
    let poses = json!({"poses": [pose(485.0, 840.0), pose(2500.0, 840.0)]}).to_string();
    let answer = server.post(reach, &poses).await.json();
    assert!(answer["inside"][0].as_u64().unwrap() > 0, "{answer}");
    assert_eq!(answer["inside"][1], 0);
    assert_eq!(answer["reachable"], 1);
    robot.assert_untouched();
}

/// The demo's cell: from the gate to the hand-over in front of the arm.
#[tokio::test]
async fn a_mobile_robots_path_goes_around_what_its_cell_has() {
    let server = serve(&MemoryDisk::new()).await;
    let path = "/api/v1/cells/c1/mobile-robots/mr1/routes/plan";
    let to_front = json!({"goal": "handover/front", "radius_mm": 400}).to_string();
    let reply = server.post(path, &to_front).await;
    let problem = reply.problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "start_mm");

    // It stands at (3000, -1500).
    let sent = send(&server, &signal("MR_HEARTBEAT", (1, 1))).await;
    assert_eq!(sent.status, 200, "{sent:?}");
    let reply = server.post(path, &to_front).await;
    assert_eq!(reply.status, 200, "{reply:?}");
    let answer = reply.json();
    let points = answer["points_mm"].as_array().unwrap();
    assert_eq!(points.first(), Some(&json!([3000.0, -1500.0])));
    assert_eq!(points.last(), Some(&json!([1100.0, 0.0])));
    // Its own work zone is the floor; the hand-over zone it drives into is not in its way, the pedestal is.
    assert_eq!(answer["floor"]["min_mm"], json!([500.0, -3000.0]));
    let names = obstacle_names(&answer);
    assert_eq!(names, ["rack-frame", "cabinet", "pedestal"]);

    // Past the arm, the zone is in the way.
    let past = json!({
        "start_mm": [2500, -1500], "goal_mm": [1500, 1200], "radius_mm": 350,
        "floor": {"min_mm": [500, -3000], "max_mm": [5000, 2000]}
    });
    let answer = server.post(path, &past.to_string()).await.json();
    let names = obstacle_names(&answer);
    assert!(names.contains(&&json!("front")), "{answer}");
    assert!(answer["clearance_mm"].as_f64().unwrap() > -1e-3);

    let nowhere = json!({"goal": "moon/base"}).to_string();
    let problem = server
        .post(path, &nowhere)
        .await
        .problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "goal");
    let reply = server.post(&path.replace("mr1", "mr9"), &to_front).await;
    let _problem = reply.problem(404, "not-found", "NOT_SENT");
}

/// The M-20iA's maker publishes no masses, and none are made up.
#[tokio::test]
async fn torques_of_an_arm_that_nobody_weighed_are_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let body = json!({"joints_deg_mm": [0, 0, 0, 0, -90, 0]});
    let path = format!("{ARM}/inverse-dynamics");
    let reply = server.post(&path, &body.to_string()).await;
    let problem = reply.problem(422, "validation", "NONE");
    assert_eq!(problem["violations"][0]["item"], "links");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("inertia_kg_m2 of J1, J2, J3"), "{detail}");
}
