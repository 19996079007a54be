//! User frame and tool frame.

use crate::pose::Pose;

/// Where the user frame and the tool are: what `$UFRAME` and `$UTOOL` hold on the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// `X_WU`, the user frame in the world.
    pub user_frame: Pose,
    /// `X_FT`, the tool on the flange.
    pub tool: Pose,
}

impl Default for Frames {
    fn default() -> Self {
        Self {
            user_frame: Pose::identity(),
            tool: Pose::identity(),
        }
    }
}

impl Frames {
    /// `X_UT`, the tool in the user frame, of `X_WF`, the flange in the world.
    #[must_use]
    pub fn tcp_in_user_frame(&self, X_WF: &Pose) -> Pose {
        self.user_frame.inverse() * *X_WF * self.tool
    }

    /// `X_WF`, the flange in the world, of `X_UT`, the tool in the user frame.
    #[must_use]
    pub fn flange_in_world(&self, X_UT: &Pose) -> Pose {
        self.user_frame * *X_UT * self.tool.inverse()
    }
}
