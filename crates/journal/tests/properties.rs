//! Random stories: the store on disk and the one in memory say the same, and what is written is read.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use std::io::Cursor;

use common::{
    accepted, at, claim, directory, in_doubt, intent, job, job_created, job_ended, motion,
    not_sent, opening, options, outcome,
};
use journal::{
    Answer, Appended, CellDecided, Claim, Clocks, Completion, Decision, DecisionId, End, Epoch,
    Head, Journal, MemoryDisk, MemoryJournal, MotionPhase, NewSnapshot, Position, Record,
    SqliteJournal, Stored, Subject, export, import, verify,
};
use proptest::prelude::*;
use uuid::Uuid;

const PHASES: [MotionPhase; 5] = [
    MotionPhase::Open,
    MotionPhase::Accepted,
    MotionPhase::InDoubt,
    MotionPhase::Decided,
    MotionPhase::Closed,
];

/// A key and a body, out of few, so that they meet.
type Key = Option<(u8, u8)>;

#[derive(Clone, Copy, Debug)]
enum Step {
    Intent(u128, Key),
    Accepted(u128, Completion),
    Outcome(u128, Ending),
    Decision(u128),
    Job(u128, Key),
    JobEnded(u128),
    Decided,
    Snapshot,
    Prune(u64),
    Reopen,
}

#[derive(Clone, Copy, Debug)]
enum Ending {
    NotSent,
    InDoubt,
}

fn step() -> impl Strategy<Value = Step> {
    let n = 1..10_u128;
    let key = proptest::option::of((0..8_u8, 0..2_u8));
    let completion = prop_oneof![
        Just(Completion::Observable),
        Just(Completion::NotObservable)
    ];
    let ending = prop_oneof![Just(Ending::NotSent), Just(Ending::InDoubt)];
    prop_oneof![
        // New motions and jobs get a name of their own in `record`.
        4 => (n.clone(), key.clone()).prop_map(|(n, key)| Step::Intent(n, key)),
        2 => (n.clone(), completion).prop_map(|(n, completion)| Step::Accepted(n, completion)),
        4 => (n.clone(), ending).prop_map(|(n, ending)| Step::Outcome(n, ending)),
        1 => n.clone().prop_map(Step::Decision),
        2 => (n.clone(), key).prop_map(|(n, key)| Step::Job(n, key)),
        1 => n.prop_map(Step::JobEnded),
        2 => Just(Step::Decided),
        1 => Just(Step::Snapshot),
        2 => (1..60_u64).prop_map(Step::Prune),
        1 => Just(Step::Reopen),
    ]
}

fn steps() -> impl Strategy<Value = Vec<(Step, u64)>> {
    // The clock goes to and fro, over more than the age of a key.
    proptest::collection::vec((step(), 0..140_u64), 1..60)
}

fn record(step: Step, epoch: Epoch) -> Option<Record> {
    let claim = |key: Key| -> Option<Claim> {
        key.map(|(key, body)| claim(&format!("k{key}"), &body.to_string()))
    };
    Some(match step {
        Step::Intent(n, key) => Record::Intent(Box::new(intent(epoch, n, claim(key)))),
        Step::Accepted(n, completion) => accepted(n, completion),
        Step::Outcome(n, Ending::NotSent) => outcome(n, not_sent()),
        Step::Outcome(n, Ending::InDoubt) => outcome(n, in_doubt()),
        Step::Decision(n) => Record::Decision(Decision {
            decision: DecisionId(Uuid::from_u128(n)),
            subject: Subject::Motion(motion(n)),
            answer: Answer::Happened,
            principal: "anna".into(),
            reason: "seen".into(),
        }),
        Step::Job(n, key) => job_created(n, claim(key)),
        Step::JobEnded(n) => job_ended(n),
        Step::Decided => Record::CellDecided(CellDecided {
            cell: "c1".into(),
            facts: "[]".into(),
            claim: None,
        }),
        Step::Snapshot | Step::Prune(_) | Step::Reopen => return None,
    })
}

/// What an append said, so far as it can be compared.
async fn append(journal: &impl Journal, at: Clocks, record: Record) -> Result<Appended, String> {
    journal
        .append(at, record)
        .await
        .map_err(|error| format!("{error:?}"))
}

async fn same(on_disk: &impl Journal, in_memory: &impl Journal, now: Clocks) {
    assert_eq!(on_disk.head(), in_memory.head());
    assert_eq!(on_disk.epoch(), in_memory.epoch());
    let start = Position::START;
    assert_eq!(
        on_disk.page(start, 1_000).await.unwrap(),
        in_memory.page(start, 1_000).await.unwrap()
    );
    for phase in PHASES {
        assert_eq!(
            on_disk.motions(&[phase], start, 100).await.unwrap(),
            in_memory.motions(&[phase], start, 100).await.unwrap()
        );
    }
    assert_eq!(
        on_disk.open_jobs(start, 100).await.unwrap(),
        in_memory.open_jobs(start, 100).await.unwrap()
    );
    for n in 1..10 {
        assert_eq!(
            on_disk.motion(motion(n)).await.unwrap(),
            in_memory.motion(motion(n)).await.unwrap()
        );
        assert_eq!(
            on_disk.job(job(n)).await.unwrap(),
            in_memory.job(job(n)).await.unwrap()
        );
    }
    for key in 0..8 {
        let claim = claim(&format!("k{key}"), "0");
        let on_disk = on_disk.lookup(&claim, now).await;
        let in_memory = in_memory.lookup(&claim, now).await;
        assert_eq!(
            on_disk.map_err(|error| format!("{error:?}")),
            in_memory.map_err(|error| format!("{error:?}"))
        );
    }
}

