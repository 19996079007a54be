use std::time::Duration;

use jiff::Timestamp;
use uuid::Uuid;

use super::*;
use crate::{
    Accepted, Begun, Completion, Decision, DecisionId, Digest, End, IdempotencyKey, Intent,
    KeyRetention, Outcome, Refusal, Repeatability, Subject, Target,
};

fn at(second: i64) -> Clocks {
    Clocks {
        wall: Timestamp::from_second(1_800_000_000 + second).unwrap(),
        monotonic: Duration::from_secs(u64::try_from(second).unwrap()),
    }
}

fn open(disk: &MemoryDisk) -> MemoryJournal {
    let opening = Opening {
        at: at(0),
        program: "test".into(),
        keys: KeyRetention {
            max_age_s: 60,
            max_count: 3,
        },
    };
    MemoryJournal::open(disk, &opening).unwrap()
}

fn id(n: u128) -> MotionId {
    MotionId(Uuid::from_u128(n))
}

fn claim(key: &str, body: &str) -> Claim {
    Claim {
        key: IdempotencyKey::try_new(key).unwrap(),
        body: Digest::of(body.as_bytes()),
    }
}

fn intent(journal: &MemoryJournal, n: u128, claim: Option<Claim>) -> Intent {
    Intent {
        motion: id(n),
        cell: "c1".into(),
        robot: "r1".into(),
        epoch: journal.epoch(),
        seq: 1,
        target: Target {
            x_um: 1,
            y_um: 2,
            z_um: 3,
            w_mdeg: 4,
            p_mdeg: 5,
            r_mdeg: 6,
        },
        speed_um_s: 7,
        class: Repeatability::AbsoluteFree,
        request_id: "q".into(),
        claim,
        job: None,
        reason: None,
        asked: None,
    }
}

fn outcome(n: u128, end: End) -> Record {
    Record::Outcome(Outcome { motion: id(n), end })
}

fn rejected() -> End {
    End::Rejected {
        text: "ERROR: POINT UNREACHABLE".into(),
    }
}

fn in_doubt() -> End {
    End::InDoubt {
        code: "controller-timeout".into(),
        text: None,
        seen: None,
    }
}

fn refusal(error: AppendError) -> Refusal {
    if let AppendError::Refused(refusal) = error {
        return refusal;
    }
    panic!("not a refusal: {error:?}");
}

/// Covers: D3.
#[tokio::test]
async fn a_power_loss_takes_what_is_not_durable_and_nothing_else() {
    let disk = MemoryDisk::new();
    let journal = open(&disk);
    let begun = journal.begin_motion(at(1), intent(&journal, 1, None)).await;
    assert!(matches!(begun, Ok(Begun::New(_))));
    disk.hold_syncs();
    let held = tokio::spawn({
        let second = intent(&journal, 2, None);
        async move { (journal.begin_motion(at(2), second).await, journal) }
    });
    while disk.lock().waiting() == 0 {
        tokio::task::yield_now().await;
    }
    disk.lose_power();
    let (lost, journal) = held.await.unwrap();
    assert_eq!(lost.unwrap_err().effect(), Effect::Unknown);
    assert!(matches!(
        journal.motion(id(1)).await,
        Err(ReadError::Closed)
    ));

    let journal = open(&disk);
    assert_eq!(journal.epoch(), Epoch(2));
    let open = [MotionPhase::Open];
    let left = journal.motions(&open, Position::START, 10).await.unwrap();
    assert_eq!(
        left.iter().map(|left| left.motion).collect::<Vec<_>>(),
        [id(1)]
    );
}

/// Covers: D2.
#[tokio::test]
async fn a_failed_write_poisons_the_journal_until_it_is_opened_again() {
    for (fault, effect) in [
        (Fault::Refuse, Effect::None),
        (Fault::RefuseAndKeep, Effect::Unknown),
    ] {
        let disk = MemoryDisk::new();
        let journal = open(&disk);
        disk.fail_write(2, fault);
        let failed = journal.begin_motion(at(1), intent(&journal, 1, None)).await;
        assert_eq!(failed.unwrap_err().effect(), effect);
        let next = journal.begin_motion(at(2), intent(&journal, 2, None)).await;
        assert!(matches!(next, Err(AppendError::Poisoned(_))));
        drop(journal);
        let journal = open(&disk);
        let kept = journal.motion(id(1)).await.unwrap().is_some();
        assert_eq!(kept, effect == Effect::Unknown);
        assert!(journal.motion(id(2)).await.unwrap().is_none());
    }
}

#[tokio::test]
async fn a_fault_of_a_kind_waits_for_the_next_record_of_that_kind() {
    let disk = MemoryDisk::new();
    let journal = open(&disk);
    disk.fail_next("outcome", Fault::Refuse);
    let _kept = journal
        .begin_motion(at(1), intent(&journal, 1, None))
        .await
        .unwrap();
    let failed = journal.append(at(2), outcome(1, rejected())).await;
    assert_eq!(failed.unwrap_err().effect(), Effect::None);
}

