//! A faithful controller is as silent as a real one, a kind one explains itself; and what a generation translates.

mod common;

use common::{PORT, Stepped, arm, config_of, http};
use karel_emulator::config::InterpolationPeriod;
use karel_emulator::state::TaskWord;
use karel_emulator::{
    Clock, ControlAccess, ControllerConfig, ControllerGeneration, Fidelity, PeerLabels,
    ProgramSource, StartError, VirtualController,
};
use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

/// Takes a number from columns of a line, as servers with columns do: another width leaves it without a value.
const COLUMNS: &str = "PROGRAM columns
%NOLOCKGROUP
VAR
  link : FILE
  line : STRING[80]
  value, sum : REAL
  frame : POSITION
  entry, status : INTEGER
  number : STRING[1]
BEGIN
  CNV_INT_STR(8, 1, 0, number)
  GET_VAR(entry, '*SYSTEM*', '$MNUFRAME[1, ' + number + ']', frame, status)
  SET_VAR(entry, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, status)
  MSG_CONNECT('S3:', status)
  OPEN FILE link('RW', 'S3:')
  READ link(line)
  CNV_STR_REAL(SUB_STR(line, 5, 8), value)
  sum = value + 1
  WRITE link('0:success')
  CLOSE FILE link
  MSG_DISCO('S3:', status)
END columns
";

async fn send(controller: &Stepped, bytes: &[u8]) -> TcpStream {
    controller.advance(0.1).await;
    let mut stream = TcpStream::connect(controller.address().await)
        .await
        .expect("the port is open");
    controller.advance(0.1).await;
    stream.write_all(bytes).await.expect("it is connected");
    // What the kernel has is taken by the first step or by a later one.
    for _ in 0..20 {
        controller.advance(0.1).await;
        tokio::task::yield_now().await;
    }
    stream
}

fn columns(fidelity: Fidelity) -> Stepped {
    let mut config = config_of(COLUMNS, &[PORT]);
    config.fidelity = fidelity;
    Stepped::start(&config)
}

async fn texts(cell: &Stepped) -> Vec<String> {
    let notes = cell.controller.with(|core| core.notes(0)).await;
    let notes = notes.expect("it runs");
    notes
        .iter()
        .map(|note| {
            let place = note.program.as_deref().zip(note.line);
            format!("{place:?} {}", note.text)
        })
        .collect()
}

#[tokio::test]
async fn a_faithful_controller_leaves_the_client_of_a_dead_server_waiting_and_says_nothing() {
    let cell = columns(Fidelity::Faithful);
    let stream = send(&cell, b"sum:+x00000001.5\n").await;
    assert_eq!(cell.task_word().await, TaskWord::Aborted);
    let mut byte = [0];
    let nothing = stream.try_read(&mut byte).unwrap_err();
    assert_eq!(nothing.kind(), std::io::ErrorKind::WouldBlock);
    let state = cell.controller.state().await.unwrap();
    assert_eq!(
        (state.note_seq, state.tags[0].state.as_str()),
        (0, "connected")
    );
    assert!(texts(&cell).await.is_empty());
}

#[tokio::test]
async fn a_kind_controller_disconnects_the_client_of_a_dead_server_and_says_why() {
    let cell = columns(Fidelity::Kind);
    let mut stream = send(&cell, b"sum:+x00000001.5\n").await;
    assert_eq!(cell.task_word().await, TaskWord::Aborted);
    assert_eq!(common::read_to_end(&mut stream).await, "");
    let texts = texts(&cell).await;
    for (at, parts) in [
        (
            0,
            [
                "(\"COLUMNS\", 12)",
                "GET_VAR of \"$MNUFRAME[1,  ]\"",
                "VARS",
            ],
        ),
        (
            1,
            [
                "(\"COLUMNS\", 17)",
                "CNV_STR_REAL finds no number",
                "\"+x000000\"",
            ],
        ),
        (
            2,
            ["(\"COLUMNS\", 18)", "INTP-311", "\"sum:+x00000001.5\\n\""],
        ),
    ] {
        for part in parts {
            assert!(texts[at].contains(part), "{part} in {texts:#?}");
        }
    }
    assert_eq!(texts.len(), 3, "{texts:#?}");
}

#[tokio::test]
async fn what_a_program_and_its_client_see_is_the_same_in_both() {
    for fidelity in [Fidelity::Faithful, Fidelity::Kind] {
        let cell = columns(fidelity);
        let mut stream = send(&cell, b"sum:+00001.5\r\n").await;
        assert_eq!(common::read_to_end(&mut stream).await, "0:success");
        assert_eq!(cell.task_word().await, TaskWord::Ended);
    }
}

