use api::arms::{
    ArmCalibrationBody, ArmCalibrationResult, ArmDescription, ArmForwardBody, ArmForwardResult,
    ArmInverseBody, ArmInverseDynamicsBody, ArmInverseDynamicsResult, ArmInverseResult,
    ArmJacobianBody, ArmJacobianResult, ArmList, ArmRatesBody, ArmRatesResult, ArmTransferBody,
    ArmTransferResult, ArmVelocityMotionBody, ArmVelocityMotionResult, ReachBody, ReachResult,
};
use api::paths::{CellRouteBody, PlanRouteBody, PlanRouteResult};
use api::trajectory::{ToolPathBody, ToolPathResult, TrajectoryBody, TrajectoryResult};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::ClientError;
use crate::http::{Effect, Http};

/// Questions about arm models and paths. Nothing moves, and no robot of a cell is concerned. Cheap to clone.
///
/// What is wrong with a question comes back as a problem: `validation` with the item, its value and its limit,
/// `not-found` for a model that is not known, `out-of-workspace`, `joint-limit-exceeded`, `singularity`, `no-way`.
#[derive(Clone, Debug)]
pub struct Arms {
    http: Http,
}

impl Arms {
    pub(crate) fn new(http: Http) -> Self {
        Self { http }
    }

    /// The models that are known.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn list(&self) -> Result<ArmList, ClientError> {
        let path = ["api", "v1", "arms"];
        self.http.get(&path, Effect::Question).json().await
    }

    /// All that is known of a model.
    ///
    /// # Errors
    /// A problem `not-found` if there is none of this name; else as all calls.
    pub async fn describe(&self, model: &str) -> Result<ArmDescription, ClientError> {
        let path = ["api", "v1", "arms", model];
        self.http.get(&path, Effect::Question).json().await
    }

    /// Where the tool is at given joints.
    ///
    /// # Errors
    /// As [`Arms::describe`]; a problem `validation` for an item that is none.
    pub async fn forward(
        &self,
        model: &str,
        body: &ArmForwardBody,
    ) -> Result<ArmForwardResult, ClientError> {
        self.ask(model, "forward", body).await
    }

    /// The joints that reach a pose.
    ///
    /// # Errors
    /// As [`Arms::forward`]; `out-of-workspace` if none do.
    pub async fn inverse(
        &self,
        model: &str,
        body: &ArmInverseBody,
    ) -> Result<ArmInverseResult, ClientError> {
        self.ask(model, "inverse", body).await
    }

    /// The Jacobians at given joints.
    ///
    /// # Errors
    /// As [`Arms::forward`].
    pub async fn jacobian(
        &self,
        model: &str,
        body: &ArmJacobianBody,
    ) -> Result<ArmJacobianResult, ClientError> {
        self.ask(model, "jacobian", body).await
    }

    /// The joint rates of a velocity of the tool.
    ///
    /// # Errors
    /// As [`Arms::forward`]; `singularity` if part of it cannot be made.
    pub async fn rates(
        &self,
        model: &str,
        body: &ArmRatesBody,
    ) -> Result<ArmRatesResult, ClientError> {
        self.ask(model, "rates", body).await
    }

    /// The joints' torques for a motion.
    ///
    /// # Errors
    /// As [`Arms::forward`]; `validation` of `links` for a model that does not say what its links weigh, if the question
    /// does not either.
    pub async fn inverse_dynamics(
        &self,
        model: &str,
        body: &ArmInverseDynamicsBody,
    ) -> Result<ArmInverseDynamicsResult, ClientError> {
        self.ask(model, "inverse-dynamics", body).await
    }

    /// The motion of the tool with a constant velocity.
    ///
    /// # Errors
    /// As [`Arms::forward`].
    pub async fn velocity_motion(
        &self,
        model: &str,
        body: &ArmVelocityMotionBody,
    ) -> Result<ArmVelocityMotionResult, ClientError> {
        self.ask(model, "velocity-motion", body).await
    }

    /// A tool out of taught points.
    ///
    /// # Errors
    /// As [`Arms::forward`].
    pub async fn calibrate_tool(
        &self,
        model: &str,
        body: &ArmCalibrationBody,
    ) -> Result<ArmCalibrationResult, ClientError> {
        self.ask(model, "calibrate-tool", body).await
    }

    /// Which of a set of poses are reached.
    ///
    /// # Errors
    /// As [`Arms::forward`].
    pub async fn reachability(
        &self,
        model: &str,
        body: &ReachBody,
    ) -> Result<ReachResult, ClientError> {
        self.ask(model, "reachability", body).await
    }

    /// The joints in time.
    ///
    /// # Errors
    /// As [`Arms::forward`]; `joint-limit-exceeded` for a state outside the limits.
    pub async fn trajectory(
        &self,
        model: &str,
        body: &TrajectoryBody,
    ) -> Result<TrajectoryResult, ClientError> {
        self.ask(model, "trajectories", body).await
    }

    /// The tool along a path, or where the arm cannot follow.
    ///
    /// # Errors
    /// As [`Arms::trajectory`].
    pub async fn tool_path(
        &self,
        model: &str,
        body: &ToolPathBody,
    ) -> Result<ToolPathResult, ClientError> {
        self.ask(model, "tool-paths", body).await
    }

    /// A way of the joints that touches nothing.
    ///
    /// # Errors
    /// As [`Arms::trajectory`]; `no-way` if none was found.
    pub async fn transfer(
        &self,
        model: &str,
        body: &ArmTransferBody,
    ) -> Result<ArmTransferResult, ClientError> {
        self.ask(model, "transfers", body).await
    }

    /// A path of a disc among polygons.
    ///
    /// # Errors
    /// A problem `validation` for an item that is none, `no-way` if there is none; else as all calls.
    pub async fn plan_route(&self, body: &PlanRouteBody) -> Result<PlanRouteResult, ClientError> {
        self.post(&["api", "v1", "routes", "plan"], body).await
    }

    /// A path of a mobile robot of a cell, around what its set-up has.
    ///
    /// # Errors
    /// As [`Arms::plan_route`]; `not-found` if there is no such cell or mobile robot.
    pub async fn plan_mobile_robot_route(
        &self,
        cell: &str,
        mobile_robot: &str,
        body: &CellRouteBody,
    ) -> Result<PlanRouteResult, ClientError> {
        let path = [
            "api",
            "v1",
            "cells",
            cell,
            "mobile-robots",
            mobile_robot,
            "routes",
            "plan",
        ];
        self.post(&path, body).await
    }

    async fn ask<T: DeserializeOwned>(
        &self,
        model: &str,
        what: &str,
        body: &(impl Serialize + Sync),
    ) -> Result<T, ClientError> {
        self.post(&["api", "v1", "arms", model, what], body).await
    }

    async fn post<T: DeserializeOwned>(
        &self,
        path: &[&str],
        body: &(impl Serialize + Sync),
    ) -> Result<T, ClientError> {
        // They move nothing, but one that computes for long waits for another.
        let effect = Effect::LongQuestion(self.http.timeouts.command);
        self.http.post(path, effect).body(body).json().await
    }
}
