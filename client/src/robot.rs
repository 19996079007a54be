use std::time::Duration;

use api::arms::{ArmJacobianBody, ArmJacobianResult, ReachBody, ReachResult};
use api::{
    ForwardBody, ForwardResult, InverseBody, InverseResult, Motion, MotionBody, MotionList,
    MotionPreview, RobotDescription, RobotState, SpeedOverride, StopBody, StopResult,
};
use serde::Serialize;
use uuid::Uuid;

use crate::ClientError;
use crate::http::{Effect, Exchange, Http};

/// What the server's own work may add to a motion's deadline before its answer is here.
const DEADLINE_MARGIN: Duration = Duration::from_secs(5);
/// The header with the caller's own word for a request.
pub(crate) const KEY: &str = "idempotency-key";

/// One robot of one cell. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Robot {
    http: Http,
    cell: String,
    id: String,
}

/// How a motion is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ask {
    /// The caller's own word for the motion; a new one where `None`.
    pub key: Option<String>,
    /// How long to wait for the motion's end, in whole seconds; the server's own measure where `None`.
    pub wait: Option<Duration>,
}

impl Ask {
    pub(crate) fn key(&self) -> String {
        self.key
            .clone()
            .unwrap_or_else(|| Uuid::now_v7().to_string())
    }
}

/// Which part of a list is wanted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Page {
    /// At most this many; the server's own measure where `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<u32>,
    /// The `next_cursor` of the page before; `None` for the first page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cursor: Option<String>,
}

impl Robot {
    pub(crate) fn new(http: Http, cell: &str, id: &str) -> Self {
        Self {
            http,
            cell: cell.to_owned(),
            id: id.to_owned(),
        }
    }

    /// The cell's id.
    #[must_use]
    pub fn cell(&self) -> &str {
        &self.cell
    }

    /// The robot's id.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// What the robot is and what it can do.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell or robot; else as all calls.
    pub async fn describe(&self) -> Result<RobotDescription, ClientError> {
        self.get(&[]).json().await
    }

    /// What the server knows of the robot now.
    ///
    /// # Errors
    /// As [`Robot::describe`].
    pub async fn state(&self) -> Result<RobotState, ClientError> {
        self.get(&["state"]).json().await
    }

    /// The pose at given joint values.
    ///
    /// # Errors
    /// As [`Robot::describe`].
    pub async fn forward(&self, body: &ForwardBody) -> Result<ForwardResult, ClientError> {
        self.post(&["kinematics", "forward"], Effect::Question)
            .body(body)
            .json()
            .await
    }

    /// The Jacobians at the robot's tool, in its user frame.
    ///
    /// # Errors
    /// As [`Robot::describe`].
    pub async fn jacobian(&self, body: &ArmJacobianBody) -> Result<ArmJacobianResult, ClientError> {
        self.post(&["kinematics", "jacobian"], Effect::Question)
            .body(body)
            .json()
            .await
    }

    /// Which of a set of poses the robot reaches with its tool.
    ///
    /// # Errors
    /// A problem `validation` for too many poses; else as [`Robot::describe`].
    pub async fn reachability(&self, body: &ReachBody) -> Result<ReachResult, ClientError> {
        let effect = Effect::LongQuestion(self.http.timeouts.command);
        self.post(&["reachability"], effect).body(body).json().await
    }

    /// Every branch that reaches a pose.
    ///
    /// # Errors
    /// A problem `out-of-workspace` if no joint values reach it; else as [`Robot::describe`].
    pub async fn inverse(&self, body: &InverseBody) -> Result<InverseResult, ClientError> {
        self.post(&["kinematics", "inverse"], Effect::Question)
            .body(body)
            .json()
            .await
    }

    /// Sends one motion and waits for the controller's answer to it.
    ///
    /// The answer says that the controller took the command, not that the arm has arrived. The motion is sent at most
    /// once.
    ///
    /// # Errors
    /// A problem if the server or the controller says no. After [`ClientError::Timeout`] and
    /// [`ClientError::Interrupted`], and wherever [`ClientError::outcome`] is `Unknown`, the robot may have moved.
    pub async fn create_motion(&self, body: &MotionBody) -> Result<Motion, ClientError> {
        self.ask_for_motion(body, &Ask::default()).await
    }

