//! The records of version 1, one of each kind, as they were first written.
//!
//! If a test here fails, do not change the files: journals in the field have these bytes. See the rules of
//! evolution in `src/record/mod.rs`.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use std::collections::BTreeSet;
use std::path::PathBuf;

use common::{at, claim, intent, job, job_created, motion, outcome};
use journal::{
    Accepted, Answer, Arrival, Asked, Audit, AuditResult, CellDecided, Completion, Decision,
    DecisionId, Digest, End, Epoch, Head, Hold, JobEnd, JobEnded, JobStep, KeyRetention, Mode,
    NoMotion, Observation, Position, Pruned, Record, ServerStarted, SignalId, SignalReceived,
    SnapshotTaken, Standstill, StepState, Stored, Subject, Walker, read_line,
};
use uuid::Uuid;

fn testdata() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata/v1")
}

fn observation() -> Observation {
    Observation {
        fence_at: Some(at(1).wall),
        first_at: at(2).wall,
        second_at: at(3).wall,
        pose: intent(Epoch(1), 1, None).target,
        standstill: Standstill::Standing,
        hold: Hold::Free,
        mode: Mode::Auto,
        boot: Some(12),
        pendant_since: None,
        alarm: Some("SRVO-050".into()),
    }
}

fn full_intent() -> Record {
    let mut intent = intent(Epoch(1), 1, Some(claim("k1", "body")));
    intent.job = Some(job(2));
    intent.reason = Some("teach check".into());
    Record::Intent(Box::new(intent))
}

/// With what was added to version 1 later.
fn asked_intent() -> Record {
    let mut intent = intent(Epoch(1), 1, None);
    intent.speed_um_s = 0;
    intent.asked = Some(Box::new(Asked {
        output: None,
        motion_type: "RELATIVE".into(),
        principal: "anna".into(),
        joints_mdeg: [0, 0, 0, 0, -90_000, 0],
        speed_percent: Some(20),
        not_after: Some(at(9).wall),
        wire_epoch: Some(1_000),
        boot: Some(7),
        to_joints: true,
        from: Some(intent.target),
    }));
    Record::Intent(Box::new(intent))
}

/// One of each kind, and of each way a motion ends.
fn examples() -> Vec<(&'static str, Record)> {
    let mut examples = motion_examples();
    examples.extend(work_examples());
    examples.extend(upkeep_examples());
    examples
}

fn motion_examples() -> Vec<(&'static str, Record)> {
    let decision = DecisionId(Uuid::from_u128(3));
    let ends = |end| outcome(1, end);
    let code = || "controller-timeout".to_owned();
    vec![
        (
            "server_started",
            Record::ServerStarted(ServerStarted {
                epoch: Epoch(1),
                program: "robocell 0.1.0".into(),
                keys: KeyRetention {
                    max_age_s: 604_800,
                    max_count: 20_000,
                },
            }),
        ),
        ("intent", full_intent()),
        ("intent_asked", asked_intent()),
        (
            "outcome_interrupted",
            ends(End::Interrupted {
                reason: "stopped".into(),
                seen: Some(observation()),
            }),
        ),
        (
            "accepted",
            Record::Accepted(Accepted {
                motion: motion(1),
                text: "SUCESS: MOVEMENT COMPLETE".into(),
                completion: Completion::Observable,
            }),
        ),
        (
            "outcome_done_observed",
            ends(End::Done {
                evidence: Arrival::Observed(observation()),
            }),
        ),
        (
            "outcome_done_decided",
            ends(End::Done {
                evidence: Arrival::Decided { decision },
            }),
        ),
        (
            "outcome_rejected",
            ends(End::Rejected {
                text: "ERROR: POINT UNREACHABLE".into(),
            }),
        ),
        (
            "outcome_not_sent",
            ends(End::NotExecuted {
                evidence: NoMotion::NotSent { code: code() },
            }),
        ),
        (
            "outcome_not_executed_observed",
            ends(End::NotExecuted {
                evidence: NoMotion::Observed(observation()),
            }),
        ),
        (
            "outcome_not_executed_decided",
            ends(End::NotExecuted {
                evidence: NoMotion::Decided { decision },
            }),
        ),
        (
            "outcome_in_doubt",
            ends(End::InDoubt {
                code: code(),
                text: Some("SUC".into()),
                seen: Some(observation()),
            }),
        ),
    ]
}

