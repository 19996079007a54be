//! Every documented route as every kind of caller: X1, X2.

use serde_json::{Value, json};

use crate::support::{FakeRobot, Secured};

/// Who may, written down a second time, by hand: one letter a role, `V`iewer, `O`perator, `I`ntegrator, `A`dmin, the
/// cell's own `M`obile robot; `*` for everybody, token or not.
const MATRIX: &str = "
GET    /livez                                                        *
GET    /readyz                                                       *
GET    /version                                                      *
GET    /problems                                                     *
GET    /problems/{code}                                              *
GET    /metrics                                                      VOIA
GET    /api/v1/me                                                    VOIAM
GET    /api/v1/tokens                                                A
POST   /api/v1/tokens                                                A
DELETE /api/v1/tokens/{id}                                           A
POST   /api/v1/tokens/{id}/rotate                                    A
GET    /api/v1/cells                                                 VOIA
GET    /api/v1/cells/{cell}                                          VOIA
GET    /api/v1/cells/{cell}/control-authority                        VOIA
POST   /api/v1/cells/{cell}/control-authority                        OIA
PUT    /api/v1/cells/{cell}/control-authority/{lease}                OIA
DELETE /api/v1/cells/{cell}/control-authority/{lease}                OIA
POST   /api/v1/cells/{cell}/control-authority/{lease}/transfer       OIA
GET    /api/v1/cells/{cell}/audit                                    IA
GET    /api/v1/cells/{cell}/robots                                   VOIA
GET    /api/v1/cells/{cell}/robots/{robot}                           VOIA
GET    /api/v1/cells/{cell}/robots/{robot}/description               VOIA
GET    /api/v1/cells/{cell}/robots/{robot}/state                     VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/kinematics/forward        VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/kinematics/inverse        VOIA
GET    /api/v1/cells/{cell}/robots/{robot}/motions                   VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/motions                   OI
GET    /api/v1/cells/{cell}/robots/{robot}/motions/{id}              VOIA
GET    /api/v1/cells/{cell}/events                                   VOIA
GET    /api/v1/cells/{cell}/mobile-robots                            VOIA
GET    /api/v1/cells/{cell}/mobile-robots/{mobile_robot}             VOIA
GET    /api/v1/cells/{cell}/mobile-robots/{mobile_robot}/state       VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/motions/preview          VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/motions/{id}/cancel      OI
POST   /api/v1/cells/{cell}/robots/{robot}/motions/{id}/pause       OI
POST   /api/v1/cells/{cell}/robots/{robot}/motions/{id}/resume      OI
POST   /api/v1/cells/{cell}/robots/{robot}/stop                     VOIAM
GET    /api/v1/cells/{cell}/robots/{robot}/speed-override           VOIA
PUT    /api/v1/cells/{cell}/robots/{robot}/speed-override           OI
GET    /api/v1/cells/{cell}/interventions                           VOIA
GET    /api/v1/cells/{cell}/interventions/{id}                      VOIA
POST   /api/v1/cells/{cell}/interventions/{id}/respond              OI
GET    /api/v1/cells/{cell}/setup                                   VOIA
PUT    /api/v1/cells/{cell}/setup                                   I
POST   /api/v1/cells/{cell}/setup/check                             VOIA
POST   /api/v1/cells/{cell}/setup/tools/{arm}/{number}/calibrate    I
POST   /api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}/teach  I
GET    /api/v1/cells/{cell}/setup/arms/{arm}                        VOIA
PUT    /api/v1/cells/{cell}/setup/arms/{arm}                        I
DELETE /api/v1/cells/{cell}/setup/arms/{arm}                        I
GET    /api/v1/cells/{cell}/setup/tools/{arm}/{number}              VOIA
PUT    /api/v1/cells/{cell}/setup/tools/{arm}/{number}              I
DELETE /api/v1/cells/{cell}/setup/tools/{arm}/{number}              I
GET    /api/v1/cells/{cell}/setup/zones/{zone}                      VOIA
PUT    /api/v1/cells/{cell}/setup/zones/{zone}                      I
DELETE /api/v1/cells/{cell}/setup/zones/{zone}                      I
GET    /api/v1/cells/{cell}/setup/stations/{station}                VOIA
PUT    /api/v1/cells/{cell}/setup/stations/{station}                I
DELETE /api/v1/cells/{cell}/setup/stations/{station}                I
GET    /api/v1/cells/{cell}/setup/places/{place}                    VOIA
PUT    /api/v1/cells/{cell}/setup/places/{place}                    I
DELETE /api/v1/cells/{cell}/setup/places/{place}                    I
GET    /api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}        VOIA
PUT    /api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}        I
DELETE /api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}        I
GET    /api/v1/cells/{cell}/setup/destinations/{destination}        VOIA
PUT    /api/v1/cells/{cell}/setup/destinations/{destination}        I
DELETE /api/v1/cells/{cell}/setup/destinations/{destination}        I
GET    /api/v1/cells/{cell}/setup/mobile-robots/{mobile_robot}      VOIA
PUT    /api/v1/cells/{cell}/setup/mobile-robots/{mobile_robot}      I
DELETE /api/v1/cells/{cell}/setup/mobile-robots/{mobile_robot}      I
GET    /api/v1/cells/{cell}/setup/routes/{route}                    VOIA
PUT    /api/v1/cells/{cell}/setup/routes/{route}                    I
DELETE /api/v1/cells/{cell}/setup/routes/{route}                    I
GET    /api/v1/cells/{cell}/setup/loads/{load}                      VOIA
PUT    /api/v1/cells/{cell}/setup/loads/{load}                      I
DELETE /api/v1/cells/{cell}/setup/loads/{load}                      I
GET    /api/v1/cells/{cell}/setup/triggers/{trigger}                VOIA
PUT    /api/v1/cells/{cell}/setup/triggers/{trigger}                I
DELETE /api/v1/cells/{cell}/setup/triggers/{trigger}                I
POST   /api/v1/cells/{cell}/mobile-robots/{mobile_robot}/signals     OI
GET    /api/v1/cells/{cell}/mobile-robots/{mobile_robot}/outbox      OI
POST   /api/v1/cells/{cell}/mobile-robots/{mobile_robot}/instant-actions OI
GET    /api/v1/cells/{cell}/state                                   VOIA
GET    /api/v1/cells/{cell}/jobs                                    VOIA
POST   /api/v1/cells/{cell}/jobs                                    OI
POST   /api/v1/cells/{cell}/jobs/simulate                           OI
GET    /api/v1/cells/{cell}/jobs/{job}                              VOIA
POST   /api/v1/cells/{cell}/jobs/{job}/commands                     OI
GET    /api/v1/cells/{cell}/jobs/{job}/events                       VOIA
GET    /api/v1/cells/{cell}/jobs/{job}/report                       VOIA
GET    /api/v1/cells/{cell}/sessions                                VOIA
GET    /api/v1/cells/{cell}/sessions/{session}                      VOIA
GET    /api/v1/cells/{cell}/stations/{station}/points/{point}/sessions VOIA
GET    /api/v1/cells/{cell}/loads                                   VOIA
GET    /api/v1/cells/{cell}/loads/{load}                            VOIA
PUT    /api/v1/cells/{cell}/loads/{load}/custody                    OI
GET    /api/v1/arms                                                  VOIA
GET    /api/v1/arms/{model}                                          VOIA
POST   /api/v1/arms/{model}/forward                                  VOIA
POST   /api/v1/arms/{model}/inverse                                  VOIA
POST   /api/v1/arms/{model}/jacobian                                 VOIA
POST   /api/v1/arms/{model}/rates                                    VOIA
POST   /api/v1/arms/{model}/inverse-dynamics                         VOIA
POST   /api/v1/arms/{model}/calibrate-tool                           VOIA
POST   /api/v1/arms/{model}/velocity-motion                          VOIA
POST   /api/v1/arms/{model}/reachability                             VOIA
POST   /api/v1/arms/{model}/trajectories                             VOIA
POST   /api/v1/arms/{model}/tool-paths                               VOIA
POST   /api/v1/arms/{model}/transfers                                VOIA
POST   /api/v1/routes/plan                                           VOIA
POST   /api/v1/cells/{cell}/mobile-robots/{mobile_robot}/routes/plan VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/reachability              VOIA
POST   /api/v1/cells/{cell}/robots/{robot}/kinematics/jacobian       VOIA
POST   /fanuc/move                                                   OI
POST   /fanuc/home                                                   OI
POST   /fanuc/delta                                                  OI
";

