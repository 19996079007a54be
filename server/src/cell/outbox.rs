//! The outboxes of a cell's mobile robots, as they go over HTTP.
//!
//! The state machines say what to tell in as few words as they need; here it gets the poses, the zone and the ways of
//! the set-up, because a mobile robot has no other map of the cell.

use std::sync::Arc;

use api::{
    DockToleranceBody, FloorAreaBody, FloorPoseBody, MobileMessage, OutboxMessage, RoutePointBody,
    SlotLoadBody, TransportOrderBody,
};
use jiff::Timestamp;
use tokio::sync::watch;
use uuid::Uuid;
use workflow::{BasePose, Cell, Input, Message, OutMessage, SlotLoad};

use super::handle::{CellHandle, Refused};
use crate::setup::SetupBook;
use crate::setup::model::{LoadPoint, Setup};
use crate::wire_bodies::floor_pose;

/// The outboxes of one cell.
#[derive(Clone, Debug)]
pub(crate) struct Outboxes {
    work: CellHandle,
    setup: Arc<SetupBook>,
}

/// A transport order as the state machines know it.
struct Order {
    id: Uuid,
    update: u32,
    goal: String,
    dock: Option<BasePose>,
    route: Vec<BasePose>,
    then_to: Option<String>,
    unload: Option<Vec<SlotLoad>>,
}

impl Outboxes {
    pub(crate) fn new(work: CellHandle, setup: Arc<SetupBook>) -> Self {
        Self { work, setup }
    }

    /// The messages a mobile robot has not acknowledged, with numbers above `after`, oldest first.
    pub(crate) fn after(&self, robot: &str, after: u64) -> Vec<OutboxMessage> {
        let cell = self.work.view();
        let setup = self.setup.current();
        let told = &self.work.told;
        let waiting = cell.outbox(robot, after.saturating_sub(told.first()));
        waiting
            .into_iter()
            .filter_map(|out| {
                Some(OutboxMessage {
                    n: told.first() + out.n,
                    // Each was noted before anyone could see it.
                    at: told.at(robot, out.n).unwrap_or(Timestamp::UNIX_EPOCH),
                    session: out.session,
                    message: message(&setup.setup, &cell, robot, out)?,
                })
            })
            .collect()
    }

    /// Tells of every change to the cell, and so to its outboxes.
    pub(crate) fn watch(&self) -> watch::Receiver<Arc<Cell>> {
        self.work.watch()
    }

    /// Takes what a mobile robot has off its outbox: everything up to `n`.
    ///
    /// # Errors
    /// It could not be kept; the messages stay, and are acknowledged with the next ones.
    pub(crate) async fn acknowledge(&self, robot: &str, n: u64) -> Result<(), Refused> {
        let n = n.saturating_sub(self.work.told.first());
        let waiting = self.work.view().outbox(robot, 0);
        if waiting.first().is_none_or(|oldest| oldest.n > n) {
            return Ok(());
        }
        let taken = Input::OutboxTaken {
            mobile_robot: robot.to_owned(),
            n,
        };
        self.work.ask(taken).await.map(drop)
    }
}

fn message(setup: &Setup, cell: &Cell, robot: &str, out: OutMessage) -> Option<MobileMessage> {
    Some(match out.message {
        Message::TransportOrder {
            order,
            update,
            goal,
            dock,
            route,
            then_to,
            unload,
        } => {
            let order = Order {
                id: order,
                update,
                goal,
                dock,
                route,
                then_to,
                unload,
            };
            let order = order.in_one_piece(cell, out.session);
            MobileMessage::TransportOrder(Box::new(order.with_map(setup, cell, robot)?))
        }
        Message::MovePermit { granted } => MobileMessage::MovePermit { granted },
        Message::CellReady => MobileMessage::CellReady,
        Message::TransferDone => MobileMessage::TransferDone,
        Message::TransferFailed { reason: _ } => MobileMessage::TransferFailed,
        Message::ExitGranted => MobileMessage::ExitGranted,
        Message::CancelOrder { order } => MobileMessage::CancelOrder { order },
        Message::StartPause => MobileMessage::StartPause,
        Message::StopPause => MobileMessage::StopPause,
        Message::Retry => MobileMessage::Retry,
        Message::SkipRetry => MobileMessage::SkipRetry,
        Message::StateRequest => MobileMessage::StateRequest,
    })
}

