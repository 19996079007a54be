//! Questions about arm models and routes. No robot of a cell is concerned, and nothing moves.

use std::time::Duration;

use api::arms::{
    ArmCalibrationBody, ArmCalibrationResult, ArmDescription, ArmForwardBody, ArmForwardResult,
    ArmInverseBody, ArmInverseResult, ArmJacobianBody, ArmJacobianResult, ArmList, ArmRatesBody,
    ArmRatesResult, ArmTransferBody, ArmTransferResult, ArmVelocityMotionBody,
    ArmVelocityMotionResult, ReachBody, ReachResult,
};
use api::paths::{PlanRouteBody, PlanRouteResult};
use api::trajectory::{ToolPathBody, ToolPathResult, TrajectoryBody, TrajectoryResult};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::http::{Effect, Http};
use crate::{Client, ClientError};

/// What an answer may take that has to be searched for.
const SEARCH: Duration = Duration::from_mins(1);

/// The server's answers about arm models and routes. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Arms {
    http: Http,
}

impl Client {
    /// Questions about arm models and routes. Nothing is sent.
    #[must_use]
    pub fn arms(&self) -> Arms {
        Arms {
            http: self.http.clone(),
        }
    }
}

/// The questions that are a body sent to `…/arms/{model}/{name}`.
macro_rules! questions {
    ($($(#[$doc:meta])* $function:ident($body:ty) -> $answer:ty, $name:literal;)*) => {
        impl Arms {
            $(
                $(#[$doc])*
                ///
                /// # Errors
                /// A problem `not-found` for a model that the server does not know, `validation` that names the item,
                /// one that says why the arm cannot; else as all calls.
                pub async fn $function(
                    &self,
                    model: &str,
                    body: &$body,
                ) -> Result<$answer, ClientError> {
                    self.ask(&["api", "v1", "arms", model, $name], body).await
                }
            )*
        }
    };
}

questions! {
    /// Where the tool is.
    forward(ArmForwardBody) -> ArmForwardResult, "forward";
    /// Which joints reach a pose.
    inverse(ArmInverseBody) -> ArmInverseResult, "inverse";
    /// Jacobians, rank, what is lost.
    jacobian(ArmJacobianBody) -> ArmJacobianResult, "jacobian";
    /// Joint rates of a velocity of the tool.
    rates(ArmRatesBody) -> ArmRatesResult, "rates";
    /// A motion with a constant velocity.
    velocity_motion(ArmVelocityMotionBody) -> ArmVelocityMotionResult, "velocity-motion";
    /// A tool out of taught points.
    calibrate(ArmCalibrationBody) -> ArmCalibrationResult, "calibrate-tool";
    /// Which poses are reached.
    reach(ReachBody) -> ReachResult, "reachability";
    /// A way among obstacles.
    transfer(ArmTransferBody) -> ArmTransferResult, "transfers";
    /// Joints in time.
    trajectory(TrajectoryBody) -> TrajectoryResult, "trajectories";
    /// The tool along a path.
    tool_path(ToolPathBody) -> ToolPathResult, "tool-paths";
}

impl Arms {
    /// The models there are.
    ///
    /// # Errors
    /// As all calls.
    pub async fn models(&self) -> Result<ArmList, ClientError> {
        let path = ["api", "v1", "arms"];
        self.http.get(&path, Effect::Question).json().await
    }

    /// All that is known of a model.
    ///
    /// # Errors
    /// A problem `not-found`; else as all calls.
    pub async fn describe(&self, model: &str) -> Result<ArmDescription, ClientError> {
        let path = ["api", "v1", "arms", model];
        self.http.get(&path, Effect::Question).json().await
    }

    /// A route of a disc among polygons.
    ///
    /// # Errors
    /// A problem `validation` that names the item, one that says that there is no way; else as all calls.
    pub async fn plan_route(&self, body: &PlanRouteBody) -> Result<PlanRouteResult, ClientError> {
        self.ask(&["api", "v1", "routes", "plan"], body).await
    }

    async fn ask<T: DeserializeOwned>(
        &self,
        path: &[&str],
        body: &impl Serialize,
    ) -> Result<T, ClientError> {
        let limit = self.http.timeouts.question.max(SEARCH);
        self.http
            .post(path, Effect::LongQuestion(limit))
            .body(body)
            .json()
            .await
    }
}
