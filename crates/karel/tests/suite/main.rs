//! KAREL programs against a scripted host.

mod golden;
mod host;
mod robustness;
mod semantics;
mod sock_server;
