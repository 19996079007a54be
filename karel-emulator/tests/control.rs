//! The control interface over HTTP: everything that can be asked and done, and what is refused: tasks, variables, registers, ports, frames.
#![expect(clippy::too_many_lines, reason = "the tables are long")]

mod common;

use common::panel::{COUNTER, Panel};
use common::{config_of, http};
use serde_json::{Value, json};

#[tokio::test]
async fn tasks_are_shown_with_their_call_stack_and_pause_step_and_end() {
    let panel = Panel::start(config_of(COUNTER, &[]));
    panel.cell.advance(0.35).await;
    let (_, task) = panel.get("/api/v1/tasks/counter").await;
    assert_eq!(task["state"], "waiting");
    let expected = json!([
        {"program": "COUNTER", "routine": "WAIT_A_BIT", "line": 15},
        {"program": "COUNTER", "routine": "COUNTER", "line": 21},
    ]);
    assert_eq!(task["calls"], expected);
    let (_, task) = panel
        .send("POST", "/api/v1/tasks/COUNTER/pause", json!({}))
        .await;
    assert_eq!(task["paused"], true);
    let (_, n) = panel.get("/api/v1/variable?path=%5BCOUNTER%5Dn").await;
    panel.cell.advance(10.0).await;
    let (_, later) = panel.get("/api/v1/variable?path=%5BCOUNTER%5Dn").await;
    assert_eq!(n["value"], later["value"], "it stands still");
    let mut lines = Vec::new();
    for _ in 0..6 {
        let (status, task) = panel
            .send("POST", "/api/v1/tasks/COUNTER/step", json!({}))
            .await;
        assert_eq!(status, 200, "{task}");
        panel.cell.advance(1.0).await;
        let (_, task) = panel.get("/api/v1/tasks/COUNTER").await;
        assert_eq!(task["paused"], true, "{task}");
        lines.push(task["calls"][0]["line"].as_u64().unwrap());
    }
    assert_eq!(lines, [16, 19, 20, 21, 15, 16], "one line after the other");
    let (status, _) = panel
        .send("POST", "/api/v1/tasks/COUNTER/continue", json!({}))
        .await;
    assert_eq!(status, 200);
    panel.cell.advance(1.0).await;
    let (_, task) = panel
        .send("POST", "/api/v1/tasks/COUNTER/abort", json!({}))
        .await;
    assert_eq!(task["state"], "ended");
    let (status, _) = panel
        .send("POST", "/api/v1/programs/counter/run", json!({}))
        .await;
    assert_eq!(status, 200);
    panel
        .refused_each([
            (
                "POST",
                "/api/v1/programs/counter/run",
                json!({}),
                409,
                &["running already"],
            ),
            (
                "POST",
                "/api/v1/programs/nobody/run",
                json!({}),
                404,
                &["nobody", "COUNTER"],
            ),
            (
                "POST",
                "/api/v1/tasks/nobody/abort",
                json!({}),
                404,
                &["nobody", "COUNTER"],
            ),
            (
                "POST",
                "/api/v1/tasks/counter/continue",
                json!({}),
                409,
                &["not paused"],
            ),
        ])
        .await;
}

#[tokio::test]
async fn variables_are_listed_read_and_set_by_path() {
    let panel = Panel::start(config_of(COUNTER, &[]));
    let (_, list) = panel.get("/api/v1/variables?program=counter").await;
    let paths: Vec<&str> = list["variables"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v["path"].as_str().unwrap())
        .collect();
    assert_eq!(
        paths,
        [
            "CFG.CHECKED",
            "CFG.NAME",
            "N",
            "P",
            "TABLE[1]",
            "TABLE[2]",
            "TABLE[3]",
            "X"
        ]
    );
    let set = |path: &str, value: Value| {
        let body = json!({"path": path, "value": value});
        async { panel.send("PUT", "/api/v1/variable", body).await }
    };
    for (path, value) in [
        ("[COUNTER]CFG.CHECKED", json!(true)),
        ("[COUNTER]CFG.NAME", json!("ros")),
        ("[COUNTER]TABLE[2]", json!(-5)),
        ("[COUNTER]X", json!(2.5)),
        ("[COUNTER]X", json!(null)),
        ("$MCR.$GENOVERRIDE", json!(40)),
        ("$UTOOL.z", json!(12.5)),
    ] {
        let (status, answer) = set(path, value.clone()).await;
        assert_eq!(
            (status, &answer["value"]),
            (200, &value),
            "{path}: {answer}"
        );
    }
    let (_, answer) = set("[COUNTER]X", json!(3)).await;
    assert_eq!(answer["value"], 3.0, "an integer may be a REAL");
    let pose =
        json!({"x_mm": 1.5, "y_mm": 2.0, "z_mm": 3.0, "w_deg": 0.0, "p_deg": 0.0, "r_deg": 90.0});
    let (_, answer) = set("[COUNTER]P", pose).await;
    assert_eq!(answer["value"]["x_mm"], 1.5);
    assert_eq!(answer["value"]["configuration"], "N U T, 0, 0, 0");
    assert_eq!(
        panel
            .cell
            .controller
            .state()
            .await
            .unwrap()
            .override_percent,
        40
    );
    for (path, value, status, words) in [
        (
            "[COUNTER]N",
            json!("x"),
            422,
            &["[COUNTER]N", "\"x\"", "type"][..],
        ),
        (
            "[COUNTER]NO",
            json!(1),
            404,
            &["[COUNTER]NO", "no such name"],
        ),
        (
            "[COUNTER]TABLE[4]",
            json!(1),
            404,
            &["TABLE[4]", "out of range"],
        ),
        ("[NOBODY]N", json!(1), 404, &["no such program"]),
        ("N", json!(1), 400, &["[PROG]VAR"]),
        ("[COUNTER]TABLE", json!(1), 422, &["whole array"]),
        ("$MCR.$GENOVERRIDE", json!(101), 422, &["101", "range"]),
        ("$FAST_CLOCK", json!(1), 422, &["cannot be written"]),
        ("[COUNTER]CFG.NAME", json!("x".repeat(300)), 422, &["254"]),
    ] {
        let body = json!({"path": path, "value": value});
        panel
            .refused("PUT", "/api/v1/variable", body, status, words)
            .await;
    }
    let (_, list) = panel
        .get("/api/v1/variables?program=*SYSTEM*&limit=10")
        .await;
    assert_eq!(
        (list["variables"].as_array().unwrap().len(), &list["more"]),
        (10, &json!(true))
    );
    panel
        .refused(
            "GET",
            "/api/v1/variables?program=x&limit=0",
            json!({}),
            422,
            &["limit is 0", "1 to 5000"],
        )
        .await;
}

