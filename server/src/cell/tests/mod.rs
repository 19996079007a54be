//! A cell with the demo's set-up, an arm that does at once what it is told, and a mobile robot that a test speaks for.

mod clock;
mod full_disk;
mod hand_over;
mod push;
mod snapshots;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use api::{MobileMessage, OutboxMessage};
use journal::{Clocks, KeyRetention, MemoryDisk, MemoryJournal, Opening};
use tokio::sync::watch;
use uuid::Uuid;
use workflow::{
    Action, ArmSeen, BasePose, GripAction, Input, MobileState, NewJob, OpResult, Reply, Safety,
    Signal, SignalAnswer, SignalKind, SlotLoad,
};

use super::arm::{ArmPort, Later, Operation};
use super::handle::Refused;
use super::{CellHandle, Outboxes, testing};
use crate::clock::{SystemClock, WallClock};
use crate::config::{CellSection, Plan, RobotSection, ServerSection, SetupSource};
use crate::journal::{SharedJournal, Upkeep};
use crate::setup::SetupBook;

const DEMO: &str = include_str!("../../../../cell/demo.setup.toml");
const LIMIT: Duration = Duration::from_secs(20);

/// It does what it is told, at once.
#[derive(Debug)]
struct Willing(watch::Sender<ArmSeen>);

impl ArmPort for Willing {
    fn expected(&self, _: &Operation) -> Option<workflow::Millis> {
        None
    }

    fn operate(&self, operation: Operation) -> Later<OpResult> {
        let result = match operation.action {
            Action::Move { .. } => OpResult::Arrived,
            Action::Grip { action } => OpResult::Gripped {
                closed: action == GripAction::Close,
                open: action == GripAction::Open,
                part_present: action == GripAction::Close,
            },
            Action::Precheck { .. } => OpResult::Prechecked {
                failures: Vec::new(),
            },
        };
        Box::pin(std::future::ready(result))
    }

    fn reconcile(&self, operation: Operation) -> Later<OpResult> {
        self.operate(operation)
    }

    fn stop(&self) -> Later<()> {
        Box::pin(std::future::ready(()))
    }

    fn watch(&self) -> watch::Receiver<ArmSeen> {
        self.0.subscribe()
    }
}

struct World {
    work: CellHandle,
    /// What is seen of the arm.
    arm: watch::Sender<ArmSeen>,
    outboxes: Outboxes,
    seq: u64,
    state: MobileState,
}

fn opened(disk: &MemoryDisk) -> SharedJournal {
    opened_with(disk, Upkeep::default())
}

fn opened_with(disk: &MemoryDisk, upkeep: Upkeep) -> SharedJournal {
    let opening = Opening {
        at: Clocks {
            wall: jiff::Timestamp::now(),
            monotonic: Duration::ZERO,
        },
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    SharedJournal::durable_with(MemoryJournal::open(disk, &opening).unwrap(), upkeep)
}

fn book() -> Arc<SetupBook> {
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        robots: vec![RobotSection::new("r1", "fanuc-m20ia", "127.0.0.1:1")],
        setup: None,
        push_urls: BTreeMap::new(),
    };
    let mut plan = Plan::try_new(&ServerSection::default(), &[cell]).unwrap();
    let robots = plan.cells.remove(0).robots.into_iter().map(Arc::new);
    // The mobile robots of these tests are where they say at once, and drive at no speed.
    let setup = DEMO.replace("max_speed_mm_s = 2000\n", "");
    assert_ne!(setup, DEMO, "the demo's mobile robot has a speed");
    let source = SetupSource::Memory(setup);
    Arc::new(SetupBook::open(Some(&source), robots.collect()).unwrap())
}

impl World {
    /// On what a disk has.
    async fn on(disk: &MemoryDisk) -> Self {
        Self::on_journal(&opened(disk)).await
    }

    async fn on_journal(journal: &SharedJournal) -> Self {
        Self::at(journal, Arc::new(SystemClock)).await
    }

