//! Inverse dynamics: the torques and forces of the joints for a motion, by the recursive
//! Newton-Euler algorithm.
//!
//! Luh, Walker and Paul, "On-line computational scheme for mechanical manipulators" (1980);
//! Featherstone, Rigid Body Dynamics Algorithms (2008), table 5.1. Velocities and accelerations go
//! from the base to the flange, forces and moments back, each in the frame of its own joint.
//!
//! A model file may say of each joint's link what it weighs (`mass_kg`, `center_of_mass_m`,
//! `inertia_kg_m2`, in the link's frame of the table); [`crate::serial::SerialArm::with_inertias`]
//! takes the numbers from elsewhere. [`InverseDynamics`] is made of an arm whose links all have
//! them, the gravity and a payload. Friction, motors and gears, springs and the balance of a
//! counterweight are not in it.
//!
//! ```
//! use kinematics::dynamics::{InverseDynamics, Load};
//! use kinematics::serial::SerialArm;
//!
//! let arm = SerialArm::builtin("five-link").ok_or("no such arm")?;
//! let dynamics = InverseDynamics::of(arm, &Load::default())?;
//! let still = arm.state(&arm.joints(&[0.0; 5])?, &[0.0; 5], &[0.0; 5])?;
//! // It hangs straight down: nothing has to be held.
//! assert!(dynamics.torques(&still)?.iter().all(|torque| torque.abs() < 1e-9));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body;
mod inertia;
mod inverse;
mod recursion;
mod state;

pub use inertia::{InertiaError, LinkInertia};
pub use inverse::{DynamicsError, InverseDynamics, Load, STANDARD_GRAVITY};
pub use state::JointState;