#[tokio::test]
async fn a_kind_controller_says_what_a_read_waits_for() {
    for (fidelity, expected) in [
        (Fidelity::Faithful, None),
        (Fidelity::Kind, Some("\"sum:\", 4 bytes from 127.0.0.1:")),
    ] {
        let cell = columns(fidelity);
        let _stream = send(&cell, b"sum:").await;
        let state = cell.controller.state().await.unwrap();
        let hint = state.tasks[0].hint.clone();
        assert_eq!(state.tasks[0].detail.as_deref(), Some("waits for bytes"));
        match expected {
            None => assert_eq!(hint, None),
            Some(start) => {
                let hint = hint.unwrap();
                assert!(
                    hint.starts_with(start) && hint.contains("line end"),
                    "{hint}"
                );
            }
        }
    }
}

#[tokio::test]
async fn a_kind_controller_says_why_a_tag_is_refused_and_a_pose_out_of_reach() {
    let program = "PROGRAM asks
VAR p : XYZWPREXT
    status : INTEGER
BEGIN
  MSG_CONNECT('S3:', status)
  p = CURPOS(0, 0)
  p.x = 9000
  CHECK_EPOS(p, $UFRAME, $UTOOL, status)
END asks
";
    let mut config = config_of(program, &[]);
    config.fidelity = Fidelity::Kind;
    config.presets = vec![("$HOSTS_CFG[3].$STATE".to_owned(), "2".to_owned())];
    let cell = Stepped::start(&config);
    cell.advance(2.0).await;
    let texts = texts(&cell).await;
    assert!(texts[0].contains("$HOSTS_CFG[3].$STATE is 2"), "{texts:?}");
    assert!(texts[1].contains("CHECK_EPOS answers MOTN-"), "{texts:?}");
}

fn shipped(name: &str) -> ProgramSource {
    let path = format!("{}/../programs/{name}", env!("CARGO_MANIFEST_DIR"));
    ProgramSource::new(name, std::fs::read(path).expect("it is shipped"))
}

fn start(generation: ControllerGeneration, program: ProgramSource) -> Result<(), StartError> {
    let mut config = ControllerConfig::new("test", arm()).with_program(program);
    for name in [
        "mappdk_wire.kl",
        "cell_wire.kl",
        "cell_look.kl",
        "cell_share.kl",
    ] {
        let mut include = shipped(&format!("include/{name}"));
        include.name = format!("include/{name}");
        config = config.with_include(include);
    }
    config.generation = generation;
    let (clock, _stepper) = Clock::stepped();
    VirtualController::start(&config, clock, PeerLabels::new()).map(drop)
}

#[tokio::test]
async fn a_controller_of_generation_9_does_not_translate_move() {
    use ControllerGeneration::{Any, V7, V9};
    assert!(start(Any, shipped("sock_server.kl")).is_ok());
    assert!(start(V7, shipped("sock_server.kl")).is_ok());
    let refused = start(V9, shipped("sock_server.kl"))
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("MOVE is not translated for generation v9"),
        "{refused}"
    );
    assert!(start(V9, shipped("mappdk_server.kl")).is_ok());
    assert!(start(V9, shipped("cell_server.kl")).is_ok());
}

#[tokio::test]
async fn a_controller_of_generation_7_has_strings_of_128_characters() {
    use ControllerGeneration::{Any, V7, V9};
    let program = |length| {
        let text = format!("PROGRAM p\nVAR s : STRING[{length}]\nBEGIN\nEND p\n");
        ProgramSource::new("p.kl", text)
    };
    assert!(start(V7, program(128)).is_ok());
    let refused = start(V7, program(129)).unwrap_err().to_string();
    assert!(refused.contains("from 1 to 128"), "{refused}");
    for generation in [Any, V9] {
        assert!(start(generation, program(254)).is_ok());
        assert!(start(generation, program(255)).is_err());
    }
}

