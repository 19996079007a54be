//! The operator's set-up of a cell: tools, zones, stations, places, taught poses, mobile robots, routes, loads.
//!
//! [`api::setup::SetupFile`] is what people write; `Setup` is what was checked. Everyone reads the revision that
//! [`SetupBook::current`] gives, or follows [`SetupBook::watch`]; every change goes through [`SetupBook::change`], which
//! checks the whole, asks whether running work is in the way, and keeps it durably before anyone sees it.
//!
//! ```text
//! C  cell frame: everything of the set-up     W  an arm's own world, at X_CW     F  its flange     T  tool, at X_FT
//! D  a dock, at its nominal pose X_CD         M  where a mobile robot was measured to be docked, X_CM
//!
//! X_CT (measured) = X_CM * X_CD^-1 * X_CT (taught)        X_WF = X_CW^-1 * X_CT * X_FT^-1
//! ```

mod body;
pub(crate) mod book;
mod build;
mod calibrate;
mod check;
mod document;
mod faults;
mod for_workflows;
pub(crate) mod geometry;
pub(crate) mod model;
pub(crate) mod path;
pub(crate) mod resolve;
mod resource;
mod store;
mod teach;
#[cfg(test)]
mod tests;
mod text;
pub(crate) mod trespass;
pub(crate) mod ways;

pub(crate) use book::{BasedOn, ChangeError, Edit, Kept, SetupBook};
pub(crate) use calibrate::{Calibration, CalibrationError, MAX_RESIDUAL_MM, four_point};
pub(crate) use document::{DocumentError, Form, parse_part, parse_setup, write_setup};
pub(crate) use faults::Faults;
pub use faults::SetupErrors;
pub(crate) use resource::{Part, Resource, find, put, remove};
pub use store::StoreError;
pub(crate) use teach::flange_of_body;
