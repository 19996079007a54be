//! A signal as it was sent, checked, and in the words of the state machines.

use api::{
    FloorPoseBody, MAX_MOBILE_ID, MAX_SIGNAL_ITEMS, MobileErrorLevel, OperatingMode, SignalBody,
    SignalData, SignalName,
};
use workflow::{BasePose, MobileError, MobileMode, MobileState, Signal, SignalKind, SlotLoad};

use crate::problem::Problem;
use crate::setup::Faults;
use crate::state::shown;

const REACH_MM: (f64, f64) = (-1e7, 1e7);
const TURNS_DEG: (f64, f64) = (-36_000.0, 36_000.0);
const PERCENT: (f64, f64) = (0.0, 100.0);
/// Two ids with a slash between.
const MAX_POINT: usize = 2 * MAX_MOBILE_ID + 1;
const MAX_DESCRIPTION: usize = 400;

/// Checks a signal's values, all of them, before anything is done with it.
pub(super) fn check(body: SignalBody, mobile_robot: &str) -> Result<Signal, Problem> {
    let mut faults = Faults::default();
    if body.seq == 0 {
        faults.add("seq", "is 0; the first signal of a boot has number 1");
    }
    if body.resync && body.signal != SignalName::MrHeartbeat {
        faults.add(
            "resync",
            format!(
                "comes with `{}`; only MR_HEARTBEAT may give numbers up",
                body.signal.as_str()
            ),
        );
    }
    check_data(&mut faults, &body.data);
    if let Some(errors) = faults.into_errors() {
        return Err(errors.into());
    }
    Ok(Signal {
        mobile_robot: mobile_robot.to_owned(),
        session: body.session,
        boot: body.boot,
        seq: body.seq,
        kind: kind(body.signal),
        at_ms: Some(body.at.as_millisecond()),
        resync: body.resync,
        state: state(body.data),
    })
}

fn check_data(faults: &mut Faults, data: &SignalData) {
    let FloorPoseBody {
        x_mm,
        y_mm,
        heading_deg,
    } = data.pose;
    for (item, value, range) in [
        ("data.pose.x_mm", x_mm, REACH_MM),
        ("data.pose.y_mm", y_mm, REACH_MM),
        ("data.pose.heading_deg", heading_deg, TURNS_DEG),
        ("data.battery_percent", data.battery_percent, PERCENT),
    ] {
        let _value = faults.number(item, value, range);
    }
    let loads = data.loads.as_deref().unwrap_or_default();
    faults.count("data.loads", loads.len(), MAX_SIGNAL_ITEMS);
    faults.count("data.errors", data.errors.len(), MAX_SIGNAL_ITEMS);
    for (index, one) in loads.iter().enumerate().take(MAX_SIGNAL_ITEMS) {
        let item = format!("data.loads[{index}]");
        text(faults, &format!("{item}.slot"), &one.slot, MAX_MOBILE_ID);
        if let Some(load) = &one.load {
            text(faults, &format!("{item}.load"), load, MAX_MOBILE_ID);
        }
        let earlier = loads.iter().take(index);
        if earlier.clone().any(|other| other.slot == one.slot) {
            faults.add(
                format!("{item}.slot"),
                format!("`{}` is told of twice", shown(&one.slot)),
            );
        }
    }
    for (index, one) in data.errors.iter().enumerate().take(MAX_SIGNAL_ITEMS) {
        let item = format!("data.errors[{index}]");
        text(
            faults,
            &format!("{item}.type"),
            &one.error_type,
            MAX_MOBILE_ID,
        );
        let length = one.description.len();
        if length > MAX_DESCRIPTION {
            faults.add(
                format!("{item}.description"),
                format!("has {length} bytes; at most {MAX_DESCRIPTION} are taken"),
            );
        }
    }
    if let Some(point) = &data.at_point {
        text(faults, "data.at_point", point, MAX_POINT);
    }
}

/// An id of 1 to `max` bytes without control characters. Whose id it is, the cell finds out.
fn text(faults: &mut Faults, item: &str, text: &str, max: usize) {
    if text.is_empty() || text.len() > max || text.chars().any(char::is_control) {
        let shown = shown(text);
        faults.add(
            item,
            format!("`{shown}` is no id: 1 to {max} bytes, none of them a control character"),
        );
    }
}

fn kind(name: SignalName) -> SignalKind {
    match name {
        SignalName::MrAssigned => SignalKind::MrAssigned,
        SignalName::MrArrived => SignalKind::MrArrived,
        SignalName::MrDocked => SignalKind::MrDocked,
        SignalName::MrReady => SignalKind::MrReady,
        SignalName::MrClear => SignalKind::MrClear,
        SignalName::MrDelivered => SignalKind::MrDelivered,
        SignalName::LoadChanged => SignalKind::LoadChanged,
        SignalName::MrHeartbeat => SignalKind::MrHeartbeat,
        SignalName::MrFault => SignalKind::MrFault,
        SignalName::MrMode => SignalKind::MrMode,
        SignalName::MrRejected => SignalKind::MrRejected,
        SignalName::MrDockFailed => SignalKind::MrDockFailed,
    }
}

fn state(data: SignalData) -> MobileState {
    // Absent: it has no sensors to say what lies in its slots. Empty: it is known to carry nothing.
    let occupied = data.loads.map(|loads| {
        let occupied = loads.into_iter().filter_map(|one| {
            let load = Some(one.load?);
            Some(SlotLoad {
                slot: one.slot,
                load,
            })
        });
        occupied.collect()
    });
    MobileState {
        pose: BasePose {
            x_mm: data.pose.x_mm,
            y_mm: data.pose.y_mm,
            heading_deg: data.pose.heading_deg,
        },
        driving: data.driving,
        localized: data.localized,
        battery_percent: data.battery_percent,
        mode: match data.mode {
            OperatingMode::Automatic => MobileMode::Automatic,
            OperatingMode::Semiautomatic => MobileMode::Semiautomatic,
            OperatingMode::Intervened => MobileMode::Intervened,
            OperatingMode::Manual => MobileMode::Manual,
            OperatingMode::Service => MobileMode::Service,
        },
        loads: occupied,
        order: data.order,
        at_point: data.at_point,
        errors: data
            .errors
            .into_iter()
            .map(|error| MobileError {
                fatal: error.level == MobileErrorLevel::Fatal,
                kind: error.error_type,
                description: error.description,
            })
            .collect(),
    }
}