#[tokio::test]
async fn registers_ports_and_frames_are_read_set_and_refused() {
    let panel = Panel::start(config_of(COUNTER, &[]));
    for (register, value) in [
        ("R[1]", json!(5)),
        ("R[2]", json!(0.5)),
        ("SR[1]", json!("hello")),
        ("F[7]", json!(true)),
        (
            "PR[3]",
            json!({"joints_deg": [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]}),
        ),
    ] {
        let path = format!(
            "/api/v1/registers/{}",
            register.replace('[', "%5B").replace(']', "%5D")
        );
        let (status, answer) = panel.send("PUT", &path, json!({"value": value})).await;
        assert_eq!((status, &answer["value"]), (200, &value), "{answer}");
    }
    let (_, list) = panel.get("/api/v1/registers").await;
    let names: Vec<&str> = list["registers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| r["register"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["R[1]", "R[2]", "PR[3]", "SR[1]", "F[7]"]);
    panel
        .refused_each([
            (
                "PUT",
                "/api/v1/registers/R%5B999%5D",
                json!({"value": 1}),
                404,
                &["R[999]"],
            ),
            (
                "PUT",
                "/api/v1/registers/R%5B1%5D",
                json!({"value": "x"}),
                422,
                &["number"],
            ),
            (
                "PUT",
                "/api/v1/registers/XR%5B1%5D",
                json!({"value": 1}),
                400,
                &["R[n]"],
            ),
        ])
        .await;
    let (_, port) = panel
        .send("PUT", "/api/v1/io/DI%5B2%5D", json!({"value": 1}))
        .await;
    assert_eq!(
        port,
        json!({"port": "DIN[2]", "value": 1, "simulated": false})
    );
    let (_, port) = panel
        .send(
            "PUT",
            "/api/v1/io/DIN%5B2%5D/simulation",
            json!({"value": 0}),
        )
        .await;
    assert_eq!(
        port,
        json!({"port": "DIN[2]", "value": 0, "simulated": true})
    );
    let (_, list) = panel.get("/api/v1/io").await;
    assert!(list["ports"].as_array().unwrap().contains(&port), "{list}");
    let (_, port) = http(
        panel.address,
        "DELETE",
        "/api/v1/io/DIN%5B2%5D/simulation",
        None,
    )
    .await;
    assert_eq!(port["value"], 1);
    let (_, port) = panel
        .send("PUT", "/api/v1/io/GOUT%5B1%5D", json!({"value": 4711}))
        .await;
    assert_eq!(port["value"], 4711);
    panel
        .refused_each([
            (
                "PUT",
                "/api/v1/io/RDO%5B10%5D",
                json!({"value": 1}),
                404,
                &["RDO[10]", "RDO[8]"],
            ),
            (
                "PUT",
                "/api/v1/io/DOUT%5B1%5D",
                json!({"value": 2}),
                422,
                &["DOUT[1]", "2", "0 or 1"],
            ),
            (
                "PUT",
                "/api/v1/io/DOUT%5B1%5D/simulation",
                json!({"value": 1}),
                422,
                &["not an input"],
            ),
            (
                "PUT",
                "/api/v1/io/GIN%5B1%5D",
                json!({"value": 70000}),
                422,
                &["GIN"],
            ),
        ])
        .await;
    let pose =
        json!({"x_mm": 0.0, "y_mm": 0.0, "z_mm": 150.0, "w_deg": 0.0, "p_deg": 0.0, "r_deg": 0.0});
    let (_, frames) = panel
        .send("PUT", "/api/v1/frames/tool/2", pose.clone())
        .await;
    assert_eq!(frames["tool"][1]["frame"]["z_mm"], 150.0);
    let (_, frames) = panel
        .send("PUT", "/api/v1/selected-frames/tool", json!({"number": 2}))
        .await;
    assert_eq!(frames["selected_tool"], 2);
    panel
        .refused_each([
            (
                "PUT",
                "/api/v1/frames/tool/11",
                pose.clone(),
                404,
                &["11", "1 to 10"],
            ),
            (
                "PUT",
                "/api/v1/frames/chair/1",
                pose,
                404,
                &["chair", "user or tool"],
            ),
            (
                "PUT",
                "/api/v1/selected-frames/user",
                json!({"number": 11}),
                422,
                &["11", "0 to 10"],
            ),
        ])
        .await;
}