    async fn at(journal: &SharedJournal, wall: Arc<dyn WallClock>) -> Self {
        let seen = ArmSeen {
            arm: "r1".to_owned(),
            link: true,
            ready: true,
            still: true,
            manual: false,
            displaced: false,
            safety: Safety::Normal,
            zones: Vec::new(),
            part_present: None,
        };
        let seen = watch::Sender::new(seen);
        let arm: Arc<dyn ArmPort> = Arc::new(Willing(seen.clone()));
        let arms = BTreeMap::from([("r1".to_owned(), arm)]);
        let work = testing::handle_at(journal, arms, wall).await;
        let setup = book();
        let wanted = setup.current().setup.for_workflows();
        let _changed = work
            .ask(Input::SetupChanged(Box::new(wanted)))
            .await
            .unwrap();
        let _control = work
            .ask(Input::Control { jobs_may_act: true })
            .await
            .unwrap();
        let outboxes = Outboxes::new(work.clone(), setup);
        Self {
            work,
            arm: seen,
            outboxes,
            seq: 0,
            state: MobileState {
                pose: BasePose {
                    x_mm: 3000.0,
                    y_mm: -1500.0,
                    heading_deg: 0.0,
                },
                localized: true,
                battery_percent: 90.0,
                loads: Some(vec![SlotLoad {
                    slot: "left".to_owned(),
                    load: Some("load-1".to_owned()),
                }]),
                ..MobileState::default()
            },
        }
    }

    /// Takes load-2 from rack/a to the warehouse.
    async fn pickup(&self) -> Uuid {
        match self.ask_for_pickup().await {
            Ok(Reply::Created(id)) => id,
            other => panic!("{other:?}"),
        }
    }

    async fn ask_for_pickup(&self) -> Result<Reply, Refused> {
        let job: NewJob = serde_json::from_value(serde_json::json!({
            "workflow": "pickup-and-delivery", "point": "handover/front", "mobile_robot": "mr1",
            "items": [{"load_id": "load-2", "type": "crate", "mr_slot": "right", "place": "rack/a"}],
            "destination": "warehouse/gate", "complete_on": "DELIVERED",
        }))
        .unwrap();
        self.work.ask(Input::CreateJob { job: Box::new(job) }).await
    }

    fn signal(&mut self, kind: SignalKind, session: Option<Uuid>) -> Signal {
        self.seq += 1;
        Signal {
            mobile_robot: "mr1".to_owned(),
            session,
            boot: 1,
            seq: self.seq,
            kind,
            at_ms: None,
            resync: false,
            state: self.state.clone(),
        }
    }

    async fn send(&self, signal: Signal) -> SignalAnswer {
        match self.work.ask(Input::Signal(Box::new(signal))).await {
            Ok(Reply::Signal(answer)) => answer,
            other => panic!("{other:?}"),
        }
    }

    async fn says(&mut self, kind: SignalKind, session: Option<Uuid>) {
        let signal = self.signal(kind, session);
        let answer = self.send(signal).await;
        assert_eq!(
            answer,
            SignalAnswer::Accepted { duplicate: false },
            "{kind:?}"
        );
    }

    /// The first message of a kind in the outbox, once it is there.
    async fn message(&self, kind: &str) -> OutboxMessage {
        let mut news = self.outboxes.watch();
        let found = async {
            loop {
                news.mark_unchanged();
                let all = self.outboxes.after("mr1", 0);
                if let Some(found) = all.into_iter().find(|one| one.message.kind() == kind) {
                    return found;
                }
                news.changed().await.unwrap();
            }
        };
        let Ok(found) = tokio::time::timeout(LIMIT, found).await else {
            panic!("no {kind}; waiting: {:?}", self.outboxes.after("mr1", 0));
        };
        found
    }

    async fn taken(&self, n: u64) {
        self.outboxes.acknowledge("mr1", n).await.unwrap();
    }
}

fn order_of(message: &OutboxMessage) -> &api::TransportOrderBody {
    let MobileMessage::TransportOrder(order) = &message.message else {
        panic!("{:?}", message.message);
    };
    order
}
