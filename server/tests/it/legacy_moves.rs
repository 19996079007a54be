//! The seed's routes, from the request to the bytes a controller reads.

use serde_json::json;

use crate::support::{FakeRobot, TestServer};

pub(crate) const POINT: &str = r#"{"x": 985, "y": 0, "z": 940, "w": 180, "p": 0, "r": 0}"#;

#[tokio::test]
async fn a_move_reaches_the_controller_and_its_answer_comes_back() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;

    let reply = server.post("/fanuc/move", POINT).await;

    assert_eq!(reply.status, 200, "{reply:?}");
    assert_eq!(
        reply.json(),
        json!({"current_position": {"x": 985.0, "y": 0.0, "z": 940.0, "w": 180.0, "p": 0.0, "r": 0.0}})
    );
    assert_eq!(robot.commands(), ["985000 0 940000 180000 0 0 200 1"]);
}