/// Covers: P2.
#[tokio::test]
async fn wherever_the_power_goes_every_answer_that_was_given_holds() {
    for fault in [Fault::PowerLossBefore, Fault::PowerLossAfter] {
        for nth in 2..=7 {
            let disk = MemoryDisk::new();
            let journal = open(&disk);
            disk.fail_write(nth, fault);
            let mut confirmed = 0;
            for n in 1..=3 {
                let first = journal.begin_motion(at(1), intent(&journal, n, None)).await;
                confirmed += usize::from(first.is_ok());
                let second = journal.append(at(1), outcome(n, rejected())).await;
                confirmed += usize::from(second.is_ok());
            }
            assert_eq!(confirmed, usize::try_from(nth).unwrap() - 2);
            drop(journal);
            let journal = open(&disk);
            let records = journal.page(Position(1), 100).await.unwrap();
            let unconfirmed = usize::from(fault == Fault::PowerLossAfter);
            // The records, and the second opening.
            assert_eq!(records.len(), confirmed + unconfirmed + 1);
        }
    }
}

/// Covers: H6, H7.
#[tokio::test]
async fn a_key_gives_the_first_answer_again_and_only_when_there_is_one() {
    let disk = MemoryDisk::new();
    let journal = open(&disk);
    let key = claim("k", "a");
    let first = intent(&journal, 1, Some(key.clone()));
    let again = intent(&journal, 2, Some(key.clone()));
    let _begun = journal.begin_motion(at(1), first).await.unwrap();
    let busy = journal.begin_motion(at(2), again.clone()).await;
    assert_eq!(
        refusal(busy.unwrap_err()),
        Refusal::KeyInFlight { motion: id(1) }
    );
    let _end = journal.append(at(3), outcome(1, rejected())).await.unwrap();
    let Begun::Replayed(replay) = journal.begin_motion(at(4), again).await.unwrap() else {
        panic!("sent twice");
    };
    assert_eq!(replay.first.record.motion(), Some(id(1)));
    assert_eq!(
        replay.outcome.map(|outcome| outcome.record),
        Some(outcome(1, rejected()))
    );
    assert!(journal.lookup(&key, at(4)).await.unwrap().is_some());
    let other = intent(&journal, 3, Some(claim("k", "b")));
    let other = journal.begin_motion(at(5), other).await;
    assert_eq!(
        refusal(other.unwrap_err()),
        Refusal::KeyReused { first: Position(2) }
    );
}

#[tokio::test]
async fn keys_are_forgotten_by_age_and_by_number_unless_in_flight() {
    let disk = MemoryDisk::new();
    let journal = open(&disk);
    let flying = intent(&journal, 1, Some(claim("flying", "")));
    let _begun = journal.begin_motion(at(0), flying).await.unwrap();
    for n in 2..=5 {
        let key = claim(&format!("k{n}"), "");
        let intent = intent(&journal, n, Some(key));
        let _begun = journal.begin_motion(at(1), intent).await.unwrap();
        let _end = journal.append(at(1), outcome(n, rejected())).await.unwrap();
    }
    let known = async |key: &str, second| {
        let found = journal.lookup(&claim(key, ""), at(second)).await;
        found.map(|found| found.is_some())
    };
    assert!(matches!(
        known("flying", 1).await,
        Err(LookupError::Refused(_))
    ));
    assert!(!known("k3", 1).await.unwrap(), "three keys are remembered");
    assert!(known("k4", 1).await.unwrap());
    assert!(known("k5", 60).await.unwrap());
    assert!(!known("k5", 61).await.unwrap());
    assert!(matches!(
        known("flying", 99).await,
        Err(LookupError::Refused(_))
    ));
}

#[tokio::test]
async fn a_story_has_one_end_and_a_doubt_has_one_decision() {
    let disk = MemoryDisk::new();
    let journal = open(&disk);
    let _begun = journal.begin_motion(at(1), intent(&journal, 1, None)).await;
    let accepted = Record::Accepted(Accepted {
        motion: id(1),
        text: "ok".into(),
        completion: Completion::Observable,
    });
    let _accepted = journal.append(at(2), accepted).await.unwrap();
    let _doubt = journal.append(at(3), outcome(1, in_doubt())).await.unwrap();
    let decision = |n| {
        Record::Decision(Decision {
            decision: DecisionId(Uuid::from_u128(n)),
            subject: Subject::Motion(id(1)),
            answer: crate::Answer::DidNotHappen,
            principal: "anna".into(),
            reason: "the arm stands at the start".into(),
        })
    };
    let _decided = journal.append(at(4), decision(1)).await.unwrap();
    let second = journal.append(at(5), decision(2)).await;
    assert!(matches!(
        refusal(second.unwrap_err()),
        Refusal::MotionPhase {
            phase: MotionPhase::Decided,
            ..
        }
    ));
    let not_executed = End::NotExecuted {
        evidence: crate::NoMotion::Decided {
            decision: DecisionId(Uuid::from_u128(1)),
        },
    };
    let _end = journal
        .append(at(6), outcome(1, not_executed))
        .await
        .unwrap();
    let after = journal.append(at(7), outcome(1, rejected())).await;
    assert!(matches!(
        refusal(after.unwrap_err()),
        Refusal::MotionPhase {
            phase: MotionPhase::Closed,
            ..
        }
    ));
}

#[tokio::test]
async fn only_one_journal_is_open_on_a_disk() {
    let disk = MemoryDisk::new();
    let first = open(&disk);
    let opening = Opening {
        at: at(0),
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    assert!(matches!(
        MemoryJournal::open(&disk, &opening),
        Err(MemoryOpenError::InUse)
    ));
    drop(first);
    assert!(MemoryJournal::open(&disk, &opening).is_ok());
}
