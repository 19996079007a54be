use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use journal::{
    Audit, AuditResult, Clocks, KeyRetention, MemoryDisk, MemoryJournal, Opening, Position, Record,
};
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::{Asked, CHUNKS, EventId, Events, Filter};
use crate::journal::SharedJournal;

/// A journal that keeps the newest records.
fn journal(kept: usize) -> SharedJournal {
    let opening = Opening {
        at: Clocks {
            wall: Timestamp::now(),
            monotonic: Duration::ZERO,
        },
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    let disk = MemoryDisk::forgetful(kept);
    SharedJournal::durable(MemoryJournal::open(&disk, &opening).unwrap())
}

async fn note(journal: &SharedJournal, action: &str) {
    let audit = Record::Audit(Audit {
        principal: "somebody".into(),
        action: action.into(),
        object: "something".into(),
        result: AuditResult::Done,
        request_id: None,
        cell: None,
        role: None,
        source: None,
        lease: None,
        before: None,
        after: None,
    });
    let _kept = journal.append(Timestamp::now(), audit).await.unwrap();
}

struct World {
    journal: SharedJournal,
    events: Events,
}

impl World {
    async fn new(kept: usize) -> Self {
        let journal = journal(kept);
        let recovered = crate::cell::test_handle(&journal).await;
        // Its first decision is the recovery.
        let mut kept = journal.watch();
        let _second = kept.wait_for(|last| *last >= Position(2)).await.unwrap();
        let events = Events::start(
            journal.clone(),
            Timestamp::UNIX_EPOCH,
            vec![(Arc::from("c1"), recovered)],
            &TaskTracker::new(),
            CancellationToken::new(),
        );
        Self { journal, events }
    }

    fn listen(&self, from: Option<EventId>, filter: Filter) -> Listener {
        let (chunks, received) = mpsc::channel(CHUNKS);
        let asked = Asked {
            cell: Arc::from("c1"),
            from,
            filter,
            status: None,
        };
        drop(tokio::spawn(self.events.clone().send(asked, chunks)));
        Listener {
            chunks: received,
            text: String::new(),
        }
    }

    /// Waits until the events of everything that was kept are made.
    async fn made(&self) {
        let last = self.journal.head().position;
        let mut news = self.events.listen();
        let _newest = news.wait_for(|id| id.position >= last).await.unwrap();
    }
}

struct Listener {
    chunks: mpsc::Receiver<bytes::Bytes>,
    text: String,
}

impl Listener {
    /// The next block that is neither empty nor the beginning of the stream.
    async fn block(&mut self) -> String {
        loop {
            if let Some((block, rest)) = self.text.split_once("\n\n") {
                let block = block.to_owned();
                self.text = rest.to_owned();
                if !block.starts_with(":robocell") {
                    return block;
                }
                continue;
            }
            let chunk = self.chunks.recv().await.expect("the stream goes on");
            self.text.push_str(str::from_utf8(&chunk).unwrap());
        }
    }
}

#[tokio::test(start_paused = true)]
async fn silence_is_broken_every_15_seconds() {
    let world = World::new(1_000).await;
    let mut listener = world.listen(None, Filter::default());
    assert!(listener.block().await.starts_with("id: 1-"));
    let begun = tokio::time::Instant::now();
    for beat in 1..=3 {
        assert!(listener.block().await.starts_with(":hb\nid: 1-"));
        assert_eq!(begun.elapsed().as_secs(), beat * 15);
    }
}

#[tokio::test]
async fn a_filter_leaves_out_other_types_and_jobs() {
    let world = World::new(1_000).await;
    let filter = |types: &[&str]| Filter {
        types: types.iter().map(|text| (*text).to_owned()).collect(),
        job: None,
    };
    let mut all = world.listen(Some(EventId::START), Filter::default());
    let mut audit = world.listen(
        Some(EventId::START),
        filter(&["robocell.job", "robocell.audit"]),
    );
    note(&world.journal, "look").await;
    assert!(all.block().await.contains("robocell.server.started"));
    let only = audit.block().await;
    assert!(
        only.contains("\"type\":\"robocell.audit\"") && only.contains("look of something"),
        "{only}"
    );
    // A beginning counts up to a dot.
    let mut none = world.listen(
        Some(EventId::START),
        filter(&["robocell.aud", "robocell.server.started"]),
    );
    assert!(none.block().await.contains("robocell.server.started"));
    note(&world.journal, "look again").await;
    assert!(audit.block().await.contains("look again"));
}

/// Covers: R5. The memory for it is bounded: what one chunk holds, a few of them, and the ring.
#[tokio::test]
async fn a_listener_that_reads_too_slowly_hears_that_events_are_missing() {
    let world = World::new(100_000).await;
    let mut slow = world.listen(None, Filter::default());
    assert!(slow.block().await.starts_with("id: 1-"));
    for batch in 0..60 {
        for one in 0..100 {
            note(&world.journal, &format!("{batch}.{one}")).await;
        }
        world.made().await;
    }
    let mut events = 0;
    let gap = loop {
        let block = slow.block().await;
        if block.starts_with("event: gap") {
            break block;
        }
        events += 1;
    };
    assert!(gap.contains("\"reason\":\"SLOW\""), "{gap}");
    assert!(events < 2_000, "{events} events waited for the listener");
    // It goes on with what happens from now on.
    note(&world.journal, "after").await;
    let next = slow.block().await;
    assert!(next.contains("after of something"), "{next}");
}

#[tokio::test]
async fn what_happens_while_nobody_listens_is_not_missed_by_whoever_comes_back() {
    let world = World::new(1_000).await;
    let mut first = world.listen(None, Filter::default());
    assert!(first.block().await.starts_with("id: 1-"));
    note(&world.journal, "heard").await;
    let heard = first.block().await;
    let id = heard.lines().find_map(|line| line.strip_prefix("id: "));
    let from = id.and_then(EventId::parse).expect("it has an id");
    drop(first);
    // The records that follow end the stream whose reader has gone; then nobody listens.
    let mut unheard = 0;
    while world.events.has_listeners() {
        note(&world.journal, &format!("unheard {unheard}")).await;
        unheard += 1;
        tokio::task::yield_now().await;
    }
    for _ in 0..10 {
        note(&world.journal, &format!("unheard {unheard}")).await;
        unheard += 1;
        tokio::task::yield_now().await;
    }
    let mut back = world.listen(Some(from), Filter::default());
    let mut new = world.listen(None, Filter::default());
    for number in 0..unheard {
        let block = back.block().await;
        assert!(block.contains(&format!("unheard {number} of")), "{block}");
    }
    assert!(new.block().await.starts_with("id: 1-"));
    note(&world.journal, "now").await;
    for listener in [&mut back, &mut new] {
        let block = listener.block().await;
        assert!(block.contains("now of something"), "{block}");
    }
}

#[tokio::test]
async fn what_is_forgotten_or_of_another_journal_is_a_gap() {
    let world = World::new(50).await;
    for number in 0..200 {
        note(&world.journal, &number.to_string()).await;
    }
    world.made().await;
    let head = world.journal.head().position;
    for (epoch, position, reason) in [
        (1, 3, "FORGOTTEN"),
        (9, head.0 - 5, "OTHER_JOURNAL"),
        (1, head.0 + 5, "OTHER_JOURNAL"),
    ] {
        let from = EventId {
            epoch,
            position: Position(position),
        };
        let mut listener = world.listen(Some(from), Filter::default());
        let gap = listener.block().await;
        assert!(
            gap.starts_with(&format!("event: gap\nid: 1-{head}\n")),
            "{gap}"
        );
        assert!(
            gap.contains(reason) && gap.contains(&format!("\"from\":\"{from}\"")),
            "{gap}"
        );
    }
    // What is kept goes on without one.
    let from = EventId {
        epoch: 1,
        position: Position(head.0 - 2),
    };
    let mut listener = world.listen(Some(from), Filter::default());
    for expected in ["198 of something", "199 of something"] {
        let block = listener.block().await;
        assert!(block.contains(expected), "{block}");
    }
}