/// Snapshots and removals; whether the step was one.
async fn upkeep(step: Step, on_disk: &impl Journal, in_memory: &impl Journal, now: Clocks) -> bool {
    match step {
        Step::Snapshot => {
            let start = Position::START;
            let decided = on_disk.decided("c1", start, 1_000).await.unwrap();
            let covers = match decided.last() {
                Some(last) => {
                    let before = Position(last.position.0 - 1);
                    let row = &on_disk.rows(before, 1).await.unwrap()[0];
                    Head {
                        position: row.position,
                        hash: row.hash,
                    }
                }
                None => Head::EMPTY,
            };
            let snapshot = NewSnapshot {
                cell: "c1".into(),
                covers,
                format: 1,
                body: format!("up to {}", covers.position),
            };
            let kept = on_disk.keep_snapshot(now, snapshot.clone()).await;
            let same = in_memory.keep_snapshot(now, snapshot).await;
            assert_eq!(format!("{kept:?}"), format!("{same:?}"));
            assert_eq!(
                on_disk.snapshot("c1").await.unwrap(),
                in_memory.snapshot("c1").await.unwrap()
            );
            true
        }
        Step::Prune(through) => {
            assert_eq!(
                on_disk.retained(now).await.unwrap(),
                in_memory.retained(now).await.unwrap()
            );
            let (through, archive) = (Position(through), Some("old.jsonl".to_owned()));
            let pruned = on_disk.prune(now, through, archive.clone()).await.unwrap();
            let same = in_memory.prune(now, through, archive).await.unwrap();
            assert_eq!(pruned, same);
            true
        }
        Step::Intent(..)
        | Step::Accepted(..)
        | Step::Outcome(..)
        | Step::Decision(_)
        | Step::Job(..)
        | Step::JobEnded(_)
        | Step::Decided
        | Step::Reopen => false,
    }
}

async fn run(steps: Vec<(Step, u64)>) {
    let (directory, path) = directory();
    let disk = MemoryDisk::new();
    let open = async || {
        SqliteJournal::open(&path, &opening(), &options())
            .await
            .unwrap()
    };
    let mut on_disk = open().await;
    let mut in_memory = MemoryJournal::open(&disk, &opening()).unwrap();
    let mut now = at(0);
    for (step, second) in steps {
        now = at(second);
        if upkeep(step, &on_disk, &in_memory, now).await {
            continue;
        }
        let Some(record) = record(step, on_disk.epoch()) else {
            on_disk.close().await;
            on_disk = open().await;
            drop(in_memory);
            in_memory = MemoryJournal::open(&disk, &opening()).unwrap();
            continue;
        };
        assert_eq!(
            append(&on_disk, now, record.clone()).await,
            append(&in_memory, now, record).await
        );
    }
    same(&on_disk, &in_memory, now).await;
    let head = on_disk.head();
    on_disk.close().await;

    let report = verify(&path, Some(head)).await.unwrap();
    assert_eq!(report.head, head);
    let mut lines = Vec::new();
    assert_eq!(export(&path, &mut lines).await.unwrap(), head);
    let copy = directory.path().join("copy");
    let imported = import(&copy, &mut Cursor::new(&lines)).await.unwrap();
    assert_eq!(imported, head);
    assert!(verify(&copy, Some(head)).await.is_ok());
    let mut again = Vec::new();
    let _head = export(&copy, &mut again).await.unwrap();
    assert_eq!(lines, again);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn the_store_on_disk_says_what_the_one_in_memory_says(steps in steps()) {
        tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap()
            .block_on(run(steps));
    }
}

proptest! {
    #[test]
    fn what_is_read_is_what_was_written_and_has_the_same_bytes(
        words in any::<String>(),
        n in any::<u128>(),
        position in 1..u64::MAX,
        second in 0..1_000_000_000_u64,
        nanosecond in 0..1_000_000_000_u32,
        numbers in any::<[i32; 6]>(),
    ) {
        let mut intent = intent(Epoch(position), 1, Some(claim("k", &words)));
        intent.motion = motion(n);
        intent.reason = Some(words.clone());
        intent.target.x_um = numbers[0];
        intent.target.r_mdeg = numbers[5];
        let mut clocks = at(second);
        clocks.wall += std::time::Duration::from_nanos(nanosecond.into());
        clocks.monotonic += std::time::Duration::from_nanos(nanosecond.into());
        for record in [
            Record::Intent(Box::new(intent)),
            outcome(n, End::InDoubt { code: "c".into(), text: Some(words), seen: None }),
        ] {
            let stored = Stored { position: Position(position), epoch: Epoch(position), at: clocks, record };
            let bytes = stored.encode().unwrap();
            let read = Stored::decode(bytes.as_bytes()).unwrap();
            prop_assert_eq!(&read, &stored);
            prop_assert_eq!(read.encode().unwrap(), bytes);
        }
    }
}
