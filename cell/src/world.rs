//! Where the parts of a virtual cell are: what grippers find, and what mobile robots carry.
//!
//! The two emulators know nothing of each other. A gripper that closes asks here what is between its fingers; the
//! answer depends on where every part truly is: in a fixed place of the set-up, in a slot of a mobile robot that stands
//! where it stands, on the floor where it was dropped.
#![expect(
    non_snake_case,
    reason = "frames are part of a name: X_CT is the tool center point T in the cell frame C"
)]

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context as _, Result, anyhow};
use api::FloorPoseBody;
use api::setup::{PlaceKind, PoseFrame, SetupFile};
use karel_emulator::Workpieces;
use kinematics::{Pose, Xyzwpr};
use tokio::sync::mpsc;
use units::{Degrees, Millimeters};

/// A gripper finds what is this near its tool center point, and a part comes to lie where a place is this near.
const NEAR_MM: f64 = 25.0;
/// Changes of a mobile robot's slots that may be on their way.
const PENDING: usize = 64;

/// The parts of one virtual cell. Cheap to clone.
#[derive(Clone)]
pub struct World(Arc<Mutex<Inner>>);

struct Inner {
    /// By the name of the virtual controller.
    arms: BTreeMap<String, ArmFrames>,
    fixed: Vec<FixedSpot>,
    on_mobile: Vec<MobileSpot>,
    mobiles: BTreeMap<String, Mobile>,
    parts: BTreeMap<String, PartAt>,
}

/// From an arm's own world to the tip of its tool in the cell.
#[derive(Clone)]
struct ArmFrames {
    X_CW: Pose,
    X_FT: Pose,
}

struct FixedSpot {
    place: String,
    X_CT: Pose,
    kind: PlaceKind,
}

/// A slot of a mobile robot, where a gripper grips in it.
struct MobileSpot {
    slot: String,
    /// In the frame of the robot's middle.
    X_MT: Pose,
}

/// A mobile robot, as far as its slots are concerned.
struct Mobile {
    pose: FloorPoseBody,
    changes: mpsc::Sender<SlotChange>,
}

/// What happens to a slot of a mobile robot.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum SlotChange {
    /// A part was put into it.
    Put {
        /// The slot.
        slot: String,
        /// The part.
        part: String,
    },
    /// Its part was taken.
    Taken {
        /// The slot.
        slot: String,
    },
}

/// Where a part is.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum PartAt {
    /// In a fixed place.
    Place(String),
    /// In a slot of a mobile robot.
    Slot {
        /// The mobile robot.
        mobile_robot: String,
        /// Its slot.
        slot: String,
    },
    /// In the gripper of a virtual controller.
    Gripper(String),
    /// At a destination, out of the cell.
    Away(String),
    /// Dropped, at millimeters in the cell frame.
    Floor([i64; 3]),
}

impl World {
    /// The world of a set-up at its beginning. `controllers` says which virtual controller moves which arm.
    ///
    /// # Errors
    /// A pose of the set-up that is none.
    pub fn try_new(setup: &SetupFile, controllers: &BTreeMap<String, String>) -> Result<Self> {
        let mut arms = BTreeMap::new();
        for arm in &setup.arms {
            let tool = setup
                .tools
                .iter()
                .find(|tool| tool.arm == arm.id && tool.number == arm.tool);
            let frames = ArmFrames {
                X_CW: pose(&arm.base).with_context(|| format!("arms.{}.base", arm.id))?,
                X_FT: match tool {
                    Some(tool) => {
                        pose(&tool.frame).with_context(|| format!("tools.{}.frame", tool.number))?
                    }
                    None => Pose::identity(),
                },
            };
            let controller = controllers.get(&arm.id).cloned();
            let _earlier = arms.insert(controller.unwrap_or_else(|| arm.id.clone()), frames);
        }
        let mut inner = Inner {
            arms,
            fixed: Vec::new(),
            on_mobile: Vec::new(),
            mobiles: BTreeMap::new(),
            parts: BTreeMap::new(),
        };
        inner.take_spots(setup, controllers)?;
        inner.take_parts(setup);
        Ok(Self(Arc::new(Mutex::new(inner))))
    }

    /// Lets a mobile robot take part; what happens to its slots comes out of the receiver.
    #[must_use]
    pub fn add_mobile_robot(&self, id: &str, pose: FloorPoseBody) -> mpsc::Receiver<SlotChange> {
        let (changes, happened) = mpsc::channel(PENDING);
        let mobile = Mobile { pose, changes };
        let _earlier = self.lock().mobiles.insert(id.to_owned(), mobile);
        happened
    }

