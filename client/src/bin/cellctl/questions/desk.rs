//! Who answers: this program, or a server that is named.

use api::arms::{
    ArmCalibrationBody, ArmCalibrationResult, ArmDescription, ArmForwardBody, ArmForwardResult,
    ArmFrames, ArmInverseBody, ArmInverseDynamicsBody, ArmInverseDynamicsResult, ArmInverseResult,
    ArmJacobianBody, ArmJacobianResult, ArmList, ArmRatesBody, ArmRatesResult, ArmTransferBody,
    ArmTransferResult, ArmVelocityMotionBody, ArmVelocityMotionResult, ReachBody, ReachResult,
};
use api::paths::{PlanRouteBody, PlanRouteResult};
use api::trajectory::{ToolPathBody, ToolPathResult, TrajectoryBody, TrajectoryResult};
use client::Arms;

use crate::context::Context;
use crate::failure::Failure;

/// Who answers.
#[derive(Debug)]
pub(super) enum Desk {
    Here,
    Server(Box<Arms>),
}

macro_rules! questions {
    ($($name:ident($body:ty) -> $answer:ty, $asked:ident;)*) => {
        impl Desk {
            $(
                pub(super) async fn $name(
                    &self,
                    model: &str,
                    body: &$body,
                ) -> Result<$answer, Failure> {
                    Ok(match self {
                        Self::Here => robotics::$name(model, body)?,
                        Self::Server(arms) => arms.$asked(model, body).await?,
                    })
                }
            )*
        }
    };
}

questions! {
    forward(ArmForwardBody) -> ArmForwardResult, forward;
    inverse(ArmInverseBody) -> ArmInverseResult, inverse;
    jacobian(ArmJacobianBody) -> ArmJacobianResult, jacobian;
    rates(ArmRatesBody) -> ArmRatesResult, rates;
    velocity_motion(ArmVelocityMotionBody) -> ArmVelocityMotionResult, velocity_motion;
    inverse_dynamics(ArmInverseDynamicsBody) -> ArmInverseDynamicsResult, inverse_dynamics;
    calibrate(ArmCalibrationBody) -> ArmCalibrationResult, calibrate_tool;
    reach(ReachBody) -> ReachResult, reachability;
    transfer(ArmTransferBody) -> ArmTransferResult, transfer;
    trajectory(TrajectoryBody) -> TrajectoryResult, trajectory;
    tool_path(ToolPathBody) -> ToolPathResult, tool_path;
}

impl Desk {
    pub(super) fn of(context: &Context) -> Self {
        if context.names_a_server() {
            Self::Server(Box::new(context.client.arms()))
        } else {
            Self::Here
        }
    }

    pub(super) async fn models(&self) -> Result<ArmList, Failure> {
        Ok(match self {
            Self::Here => robotics::models(),
            Self::Server(arms) => arms.list().await?,
        })
    }

    pub(super) async fn describe(&self, model: &str) -> Result<ArmDescription, Failure> {
        Ok(match self {
            Self::Here => robotics::describe(model)?,
            Self::Server(arms) => arms.describe(model).await?,
        })
    }

    pub(super) async fn plan_route(
        &self,
        body: &PlanRouteBody,
    ) -> Result<PlanRouteResult, Failure> {
        Ok(match self {
            Self::Here => robotics::plan_route(body)?,
            Self::Server(arms) => arms.plan_route(body).await?,
        })
    }

    /// The arm at given joints: what a drawing needs.
    pub(super) async fn at(
        &self,
        model: &str,
        joints: &[f64],
        frames: &ArmFrames,
    ) -> Result<ArmForwardResult, Failure> {
        let body = ArmForwardBody {
            joints_deg_mm: joints.to_vec(),
            frames: frames.clone(),
        };
        self.forward(model, &body).await
    }
}
