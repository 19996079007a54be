//! What the tests of the journal share: times, ids, and one record of each kind.
#![allow(
    dead_code,
    reason = "each test file is a crate of its own and uses a part of this"
)]

use std::path::{Path, PathBuf};
use std::time::Duration;

use jiff::Timestamp;
use journal::{
    Accepted, Audit, AuditResult, Claim, Clocks, Completion, Digest, End, Epoch, Filesystem,
    IdempotencyKey, Intent, JobCreated, JobEnd, JobEnded, JobId, KeyRetention, MotionId, NoMotion,
    Opening, Outcome, Record, Repeatability, SqliteJournal, SqliteOptions, Target,
};
use tempfile::TempDir;
use uuid::Uuid;

pub(crate) const KEYS: KeyRetention = KeyRetention {
    max_age_s: 100,
    max_count: 3,
};

/// Seconds after an arbitrary moment.
pub(crate) fn at(second: u64) -> Clocks {
    Clocks {
        wall: Timestamp::from_second(1_800_000_000 + i64::try_from(second).unwrap()).unwrap(),
        monotonic: Duration::from_secs(second),
    }
}

pub(crate) fn opening() -> Opening {
    Opening {
        at: at(0),
        program: "test".into(),
        keys: KEYS,
    }
}

/// The directory for temporary files may be in memory; what is tested here does not depend on it.
pub(crate) fn options() -> SqliteOptions {
    SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    }
}

pub(crate) async fn open(path: &Path) -> SqliteJournal {
    SqliteJournal::open(path, &opening(), &options())
        .await
        .unwrap()
}

pub(crate) fn directory() -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cell.journal");
    (directory, path)
}

pub(crate) fn motion(n: u128) -> MotionId {
    MotionId(Uuid::from_u128(n))
}

pub(crate) fn job(n: u128) -> JobId {
    JobId(Uuid::from_u128(n))
}

pub(crate) fn claim(key: &str, body: &str) -> Claim {
    Claim {
        key: IdempotencyKey::try_new(key).unwrap(),
        body: Digest::of(body.as_bytes()),
    }
}

pub(crate) fn intent(epoch: Epoch, n: u128, claim: Option<Claim>) -> Intent {
    Intent {
        motion: motion(n),
        cell: "c1".into(),
        robot: "r1".into(),
        epoch,
        seq: u64::try_from(n).unwrap(),
        target: Target {
            x_um: 600_000,
            y_um: -200_000,
            z_um: 600_000,
            w_mdeg: 180_000,
            p_mdeg: 0,
            r_mdeg: 0,
        },
        speed_um_s: 200_000,
        class: Repeatability::AbsoluteFree,
        request_id: format!("q{n}"),
        claim,
        job: None,
        reason: None,
        asked: None,
    }
}

pub(crate) fn accepted(n: u128, completion: Completion) -> Record {
    Record::Accepted(Accepted {
        motion: motion(n),
        text: "SUCESS: MOVEMENT COMPLETE".into(),
        completion,
    })
}

pub(crate) fn outcome(n: u128, end: End) -> Record {
    Record::Outcome(Outcome {
        motion: motion(n),
        end,
    })
}

pub(crate) fn not_sent() -> End {
    End::NotExecuted {
        evidence: NoMotion::NotSent {
            code: "controller-disconnected".into(),
        },
    }
}

pub(crate) fn in_doubt() -> End {
    End::InDoubt {
        code: "controller-timeout".into(),
        text: None,
        seen: None,
    }
}

pub(crate) fn job_created(n: u128, claim: Option<Claim>) -> Record {
    Record::JobCreated(JobCreated {
        job: job(n),
        cell: "c1".into(),
        workflow: "delivery-and-placement".into(),
        version: 1,
        plan: Digest::of(b"plan"),
        params: "{}".into(),
        deadline: None,
        principal: "anna".into(),
        request_id: format!("q{n}"),
        claim,
    })
}

pub(crate) fn job_ended(n: u128) -> Record {
    Record::JobEnded(JobEnded {
        job: job(n),
        end: JobEnd::Complete,
        reason: None,
    })
}

pub(crate) fn audit(n: u64) -> Record {
    Record::Audit(Audit {
        principal: "anna".into(),
        action: "limits.update".into(),
        object: format!("r{n}"),
        result: AuditResult::Done,
        request_id: None,
        cell: None,
        role: None,
        source: None,
        lease: None,
        before: None,
        after: None,
    })
}