    /// Where a mobile robot truly is now.
    pub fn mobile_robot_at(&self, id: &str, pose: FloorPoseBody) {
        if let Some(mobile) = self.lock().mobiles.get_mut(id) {
            mobile.pose = pose;
        }
    }

    /// What a mobile robot truly carries now, of what this world did not put there itself: it was loaded or unloaded
    /// somewhere else.
    pub fn mobile_robot_carries(&self, id: &str, slots: &BTreeMap<String, Option<String>>) {
        let mut inner = self.lock();
        for (slot, load) in slots {
            let at = PartAt::Slot {
                mobile_robot: id.to_owned(),
                slot: slot.clone(),
            };
            match load {
                Some(load) => {
                    let known = inner.parts.get(load);
                    if !matches!(known, Some(PartAt::Gripper(_) | PartAt::Place(_))) {
                        let _before = inner.parts.insert(load.clone(), at);
                    }
                }
                None => {
                    for place in inner.parts.values_mut().filter(|place| **place == at) {
                        *place = PartAt::Away(id.to_owned());
                    }
                }
            }
        }
    }

    /// Where every part is.
    #[must_use]
    pub fn parts(&self) -> BTreeMap<String, PartAt> {
        self.lock().parts.clone()
    }

    /// Puts a part somewhere by hand, as a person in the cell would.
    pub fn move_part(&self, part: &str, to: PartAt) {
        let _before = self.lock().parts.insert(part.to_owned(), to);
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // Each change is one assignment: a panic while the lock is held leaves no half of one.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn take_spots(
        &mut self,
        setup: &SetupFile,
        controllers: &BTreeMap<String, String>,
    ) -> Result<()> {
        for taught in &setup.taught_poses {
            let key = || format!("taught_poses.{}.{}", taught.arm, taught.place);
            let at = pose(&taught.pose).with_context(key)?;
            let controller = controllers.get(&taught.arm).unwrap_or(&taught.arm);
            let X_CT = match taught.frame {
                PoseFrame::Cell => at,
                PoseFrame::Arm => match self.arms.get(controller) {
                    Some(frames) => frames.X_CW * at,
                    None => at,
                },
            };
            let Some(place) = setup.places.iter().find(|place| place.id == taught.place) else {
                continue;
            };
            match place.kind {
                PlaceKind::OnMobileRobot => {
                    let (Some(point), Some(slot)) = (&place.point, &place.slot) else {
                        continue;
                    };
                    let dock = dock_of(setup, point)
                        .ok_or_else(|| anyhow!("{}: no point `{point}`", key()))?;
                    self.on_mobile.push(MobileSpot {
                        slot: slot.clone(),
                        X_MT: floor_pose(&dock)?.inverse() * X_CT,
                    });
                }
                PlaceKind::Fixed | PlaceKind::Reject | PlaceKind::Buffer => {
                    self.fixed.push(FixedSpot {
                        place: place.id.clone(),
                        X_CT,
                        kind: place.kind,
                    });
                }
            }
        }
        Ok(())
    }

    fn take_parts(&mut self, setup: &SetupFile) {
        for load in &setup.loads {
            let at = match (&load.place, &load.on, &load.destination) {
                (Some(place), _, _) => PartAt::Place(place.clone()),
                (None, Some(on), _) => PartAt::Slot {
                    mobile_robot: on.mobile_robot.clone(),
                    slot: on.slot.clone(),
                },
                (None, None, Some(destination)) => PartAt::Away(destination.clone()),
                (None, None, None) => continue,
            };
            let _none = self.parts.insert(load.id.clone(), at);
        }
    }

    /// The tip of a controller's tool in the cell.
    fn tip(&self, controller: &str, X_WF: &Pose) -> Option<Pose> {
        let frames = self.arms.get(controller)?;
        Some(frames.X_CW * *X_WF * frames.X_FT)
    }

    /// Every place there is now, with the place a part would have in it.
    fn spots(&self) -> Vec<(PartAt, Pose, PlaceKind)> {
        let fixed = self.fixed.iter().map(|spot| {
            let at = PartAt::Place(spot.place.clone());
            (at, spot.X_CT, spot.kind)
        });
        let on_mobile = self.mobiles.iter().flat_map(|(id, mobile)| {
            self.on_mobile.iter().filter_map(move |spot| {
                let at = PartAt::Slot {
                    mobile_robot: id.clone(),
                    slot: spot.slot.clone(),
                };
                let X_CM = floor_pose(&mobile.pose).ok()?;
                Some((at, X_CM * spot.X_MT, PlaceKind::OnMobileRobot))
            })
        });
        fixed.chain(on_mobile).collect()
    }

