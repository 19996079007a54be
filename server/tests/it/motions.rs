//! motions
