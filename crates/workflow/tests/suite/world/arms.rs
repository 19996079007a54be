//! The arms: what they are asked for, what they really do, and what they say of it.

use uuid::Uuid;
use workflow::{Action, GripAction, Location, OpResult, PlaceRef, PoseFailure, Target};

use super::{ArmTruth, POINT, World};

impl World {
    pub(super) fn operate(&mut self, op: Uuid, name: &str, action: Action) {
        self.log.push(format!("{:>7} {name} {action:?}", self.now));
        self.judge_motion(name, &action);
        let now = self.now;
        let arm = self.arms.get_mut(name).unwrap();
        assert!(arm.asked.insert(op), "operation {op} was sent twice");
        if std::mem::take(&mut arm.not_executed_next) || self.chance.hits(self.odds.not_executed) {
            let text = "refused, nothing was sent".to_owned();
            let _old = arm
                .done
                .insert(op, OpResult::NotExecuted { text: text.clone() });
            self.results
                .push((now + 20, op, OpResult::NotExecuted { text }));
            return;
        }
        match action {
            Action::Precheck { targets } => {
                let failures = targets
                    .iter()
                    .enumerate()
                    .filter(|(_, t)| {
                        t.place()
                            .is_some_and(|p| arm.blocked.contains(&p.to_string()))
                    })
                    .map(|(target, _)| PoseFailure {
                        target,
                        reason: "J5 at 126, limit 125".into(),
                    })
                    .collect();
                self.results
                    .push((now + 30, op, OpResult::Prechecked { failures }));
            }
            Action::Move {
                target,
                interpolation,
                speed,
                ..
            } => {
                assert!(
                    arm.moving.is_none(),
                    "two motions at once\n{}",
                    self.log.join("\n")
                );
                if std::mem::take(&mut arm.displaced) {
                    assert!(
                        matches!(target, Target::Safe)
                            && interpolation == workflow::Interpolation::Joint
                            && speed == workflow::Speed::Reduced,
                        "from where it was jogged the arm goes to its safe pose, not to {target:?} {interpolation:?}\n{}",
                        self.log.join("\n")
                    );
                }
                if std::mem::take(&mut arm.swallow_next) {
                    return;
                }
                if std::mem::take(&mut arm.alarm_next) || self.chance.hits(self.odds.motion_alarm) {
                    let result = OpResult::Rejected {
                        text: "MOTN-018".into(),
                    };
                    let _old = arm.done.insert(op, result.clone());
                    self.results.push((now + 60, op, result));
                    return;
                }
                arm.moving = Some((op, target, now + 800));
                if std::mem::take(&mut arm.doubt_next) || self.chance.hits(self.odds.motion_doubt) {
                    let text = "the answer was lost".to_owned();
                    self.results
                        .push((now + 300, op, OpResult::InDoubt { text }));
                }
            }
            Action::Grip { action } => {
                let result = self.grip(name, action);
                let arm = self.arms.get_mut(name).unwrap();
                let _old = arm.done.insert(op, result.clone());
                self.results.push((now + 200, op, result));
            }
        }
    }

    pub(super) fn place_of(&self, target: &Target) -> Option<Location> {
        Some(match target.place()? {
            PlaceRef::Fixed { place } => Location::Fixed {
                place: place.clone(),
            },
            PlaceRef::MobileRobot { slot, .. } => {
                let docked = self.mobiles.iter().find(|(_, m)| m.docked)?;
                Location::MobileRobot {
                    mobile_robot: docked.0.clone(),
                    slot: slot.clone(),
                }
            }
        })
    }

    pub(super) fn grip(&mut self, name: &str, action: GripAction) -> OpResult {
        let at = self.arms[name].at.clone();
        let here = match &at {
            Some(t @ Target::At { .. }) => self.place_of(t),
            _ => None,
        };
        let chance = self.chance.hits(self.odds.grip_fails);
        let arm = self.arms.get_mut(name).unwrap();
        match action {
            GripAction::Close => {
                let there = here.as_ref().and_then(|h| {
                    self.loads
                        .iter()
                        .find(|(_, at)| *at == h)
                        .map(|(id, _)| id.clone())
                });
                let fails = arm.grip_fails > 0 || chance;
                arm.grip_fails = arm.grip_fails.saturating_sub(1);
                if let (Some(load), false) = (there, fails) {
                    arm.holds = Some(load.clone());
                    let _old = self
                        .loads
                        .insert(load, Location::Gripper { arm: name.into() });
                }
                OpResult::Gripped {
                    closed: true,
                    open: false,
                    part_present: arm.holds.is_some(),
                }
            }
            GripAction::Open => {
                if arm.release_sticks {
                    return OpResult::Gripped {
                        closed: false,
                        open: true,
                        part_present: true,
                    };
                }
                if let Some(load) = arm.holds.take() {
                    let to = here.unwrap_or(Location::Unknown { arm: None });
                    assert!(
                        matches!(&to, Location::Fixed { place } if place == "bin")
                            || !self.loads.values().any(|at| *at == to)
                            || matches!(to, Location::Unknown { .. }),
                        "two loads at {to}"
                    );
                    let _old = self.loads.insert(load, to);
                }
                OpResult::Gripped {
                    closed: false,
                    open: true,
                    part_present: false,
                }
            }
        }
    }

    /// The rule of the shared zone, judged by what is really there.
    pub(super) fn judge_motion(&self, name: &str, action: &Action) {
        let Action::Move { target, .. } = action else {
            return;
        };
        if !target.enters_zone() {
            return;
        }
        let docked = self.mobiles.values().any(|m| m.docked);
        let driving = self
            .mobiles
            .values()
            .any(|m| m.state.driving && m.state.at_point.as_deref() == Some(POINT));
        assert!(
            self.rogue || docked && !driving,
            "{name} enters without a docked mobile robot\n{}",
            self.story()
        );
        let other = self
            .arms
            .iter()
            .any(|(id, a)| id != name && self.arm_inside(a));
        assert!(!other, "two arms in the zone");
    }

    #[allow(
        clippy::unused_self,
        reason = "reads like the other questions to the world"
    )]
    pub fn arm_inside(&self, arm: &ArmTruth) -> bool {
        let inside = |t: &Target| t.place().is_some_and(PlaceRef::in_zone);
        arm.at.as_ref().is_some_and(inside)
            || arm.moving.as_ref().is_some_and(|(_, t, _)| inside(t))
    }

    /// Stopped in between: it may be anywhere, so it is said to be inside if a mobile robot is there.
    pub(super) fn was_inside(&self, _arm: &ArmTruth) -> bool {
        self.mobiles.values().any(|m| m.docked)
    }
}
