//! What the cell sees of an arm, made of its controller's status lines.

use std::sync::Arc;
use std::time::Duration;

use protocol::v2::{OperatingMode, StatusLine};
use tokio::sync::watch;
use tokio::time::{Instant, timeout_at};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use workflow::{ArmSeen, Safety};

use super::displaced::Whereabouts;
use crate::link::cell_server::{CellServerLink, ControllerView};
use crate::setup::SetupBook;
use crate::state::Robot;

/// Even where nothing changes the cell is told this often, so that silence means something.
const AT_LEAST: Duration = Duration::from_secs(1);
/// The part sensor.
const PART_INPUT: u8 = 3;
/// FANUC's facility of servo alarms, in an alarm's number.
const SRVO: u32 = 11;

/// Publishes what is seen of an arm until `stop` is cancelled.
pub(crate) fn observe(
    robot: Arc<Robot>,
    link: &CellServerLink,
    setup: Arc<SetupBook>,
    principal: String,
    tracker: &TaskTracker,
    stop: CancellationToken,
) -> watch::Receiver<ArmSeen> {
    let mut views = link.watch();
    let time_scale = robot.plan.time_scale;
    let arm = robot.plan.id.clone();
    let mut whereabouts = Whereabouts::default();
    let mut look = move |view: &ControllerView| {
        let mut seen = seen(&arm, view, &setup);
        seen.displaced = match &view.status {
            Some(status) if seen.link => {
                whereabouts.is_displaced(status, &robot.motions.book, &principal)
            }
            Some(_) | None => false,
        };
        seen
    };
    let first = look(&views.borrow());
    let (publish, watch) = watch::channel(first);
    let at_least = AT_LEAST.div_f64(time_scale.max(0.01));
    drop(tracker.spawn(async move {
        let mut told = Instant::now();
        loop {
            let changed = timeout_at(told + at_least, views.changed());
            match stop.run_until_cancelled(changed).await {
                None | Some(Ok(Err(_))) => return,
                Some(Ok(Ok(())) | Err(_)) => {}
            }
            let now = look(&views.borrow_and_update());
            let due = told.elapsed() >= at_least;
            if due || *publish.borrow() != now {
                told = Instant::now();
                let _before = publish.send_replace(now);
            }
        }
    }));
    watch
}

fn seen(arm: &str, view: &ControllerView, setup: &SetupBook) -> ArmSeen {
    let line = view.status.as_ref().map(|seen| &seen.line);
    let link = view.is_connected() && line.is_some();
    let is_ours_alone = view.not_ready.is_none();
    ArmSeen {
        arm: arm.to_owned(),
        link,
        ready: link && is_ours_alone,
        still: link && line.is_some_and(|line| !line.moving),
        manual: link && line.is_some_and(|line| line.pendant || line.mode != OperatingMode::Auto),
        displaced: false,
        safety: line.filter(|_| link).map_or(Safety::Unknown, safety),
        zones: line.map_or_else(Vec::new, |line| {
            let joints = line.joints.degrees().map(|joint| joint.0);
            setup.current().setup.handover_zones_of(arm, joints)
        }),
        part_present: line.filter(|_| link).map(|line| line.input(PART_INPUT)),
    }
}

/// The safety state a controller reports.
pub(crate) fn safety(line: &StatusLine) -> Safety {
    match (line.alarm / 1_000, line.alarm % 1_000) {
        (0, 0) => Safety::Normal,
        // SRVO-001 to SRVO-003: emergency stop of the operator panel, the pendant, the deadman switch.
        (SRVO, 1..=3 | 7) => Safety::EmergencyStop,
        // SRVO-004 and SRVO-005: fence open, robot overtravel chain.
        (SRVO, 4 | 5) => Safety::ProtectiveStop,
        _ => Safety::Fault,
    }
}
