//! Questions to a human: what is known, what is not, and what each answer would do.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::custody::Location;
use crate::faults::Fault;
use crate::input::Role;

/// What a human may answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// Do the same again.
    Retry,
    /// Go on where it was left, after the positions were read.
    Resume,
    /// Cancel the job and undo what can be undone.
    Cancel,
    /// Abort the job.
    Abort,
    /// Call this mobile robot instead.
    ChooseMobileRobot,
    /// Call it again with a new order.
    Redispatch,
    /// Work at the measured dock pose although it is out of tolerance.
    AcceptMeasured,
    /// Look at the loads again.
    Rescan,
    /// Take what is there.
    Accept,
    /// Send the mobile robot away with what it has.
    SendBack,
    /// Drive the arm out, then ask again.
    Retreat,
    /// Plan the same operation again from where the arm is.
    Replan,
    /// The operation did happen: a human looked.
    Happened,
    /// The operation did not happen: a human looked.
    DidNotHappen,
    /// Use this place.
    ChooseSlot,
    /// Put the load into the reject slot.
    RejectBin,
    /// Put the load back where it came from.
    PutBack,
    /// Carry the load to where it was going, then stop.
    Complete,
    /// Look again later.
    Wait,
    /// A human moved the mobile robot out of the zone.
    OperatorMoved,
    /// Take the order back.
    CancelOrder,
    /// The loads are now on another mobile robot.
    SwapMobileRobot,
    /// The loads have arrived.
    MarkDelivered,
    /// Pick the loads up again and put them back.
    Repick,
    /// Stay held.
    Hold,
    /// The load is there.
    SetCustody,
    /// The arm stands still: a human looked.
    ConfirmStill,
}

impl Answer {
    /// Who may give it.
    #[must_use]
    pub const fn needs(self) -> Role {
        if matches!(self, Self::AcceptMeasured) {
            Role::Integrator
        } else {
            Role::Operator
        }
    }

    /// What it would do.
    #[must_use]
    pub const fn consequence(self) -> &'static str {
        match self {
            Self::Retry => "The same is tried again.",
            Self::Resume => {
                "The job goes on from its last safe phase; the arm plans from where it is."
            }
            Self::Cancel => "The job is stopped and what can be undone is undone.",
            Self::Abort => "The arm stays where it is; the job is aborted and has to be cleared.",
            Self::ChooseMobileRobot => "The named mobile robot is called instead.",
            Self::Redispatch => "The mobile robot gets a new order to the same point.",
            Self::AcceptMeasured => {
                "The arm works at the measured dock pose, outside the tolerance."
            }
            Self::Rescan => "The loads are compared with the next report.",
            Self::Accept => "The job goes on as if the check had passed; the reason is kept.",
            Self::SendBack => "The mobile robot is sent away with its loads; the job stops.",
            Self::Retreat => "The arm drives out to its safe pose; then the question comes again.",
            Self::Replan => {
                "The operation is planned again from where the arm is, and carried out."
            }
            Self::Happened => "The operation counts as done; nothing is sent.",
            Self::DidNotHappen => "The operation counts as not done and is carried out again.",
            Self::ChooseSlot => "The load is placed at the named place.",
            Self::RejectBin => "The load is placed into the reject slot.",
            Self::PutBack => "The load is put back where it came from.",
            Self::Complete => "The load is placed where it was going; then the job stops.",
            Self::Wait => "The place is looked at again.",
            Self::OperatorMoved => "The zone counts as free; the session is closed.",
            Self::CancelOrder => {
                "The order is taken back; the point stays occupied until it is clear."
            }
            Self::SwapMobileRobot => "Custody of the loads moves to the named mobile robot.",
            Self::MarkDelivered => "Custody of the loads moves to the destination.",
            Self::Repick => "The arm takes the loads from the mobile robot and puts them back.",
            Self::Hold => "Nothing moves; the job stays as it is.",
            Self::SetCustody => "The load counts as being at the named place.",
            Self::ConfirmStill => "The arm counts as standing still.",
        }
    }
}

/// What an answer needs besides its name.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "detail", rename_all = "snake_case")]
pub enum Detail {
    /// Nothing.
    #[default]
    None,
    /// A mobile robot.
    MobileRobot {
        /// Its id.
        mobile_robot: String,
    },
    /// A fixed place.
    Place {
        /// Its id.
        place: String,
    },
    /// Where a load is. Two fields have to agree.
    Custody {
        /// The load.
        load: String,
        /// The load again.
        confirm: String,
        /// Where it is.
        location: Location,
    },
}

/// An answer that may be given.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Allowed {
    /// The answer.
    pub answer: Answer,
    /// What it would do.
    pub consequence: &'static str,
    /// Who may give it.
    pub role: Role,
}

/// A question, as it was asked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {
    /// Its id.
    pub id: Uuid,
    /// The job.
    pub job: Option<Uuid>,
    /// The session.
    pub session: Option<Uuid>,
    /// The operation in doubt.
    pub op: Option<Uuid>,
    /// The load in doubt.
    pub load: Option<String>,
    /// The fault behind it.
    pub fault: Fault,
    /// In one sentence.
    pub question: String,
    /// What is known.
    pub known: Vec<String>,
    /// What is not.
    pub unknown: Vec<String>,
    /// Answers that may be given.
    pub answers: Vec<Answer>,
}

/// The one decision.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decided {
    /// The answer.
    pub answer: Answer,
    /// What it needed besides.
    pub detail: Detail,
    /// Who.
    pub principal: String,
    /// Why.
    pub reason: String,
}

/// A question and what became of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Intervention {
    pub number: u64,
    pub question: Question,
    pub decided: Option<Decided>,
    /// It is not asked any more: the cause went away.
    pub withdrawn: Option<String>,
    pub reminders: u32,
}

impl Intervention {
    pub(crate) const fn is_open(&self) -> bool {
        self.decided.is_none() && self.withdrawn.is_none()
    }
}
