//! Between the edge's poses and the checked ones.

use api::{FloorAreaBody, FloorPoseBody};
use mobile_base::{Footprint, Obstacle, OutOfRange, PlanarPose, Point};
use units::{Degrees, Millimeters, Radians, shown};

/// A zone of the floor that needs a permit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Zone {
    pub(crate) area: FloorAreaBody,
    outline: Obstacle,
}

impl Zone {
    /// The zone of an area.
    ///
    /// # Errors
    /// A sentence about what is wrong with it.
    pub(crate) fn try_new(area: FloorAreaBody) -> Result<Self, String> {
        let FloorAreaBody {
            min_x_mm,
            min_y_mm,
            max_x_mm,
            max_y_mm,
        } = area;
        for (axis, min, max) in [("x", min_x_mm, max_x_mm), ("y", min_y_mm, max_y_mm)] {
            // A number that is none is not above another.
            let wide = max - min >= 1.0;
            if !wide {
                return Err(format!(
                    "max_{axis}_mm is {max}; it must be at least 1 mm above min_{axis}_mm, which is {min}"
                ));
            }
        }
        let corners = [
            (min_x_mm, min_y_mm),
            (max_x_mm, min_y_mm),
            (max_x_mm, max_y_mm),
            (min_x_mm, max_y_mm),
        ];
        let corners: Result<Vec<Point>, OutOfRange> = corners
            .into_iter()
            .map(|(x, y)| Point::try_new(Millimeters(x), Millimeters(y)))
            .collect();
        let outline = corners
            .and_then(Obstacle::polygon)
            .map_err(|error| error.to_string())?;
        Ok(Self { area, outline })
    }

    /// A square around a point.
    pub(crate) fn around(pose: &FloorPoseBody, half_mm: f64) -> Result<Self, String> {
        Self::try_new(FloorAreaBody {
            min_x_mm: pose.x_mm - half_mm,
            min_y_mm: pose.y_mm - half_mm,
            max_x_mm: pose.x_mm + half_mm,
            max_y_mm: pose.y_mm + half_mm,
        })
    }

    pub(crate) fn outline(&self) -> &Obstacle {
        &self.outline
    }

    /// How far a robot is from it; zero if it touches it.
    pub(crate) fn clearance(&self, footprint: &Footprint, pose: PlanarPose) -> Millimeters {
        footprint.clearance(pose, &self.outline)
    }
}

/// A checked pose.
pub(crate) fn pose_of(body: &FloorPoseBody) -> Result<PlanarPose, OutOfRange> {
    PlanarPose::try_new(
        Millimeters(body.x_mm),
        Millimeters(body.y_mm),
        Degrees(body.heading_deg).into(),
    )
}

/// A pose as the edge writes it, its numbers as people read them.
pub(crate) fn body_of(pose: PlanarPose) -> FloorPoseBody {
    FloorPoseBody {
        x_mm: shown(pose.position().x().0),
        y_mm: shown(pose.position().y().0),
        heading_deg: shown(Degrees::from(pose.heading()).0),
    }
}

/// A pose with something added to it in the world; the pose itself if that leads out of the world.
pub(crate) fn shifted(pose: PlanarPose, (x, y, heading): (f64, f64, f64)) -> PlanarPose {
    let turn: Radians = Degrees(heading).into();
    PlanarPose::try_new(
        pose.position().x() + Millimeters(x),
        pose.position().y() + Millimeters(y),
        pose.heading() + turn,
    )
    .unwrap_or(pose)
}

/// How far a pose is from another: millimeters, degrees.
pub(crate) fn off(pose: PlanarPose, wanted: PlanarPose) -> (f64, f64) {
    (
        pose.position().distance_to(wanted.position()).0,
        Degrees::from(pose.heading_error_to(wanted)).0.abs(),
    )
}

/// As far from `to` as `standoff`, on the side of `from`, looking as `to` does.
pub(crate) fn before(to: PlanarPose, from: PlanarPose, standoff: f64) -> PlanarPose {
    let distance = to.position().distance_to(from.position()).0;
    if distance <= standoff {
        // Nearer than that already: it docks from where it stands.
        return PlanarPose::at(from.position(), to.heading()).unwrap_or(to);
    }
    let share = standoff / distance;
    let x = (from.position().x().0 - to.position().x().0) * share;
    let y = (from.position().y().0 - to.position().y().0) * share;
    shifted(to, (x, y, 0.0))
}