#[test]
fn a_literal_is_no_longer_than_the_strings_of_its_generation() {
    use karel::Generation::{Any, V7, V9};
    let files = karel::IncludeFiles::default();
    let check = |generation, length| {
        let text = "x".repeat(length);
        for source in [
            format!("PROGRAM p\nBEGIN\nWRITE ('{text}')\nEND p\n"),
            format!("PROGRAM p\nCONST c = '{text}'\nBEGIN\nEND p\n"),
        ] {
            let program =
                karel::Program::for_generation(source.as_bytes(), "p.kl", &files, generation);
            let _program = program.map_err(|errors| errors[0].message.clone())?;
        }
        Ok(())
    };
    for (generation, most, of) in [
        (V7, 128, " of generation v7"),
        (V9, 254, " of generation v9"),
        (Any, 254, ""),
    ] {
        assert_eq!(check(generation, most), Ok(()));
        let refused = format!(
            "a string{of} has at most {most} bytes, this one has {}",
            most + 1
        );
        assert_eq!(check(generation, most + 1), Err(refused));
    }
}

#[test]
fn a_name_of_13_characters_is_a_warning_for_generation_7() {
    let source = b"PROGRAM thirteen_char\nVAR n : INTEGER\nBEGIN\nEND thirteen_char\n";
    let files = karel::IncludeFiles::default();
    for (generation, warnings) in [
        (karel::Generation::Any, 0),
        (karel::Generation::V7, 1),
        (karel::Generation::V9, 0),
    ] {
        let program = karel::Program::for_generation(source, "p.kl", &files, generation).unwrap();
        assert_eq!(program.warnings().len(), warnings, "{generation:?}");
    }
}

#[tokio::test]
async fn the_control_interface_shows_the_profile_and_lets_the_controller_explain_itself() {
    let mut config = config_of(COLUMNS, &[PORT]);
    config.generation = ControllerGeneration::V9;
    config.control = ControlAccess::Control;
    config.panel = Some(([127, 0, 0, 1], 0).into());
    let cell = Stepped::start(&config);
    let panel = cell.controller.panel_address().unwrap();
    let (status, profile) = http(panel, "GET", "/api/v1/profile", None).await;
    let expected = json!({
        "fidelity": "faithful", "generation": "v9", "version": "V9.10", "byte_order": "big",
        "interpolation_period_ms": 8.0, "missing_options": [],
    });
    assert_eq!((status, profile), (200, expected));
    let (_, version) = http(
        panel,
        "GET",
        "/api/v1/variable?path=$SCR_GRP%5B1%5D.$SV_CODE_ID",
        None,
    )
    .await;
    assert_eq!(version["value"], "V9.10");
    let kind = json!({"fidelity": "kind"});
    let (status, profile) = http(panel, "PATCH", "/api/v1/profile", Some(&kind)).await;
    assert_eq!((status, &profile["fidelity"]), (200, &json!("kind")));
    let (_, state) = http(panel, "GET", "/api/v1/state", None).await;
    assert_eq!(state["fidelity"], "kind");
    let _stream = send(&cell, b"sum:nothing\n").await;
    let (_, notes) = http(panel, "GET", "/api/v1/notes?after=1", None).await;
    let notes = notes["notes"].as_array().unwrap();
    assert_eq!(
        (notes[0]["seq"].as_u64(), notes[0]["program"].as_str()),
        (Some(2), Some("COLUMNS"))
    );
    let wrong = json!({"generation": "v7"});
    let (status, _) = http(panel, "PATCH", "/api/v1/profile", Some(&wrong)).await;
    assert!(
        (400..500).contains(&status),
        "it is built as it is: {status}"
    );
}

/// A DELAY of 9 ms ends at a multiple of the period.
#[test]
fn the_interpolation_period_is_that_of_the_configuration() {
    for (ms, expected) in [(4, 12.0), (8, 16.0), (16, 16.0)] {
        let source = "PROGRAM waits\nBEGIN\n  DELAY 9\nEND waits\n";
        let mut config =
            ControllerConfig::new("c", arm()).with_program(ProgramSource::new("waits.kl", source));
        config.interpolation_period = InterpolationPeriod::from_millis(ms).unwrap();
        let mut core = karel_emulator::controller::Controller::try_new(&config).unwrap();
        assert_eq!(
            core.profile().interpolation_period_ms.to_bits(),
            f64::from(ms).to_bits()
        );
        let mut over_at = None;
        for now in 0..30 {
            let until = std::time::Duration::from_millis(now);
            while core.advance(until) == karel_emulator::controller::Advance::Worked {}
            if over_at.is_none() && core.state().tasks[0].state == TaskWord::Ended {
                over_at = Some(f64::from(u32::try_from(now).unwrap()));
            }
        }
        assert_eq!(over_at, Some(expected), "{ms} ms");
    }
    assert!(InterpolationPeriod::from_millis(0).is_none());
    assert!(InterpolationPeriod::from_millis(65).is_none());
}