impl Order {
    /// The update that releases the way to the destination, as an update of the order at the point: what is the base of
    /// an order does not change while it is carried out. Once the hand-over is over, only the way to the destination is
    /// left of it: a robot that has lost its order does not drive back to the point.
    fn in_one_piece(self, cell: &Cell, session: Option<Uuid>) -> Self {
        let of_session = session.and_then(|id| {
            let mut sessions = cell.sessions(0).into_iter();
            sessions.find(|session| session.id == id)
        });
        match of_session {
            Some(session)
                if session.order == Some(self.id)
                    && session.point != self.goal
                    && !session.state.is_closed() =>
            {
                Self {
                    then_to: Some(self.goal),
                    goal: session.point,
                    dock: None,
                    ..self
                }
            }
            Some(_) | None => self,
        }
    }

    fn with_map(self, setup: &Setup, cell: &Cell, robot: &str) -> Option<TransportOrderBody> {
        let point = setup.point(&self.goal);
        let Some(dock) = self.dock.map(floor_pose).or_else(|| point.map(dock_of)) else {
            tracing::warn!(
                mobile_robot.id = robot,
                goal = self.goal,
                "an order is not sent: the set-up does not say where its goal is"
            );
            return None;
        };
        let way = |from: &str, to: &str| setup.way(robot, from, to).map(places);
        let stands_at = || {
            let at = cell.mobile_robots().into_iter().find(|m| m.id == robot)?;
            at.state?.at_point.or_else(|| left_last(cell, robot))
        };
        let onward = self.then_to.as_deref();
        Some(TransportOrderBody {
            order: self.id,
            update: self.update,
            dock,
            dock_tolerance: point.map(|point| DockToleranceBody {
                mm: point.tolerance.position.0,
                deg: point.tolerance.angle.0,
            }),
            zone: point.and_then(|point| area_of(setup, point)),
            route: stands_at()
                .and_then(|from| way(&from, &self.goal))
                .unwrap_or_else(|| self.route.into_iter().map(route_point).collect()),
            then_pose: onward.and_then(|to| setup.point(to)).map(dock_of),
            then_route: onward
                .and_then(|to| way(&self.goal, to))
                .unwrap_or_default(),
            then_to: self.then_to,
            unload: self
                .unload
                .map(|loads| loads.into_iter().map(in_slot).collect()),
            goal: self.goal,
        })
    }
}

fn in_slot(one: SlotLoad) -> SlotLoadBody {
    SlotLoadBody {
        slot: one.slot,
        load: one.load,
    }
}

/// The point that a mobile robot at no point has left last: it stands before that one, where the routes of it begin.
fn left_last(cell: &Cell, robot: &str) -> Option<String> {
    let sessions = cell.sessions(0).into_iter().rev();
    let mut closed = sessions.filter(|session| session.state.is_closed());
    let last = closed.find(|session| session.mobile_robot == robot)?;
    Some(last.point)
}

fn area_of(setup: &Setup, point: &LoadPoint) -> Option<FloorAreaBody> {
    let id = point.zone.as_deref()?;
    let zone = setup.zones.iter().find(|zone| zone.id == id)?;
    let ([min_x_mm, min_y_mm], [max_x_mm, max_y_mm]) = zone.bounds.outline();
    Some(FloorAreaBody {
        min_x_mm,
        min_y_mm,
        max_x_mm,
        max_y_mm,
    })
}

fn dock_of(point: &LoadPoint) -> FloorPoseBody {
    FloorPoseBody {
        x_mm: point.dock.x.0,
        y_mm: point.dock.y.0,
        heading_deg: point.dock.heading.0,
    }
}

fn route_point(pose: BasePose) -> RoutePointBody {
    RoutePointBody {
        x_mm: pose.x_mm,
        y_mm: pose.y_mm,
        heading_deg: Some(pose.heading_deg),
    }
}

fn places(way: Vec<[units::Millimeters; 2]>) -> Vec<RoutePointBody> {
    way.into_iter()
        .map(|[x, y]| RoutePointBody {
            x_mm: x.0,
            y_mm: y.0,
            heading_deg: None,
        })
        .collect()
}