/// Who the matrix says may call a route.
fn who(method: &str, path: &str) -> &'static str {
    let mut lines = MATRIX.lines().map(|line| line.split_whitespace());
    lines
        .find_map(|mut words| {
            let found = words.next() == Some(method) && words.next() == Some(path);
            found.then(|| words.next().unwrap())
        })
        .unwrap_or_else(|| panic!("add `{method} {path}` to the matrix: who may call it?"))
}

struct Caller {
    what: &'static str,
    token: String,
    letter: Option<char>,
}

#[tokio::test]
async fn x1_x2_every_route_admits_exactly_whom_the_matrix_says() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let revoked = cell.token("gone", "operator").await;
    let id = revoked.split('_').nth(1).unwrap().to_owned();
    let path = format!("/api/v1/tokens/{id}");
    let reply = cell.send("DELETE", &path, &cell.admin, &Value::Null).await;
    assert_eq!(reply.status, 200);
    let mobile = json!({"mobile_robot": "mr-other"});
    let last = if cell.admin.ends_with('0') { '1' } else { '0' };
    let forged = format!("{}{last}", &cell.admin[..cell.admin.len() - 1]);
    let caller = |what, token, letter| Caller {
        what,
        token,
        letter,
    };
    let callers = [
        caller("nobody", String::new(), None),
        caller("viewer", cell.token("v", "viewer").await, Some('V')),
        caller("operator", cell.token("o", "operator").await, Some('O')),
        caller("integrator", cell.token("i", "integrator").await, Some('I')),
        caller("admin", cell.admin.clone(), Some('A')),
        caller(
            "mobile robot of another name",
            cell.scoped("m", "mobile_robot", mobile).await,
            Some('M'),
        ),
        caller("expired", cell.expired.clone(), None),
        caller("revoked", revoked, None),
        caller("forged", forged, None),
        caller("nonsense", "cell_1_2".to_owned(), None),
    ];
    let document = serde_json::to_value(server::openapi()).unwrap();
    let mut asked = 0;
    for (template, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let method = method.to_uppercase();
            let allowed = who(&method, template);
            assert_eq!(
                operation["security"] == json!([]),
                allowed == "*",
                "{method} {template} in the document"
            );
            let path = filled(template);
            for Caller {
                what,
                token,
                letter,
            } in &callers
            {
                let body = match method.as_str() {
                    "POST" => json!({}),
                    _ => Value::Null,
                };
                let reply = cell.send(&method, &path, token, &body).await;
                let admitted = allowed == "*" || letter.is_some_and(|l| allowed.contains(l));
                let status = reply.status;
                let right = match (admitted, letter) {
                    (true, _) => !matches!(status, 401 | 403 | 429),
                    (false, Some(_)) => status == 403,
                    // After some tokens that are none, 429.
                    (false, None) => status == 401 || (status == 429 && !token.is_empty()),
                };
                assert!(right, "{method} {path} as {what}: {reply:?}");
                if status == 401 {
                    assert_eq!(reply.header("www-authenticate"), Some("Bearer"));
                }
                asked += 1;
            }
        }
    }
    assert_eq!(asked, MATRIX.trim().lines().count() * callers.len());
    // The thesis's `home` needs no body, and is for two of them.
    assert_eq!(robot.commands().len(), 2);
}