fn work_examples() -> Vec<(&'static str, Record)> {
    let decision = DecisionId(Uuid::from_u128(3));
    vec![
        ("job_created", job_created(2, Some(claim("k2", "body")))),
        (
            "job_step",
            Record::JobStep(JobStep {
                job: job(2),
                step: "A8".into(),
                attempt: 1,
                state: StepState::Running,
                motion: Some(motion(1)),
                detail: Some("to the pre-pick pose".into()),
            }),
        ),
        (
            "job_ended",
            Record::JobEnded(JobEnded {
                job: job(2),
                end: JobEnd::Stopped,
                reason: Some("cancelled".into()),
            }),
        ),
        (
            "signal_received",
            Record::SignalReceived(SignalReceived {
                signal: SignalId(Uuid::from_u128(4)),
                robot: "mr1".into(),
                name: "MR_ARRIVED".into(),
                job: Some(job(2)),
                token: Some("t1".into()),
                body: Digest::of(b"{}"),
            }),
        ),
        (
            "decision",
            Record::Decision(Decision {
                decision,
                subject: Subject::Motion(motion(1)),
                answer: Answer::DidNotHappen,
                principal: "anna".into(),
                reason: "the arm stands at the start".into(),
            }),
        ),
        (
            "audit",
            Record::Audit(Audit {
                principal: "otto".into(),
                action: "limits.update".into(),
                object: "c1/r1".into(),
                result: AuditResult::Denied,
                request_id: Some("q9".into()),
                cell: None,
                role: None,
                source: None,
                lease: None,
                before: Some("{\"max\":1}".into()),
                after: Some("{\"max\":2}".into()),
            }),
        ),
        (
            "cell_decided",
            Record::CellDecided(CellDecided {
                cell: "c1".into(),
                facts: "[{\"fact\":\"job_created\"}]".into(),
                claim: None,
            }),
        ),
        (
            "cell_decided_asked",
            Record::CellDecided(CellDecided {
                cell: "c1".into(),
                facts: "[{\"fact\":\"job_created\"}]".into(),
                claim: Some(claim("k3", "body")),
            }),
        ),
    ]
}

fn upkeep_examples() -> Vec<(&'static str, Record)> {
    vec![
        (
            "snapshot_taken",
            Record::SnapshotTaken(SnapshotTaken {
                cell: "c1".into(),
                covers: Head {
                    position: Position(6),
                    hash: Digest::of(b"6"),
                },
                format: 1,
                bytes: 4,
                digest: Digest::of(b"text"),
            }),
        ),
        (
            "pruned",
            Record::Pruned(Pruned {
                through: Head {
                    position: Position(3),
                    hash: Digest::of(b"3"),
                },
                records: 3,
                epoch: Epoch(1),
                keys: KeyRetention {
                    max_age_s: 604_800,
                    max_count: 20_000,
                },
                archive: Some("journal-1-3.jsonl".into()),
            }),
        ),
    ]
}

#[test]
fn each_kind_has_the_bytes_it_always_had() {
    let mut kinds = BTreeSet::new();
    for (name, record) in examples() {
        let _new = kinds.insert(record.kind());
        let stored = Stored {
            position: Position(7),
            epoch: Epoch(1),
            at: at(5),
            record,
        };
        let path = testdata().join(format!("{name}.json"));
        let frozen = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let frozen = frozen.trim_end();
        assert_eq!(stored.encode().unwrap(), frozen, "{name}");
        assert_eq!(Stored::decode(frozen.as_bytes()).unwrap(), stored, "{name}");
    }
    assert_eq!(kinds.len(), 13, "each kind has an example");
    let files = std::fs::read_dir(testdata()).unwrap();
    let files = files.filter(|file| {
        let path = file.as_ref().unwrap().path();
        path.extension()
            .is_some_and(|extension| extension == "json")
    });
    assert_eq!(files.count(), examples().len(), "each file has an example");
}

#[test]
fn a_field_of_a_newer_program_is_passed_over_and_still_hashed() {
    let line = std::fs::read_to_string(testdata().join("audit.json")).unwrap();
    let newer = line
        .trim_end()
        .replace("\"object\":", "\"shift\":\"late\",\"object\":");
    let read = Stored::decode(newer.as_bytes()).unwrap();
    assert_eq!(read, Stored::decode(line.as_bytes()).unwrap());
    let before = Head {
        position: Position(6),
        hash: Digest::ZERO,
    };
    assert_ne!(
        before.extend(newer.as_bytes()),
        before.extend(line.trim_end().as_bytes())
    );
}

#[test]
fn a_journal_of_the_first_version_holds() {
    let lines = std::fs::read_to_string(testdata().join("journal.jsonl")).unwrap();
    let mut walker = Walker::new(Head::EMPTY);
    for (line, number) in lines.lines().zip(1..) {
        let _stored = walker
            .step(&read_line(line.as_bytes(), number).unwrap())
            .unwrap();
    }
    let head = walker.finish().unwrap();
    assert_eq!(head.position, Position(16));
    assert_eq!(
        head.hash.to_string(),
        "e9db9628cc39ba47192f2a6647c11f4da17e0ce3f089537971f95521d457388b"
    );
}
