//! What a process that simulates is told: a configuration and a set-up like any other's, and the job.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context as _, Result};
use api::{JobBody, Tier};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use server::config::RobotSection;
use server::{Scene, SceneArm};

/// The simulation of one job.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Task {
    /// The private cell's configuration, TOML.
    pub(crate) config: String,
    /// Its set-up, TOML, with the loads where they are.
    pub(crate) setup: String,
    pub(crate) cell: String,
    /// The general override of each virtual controller that does not have 100 %.
    pub(crate) overrides: Vec<(String, u8)>,
    /// How many mobile robots there are.
    pub(crate) mobile_robots: usize,
    pub(crate) job: JobBody,
    /// What time it is when it begins.
    pub(crate) now: Timestamp,
    pub(crate) assumptions: Vec<String>,
    pub(crate) limits: Limits,
}

/// How fast and how far a simulation may go.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct Limits {
    pub(crate) wall: Duration,
    pub(crate) simulated: Duration,
    /// How much the process steps back behind others.
    pub(crate) nice: i32,
}

impl Task {
    /// A private cell for a scene. `drive` says how a mobile robot drives, where the configuration does.
    pub(crate) fn of(
        scene: &Scene,
        robots: &[RobotSection],
        drive: impl Fn(&str) -> Option<PathBuf>,
        limits: Limits,
    ) -> Result<Self> {
        let mut overrides = Vec::new();
        let (mut sections, mut controllers) = (Vec::new(), Vec::new());
        for robot in robots {
            let arm = scene.arms.iter().find(|arm| arm.id == robot.id);
            sections.push(robot_section(robot));
            controllers.push(controller_section(scene, robot, arm));
            if let Some(percent) = arm.and_then(|arm| arm.speed_override) {
                overrides.push((robot.id.clone(), percent));
            }
        }
        let mobile_robots: Vec<_> = scene
            .setup
            .mobile_robots
            .iter()
            .map(|robot| {
                let mut section = json!({"cell": scene.cell, "id": robot.id});
                if let Some(config) = drive(&robot.id) {
                    set(&mut section, "config", json!(config));
                }
                let mut standing = scene.mobile_robots.iter();
                if let Some(standing) = standing.find(|standing| standing.id == robot.id) {
                    set(&mut section, "start", json!(standing.pose));
                }
                section
            })
            .collect();
        let count = mobile_robots.len();
        let mut server = json!({"demo": true, "listen": "127.0.0.1:0"});
        if let Some(first) = robots.first() {
            let legacy = format!("{}/{}", scene.cell, first.id);
            set(&mut server, "legacy_robot", json!(legacy));
        }
        let config = json!({
            "server": server,
            "cells": [{"id": scene.cell, "robots": sections}],
            "virtual_controllers": controllers,
            "virtual_mobile_robots": mobile_robots,
        });
        Ok(Self {
            config: toml::to_string(&config).context("writing the private configuration")?,
            setup: toml::to_string(&scene.setup).context("writing the private set-up")?,
            cell: scene.cell.clone(),
            overrides,
            mobile_robots: count,
            job: scene.job.clone(),
            now: scene.now,
            assumptions: scene.assumptions.clone(),
            limits,
        })
    }
}

/// The robot with a virtual controller. The frames of that controller are the identity, and so are those it is
/// commanded in: the server plans in joints and the cell's frames, so the arm goes to the same joint values.
fn robot_section(robot: &RobotSection) -> Value {
    json!({
        "id": robot.id,
        "model": robot.model,
        "controller": format!("virtual:{}", robot.id),
        "tier": robot.tier,
        "configuration": robot.configuration,
        "max_speed_mm_s": robot.max_speed_mm_s,
        "position_tolerance_mm": robot.position_tolerance_mm,
        "rotation_tolerance_deg": robot.rotation_tolerance_deg,
    })
}

/// A virtual controller of the same model, with this project's programs of the same tier.
fn controller_section(scene: &Scene, robot: &RobotSection, arm: Option<&SceneArm>) -> Value {
    let mut section = json!({"name": robot.id, "model": robot.model});
    match robot.tier {
        Tier::CellServer => set(&mut section, "runs", json!("cell_server")),
        // Its port is a fixed number, and others may have it.
        Tier::Seed | Tier::SeedStatus => set(&mut section, "ports", json!({"59002": 0})),
    }
    let safe = scene.setup.arms.iter().find(|known| known.id == robot.id);
    let safe = safe.map(|known| {
        let at = &known.safe;
        [
            at.j1_deg, at.j2_deg, at.j3_deg, at.j4_deg, at.j5_deg, at.j6_deg,
        ]
    });
    if let Some(joints) = arm.and_then(|arm| arm.joints_deg).or(safe) {
        set(&mut section, "start_joints_deg", json!(joints));
    }
    section
}

fn set(object: &mut Value, key: &str, value: Value) {
    if let Some(object) = object.as_object_mut() {
        let _before = object.insert(key.to_owned(), value);
    }
}