    /// The nearest of `spots` that `fits`, if one is near.
    fn nearest(
        &self,
        tip: &Pose,
        fits: impl Fn(&PartAt, PlaceKind) -> bool,
    ) -> Option<(PartAt, f64)> {
        self.spots()
            .into_iter()
            .filter(|(at, _, kind)| fits(at, *kind))
            .map(|(at, X_CT, _)| (at, tip.distance_to(&X_CT).0.0))
            .filter(|(_, distance)| *distance <= NEAR_MM)
            .min_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn part_at(&self, wanted: &PartAt) -> Option<String> {
        let mut parts = self.parts.iter();
        parts
            .find(|(_, at)| *at == wanted)
            .map(|(part, _)| part.clone())
    }

    fn tell(&self, at: &PartAt, change: impl FnOnce(String) -> SlotChange) {
        let PartAt::Slot { mobile_robot, slot } = at else {
            return;
        };
        if let Some(mobile) = self.mobiles.get(mobile_robot)
            && mobile.changes.try_send(change(slot.clone())).is_err()
        {
            tracing::warn!(
                mobile_robot.id = mobile_robot,
                slot,
                "a mobile robot was not told what happened to its slot"
            );
        }
    }
}

impl Workpieces for World {
    fn close_at(&self, controller: &str, tcp: &Pose) -> Option<String> {
        let mut inner = self.lock();
        let tip = inner.tip(controller, tcp)?;
        let (at, _) = inner.nearest(&tip, |at, _| inner.part_at(at).is_some())?;
        let part = inner.part_at(&at)?;
        inner.tell(&at, |slot| SlotChange::Taken { slot });
        let _before = inner
            .parts
            .insert(part.clone(), PartAt::Gripper(controller.to_owned()));
        Some(part)
    }

    fn open_at(&self, controller: &str, part: &str, tcp: &Pose) {
        let mut inner = self.lock();
        let Some(tip) = inner.tip(controller, tcp) else {
            return;
        };
        let free = |at: &PartAt, kind: PlaceKind| {
            // A bin takes any number.
            matches!(kind, PlaceKind::Reject) || inner.part_at(at).is_none()
        };
        let at = match inner.nearest(&tip, free) {
            Some((at, _)) => at,
            None => PartAt::Floor(floor(&tip)),
        };
        inner.tell(&at, |slot| SlotChange::Put {
            slot,
            part: part.to_owned(),
        });
        let _before = inner.parts.insert(part.to_owned(), at);
    }
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("parts", &self.parts())
            .finish_non_exhaustive()
    }
}

fn floor(tip: &Pose) -> [i64; 3] {
    let point = tip.xyzwpr();
    #[expect(
        clippy::cast_possible_truncation,
        reason = "an arm's reach in millimeters fits many times"
    )]
    [point.x, point.y, point.z].map(|length| length.0.round() as i64)
}

fn dock_of(setup: &SetupFile, point: &str) -> Option<FloorPoseBody> {
    let (station, point) = point.split_once('/')?;
    let station = setup.stations.iter().find(|known| known.id == station)?;
    let point = station.points.iter().find(|known| known.id == point)?;
    Some(FloorPoseBody {
        x_mm: point.dock.x_mm,
        y_mm: point.dock.y_mm,
        heading_deg: point.dock.heading_deg,
    })
}

fn floor_pose(at: &FloorPoseBody) -> Result<Pose> {
    let zero = Degrees(0.0);
    Ok(Pose::try_from_xyzwpr(&Xyzwpr {
        x: Millimeters(at.x_mm),
        y: Millimeters(at.y_mm),
        z: Millimeters(0.0),
        w: zero,
        p: zero,
        r: Degrees(at.heading_deg),
    })?)
}

fn pose(body: &api::PoseBody) -> Result<Pose> {
    Ok(Pose::try_from_xyzwpr(&Xyzwpr {
        x: Millimeters(body.x_mm),
        y: Millimeters(body.y_mm),
        z: Millimeters(body.z_mm),
        w: Degrees(body.w_deg),
        p: Degrees(body.p_deg),
        r: Degrees(body.r_deg),
    })?)
}
