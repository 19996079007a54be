//! What the emulators' HTTP views have in common: they are for the people and the tests at this machine.
//!
//! [`serve()`] bounds what a client can hold, [`Door`] keeps pages of other origins out, [`problem()`] words an error.
//!
//! ```
//! use axum::Router;
//! use axum::routing::get;
//! use local_view::Door;
//!
//! let router: Router = Door::local("panel").around(Router::new().route("/", get(|| async { "the arm" })));
//! ```

mod door;
mod problem;
mod serve;

pub use door::{Door, is_local_name};
pub use problem::problem;
pub use serve::serve;