    /// As [`Robot::create_motion`], with a key of the caller's and a time to wait for the motion's end.
    ///
    /// The same body with the same key is answered with what became of that motion; nothing is sent again.
    ///
    /// # Errors
    /// As [`Robot::create_motion`].
    pub async fn ask_for_motion(
        &self,
        body: &MotionBody,
        ask: &Ask,
    ) -> Result<Motion, ClientError> {
        let patience = match (ask.wait, body.deadline_ms) {
            (Some(wait), _) => Some(wait),
            (None, Some(deadline)) => Some(Duration::from_millis(deadline)),
            (None, None) => None,
        };
        let timeout = patience.map_or(self.http.timeouts.command, |patience| {
            patience.saturating_add(DEADLINE_MARGIN)
        });
        let exchange = self
            .post(&["motions"], Effect::Command(timeout))
            .header(KEY, &ask.key());
        let exchange = match ask.wait {
            Some(wait) => exchange.header("prefer", &format!("wait={}", wait.as_secs())),
            None => exchange,
        };
        exchange.body(body).json().await
    }

    /// What a motion would be; nothing is sent. Its `plan_id` makes a motion that is exactly this one.
    ///
    /// # Errors
    /// A problem if the body does not fit; else as [`Robot::describe`].
    pub async fn preview_motion(&self, body: &MotionBody) -> Result<MotionPreview, ClientError> {
        self.post(&["motions", "preview"], Effect::Question)
            .body(body)
            .json()
            .await
    }

    /// Takes a motion back.
    ///
    /// # Errors
    /// A problem `wrong-motion-state` if it came to another end; else as [`Robot::create_motion`].
    pub async fn cancel_motion(&self, id: Uuid) -> Result<Motion, ClientError> {
        self.command_on_motion(id, "cancel").await
    }

    /// Holds the running motion.
    ///
    /// # Errors
    /// A problem `wrong-motion-state` if it does not run; else as [`Robot::create_motion`].
    pub async fn pause_motion(&self, id: Uuid) -> Result<Motion, ClientError> {
        self.command_on_motion(id, "pause").await
    }

    /// Lets a motion on hold go on. It needs control of the cell.
    ///
    /// # Errors
    /// As [`Robot::pause_motion`].
    pub async fn resume_motion(&self, id: Uuid) -> Result<Motion, ClientError> {
        self.command_on_motion(id, "resume").await
    }

    async fn command_on_motion(&self, id: Uuid, what: &str) -> Result<Motion, ClientError> {
        let effect = Effect::Command(self.http.timeouts.command);
        self.post(&["motions", &id.to_string(), what], effect)
            .json()
            .await
    }

    /// Stops the robot. It is a functional stop; the answer says whether the arm stops or nothing more is sent.
    ///
    /// # Errors
    /// A problem `stop-unconfirmed` if the controller does not confirm it; else as [`Robot::create_motion`].
    pub async fn stop(&self, body: StopBody) -> Result<StopResult, ClientError> {
        let effect = Effect::Command(self.http.timeouts.command);
        self.post(&["stop"], effect).body(&body).json().await
    }

    /// The controller's general speed override.
    ///
    /// # Errors
    /// A problem `not-supported` if it does not report it; else as [`Robot::describe`].
    pub async fn speed_override(&self) -> Result<SpeedOverride, ClientError> {
        self.get(&["speed-override"]).json().await
    }

    /// Sets the controller's general speed override. It needs control of the cell.
    ///
    /// # Errors
    /// A problem `not-supported` if it cannot be told; else as [`Robot::create_motion`].
    pub async fn set_speed_override(
        &self,
        body: SpeedOverride,
    ) -> Result<SpeedOverride, ClientError> {
        let effect = Effect::Command(self.http.timeouts.command);
        self.http
            .put(&self.path(&["speed-override"]), effect)
            .body(&body)
            .json()
            .await
    }

    /// One motion and what became of it.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such motion; else as [`Robot::describe`].
    pub async fn motion(&self, id: Uuid) -> Result<Motion, ClientError> {
        self.get(&["motions", &id.to_string()]).json().await
    }

    /// A page of the robot's motions, newest first.
    ///
    /// # Errors
    /// As [`Robot::describe`].
    pub async fn motions(&self, page: &Page) -> Result<MotionList, ClientError> {
        self.get(&["motions"]).query(page).json().await
    }

    fn get(&self, rest: &[&str]) -> Exchange {
        self.http.get(&self.path(rest), Effect::Question)
    }

    fn post(&self, rest: &[&str], effect: Effect) -> Exchange {
        self.http.post(&self.path(rest), effect)
    }

    fn path<'a>(&'a self, rest: &[&'a str]) -> Vec<&'a str> {
        let mut path = vec!["api", "v1", "cells", &self.cell, "robots", &self.id];
        path.extend(rest);
        path
    }
}