/// The path of a template, with names that exist where they must.
fn filled(template: &str) -> String {
    let uuid = "019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11";
    template
        // A stream that is asked for as it should be does not end.
        .replace("{cell}/events", "{cell}/events?types=-A")
        .replace("{cell}", "c1")
        .replace("{robot}", "r1")
        .replace("{model}", "scara")
        .replace("{code}", "validation")
        .replace("{lease}", uuid)
        .replace("{id}", "0000000000000000")
}

/// H11.
#[tokio::test]
async fn h11_tricks_with_the_path_open_nothing() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    for path in [
        "//api/v1/cells",
        "/api/v1/cells/",
        "/api/v1//cells",
        "/api/v1/%63ells",
        "/API/v1/cells",
        "/livez/../api/v1/cells",
        "/livez/%2e%2e/api/v1/cells",
        "/api/v1/cells%00",
        "/api/v1/cells;x=1",
        "/debug",
    ] {
        let reply = cell.get(path, "").await;
        assert!(matches!(reply.status, 401 | 404), "{path}: {reply:?}");
    }
    let over = [
        ("x-http-method-override", "DELETE"),
        ("x-method-override", "DELETE"),
    ];
    let reply = cell
        .send_with("GET", "/livez", "", &over, &Value::Null)
        .await;
    assert_eq!(reply.status, 200);
    assert_eq!(
        cell.send("HEAD", "/api/v1/cells", "", &Value::Null)
            .await
            .status,
        401
    );
    assert_eq!(
        cell.send("PATCH", "/livez", "", &Value::Null).await.status,
        405
    );
}
