//! Which role a route needs.

use std::fmt;

use api::Role;

/// What a route asks of its caller. Not a ladder: see [`Role`].
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Access {
    /// Nothing: whoever reaches the port.
    Open,
    /// Any valid token, whatever its role. Stopping is here: nobody who is known is kept from it.
    Anyone,
    /// To read.
    Viewer,
    /// To move robots and run jobs.
    Operator,
    /// To set cells up.
    Integrator,
    /// To manage tokens.
    Admin,
    /// To hold control, or to take it away: operators and admins.
    Control,
    /// To read who did what: integrators and admins.
    Auditor,
    /// To be one mobile robot: its own signals and outbox; an operator may do it in its place.
    MobileRobot,
}

impl Access {
    /// Whether a role is enough. Whose mobile robot it is, and which cell, is the scope's matter.
    pub(crate) fn allows(self, role: Role) -> bool {
        let moves = matches!(role, Role::Operator | Role::Integrator);
        match self {
            Self::Open | Self::Anyone => true,
            Self::Viewer => role != Role::MobileRobot,
            Self::Operator => moves,
            Self::Integrator => role == Role::Integrator,
            Self::Admin => role == Role::Admin,
            Self::Auditor => matches!(role, Role::Integrator | Role::Admin),
            Self::Control => moves || role == Role::Admin,
            Self::MobileRobot => moves || role == Role::MobileRobot,
        }
    }

    /// Who may, for a sentence.
    pub(crate) fn who(self) -> &'static str {
        match self {
            Self::Open => "anybody",
            Self::Anyone => "any valid token",
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Integrator => "integrator",
            Self::Admin => "admin",
            Self::Control => "operator or admin",
            Self::Auditor => "integrator or admin",
            Self::MobileRobot => "mobile_robot, for its own, or operator",
        }
    }
}

impl fmt::Display for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.who())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_integrator_manages_no_tokens_and_an_admin_moves_no_robot() {
        assert!(!Access::Admin.allows(Role::Integrator));
        assert!(!Access::Operator.allows(Role::Admin));
        assert!(Access::Operator.allows(Role::Integrator));
        assert!(!Access::Integrator.allows(Role::Operator));
        assert!(Access::Control.allows(Role::Admin));
    }

    #[test]
    fn a_mobile_robot_reads_nothing_and_everybody_may_stop() {
        for access in [
            Access::Viewer,
            Access::Operator,
            Access::Integrator,
            Access::Admin,
            Access::Control,
        ] {
            assert!(!access.allows(Role::MobileRobot), "{access}");
        }
        for role in Role::ALL {
            assert!(Access::Anyone.allows(role), "{role}");
        }
    }
}
