//! What stands around the arm.

use kinematics::Pose;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::{Cuboid, Cylinder, Segment, Shape};
use units::Millimeters;

use super::transfer::ArmError;

/// A solid in the world of the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// A box about the middle of its frame.
    Box {
        /// Of its middle, in the world.
        pose: Pose,
        /// Its full sizes along x, y and z.
        size: [Millimeters; 3],
    },
    /// A cylinder about the z axis of its frame, its middle at the frame's origin.
    Cylinder {
        /// Of its middle, in the world.
        pose: Pose,
        /// Of its round.
        radius: Millimeters,
        /// From end to end.
        height: Millimeters,
    },
    /// Where the arm must not be, with edges along the world's axes.
    KeepOut {
        /// The corner with the least coordinates.
        min: [Millimeters; 3],
        /// The corner with the greatest.
        max: [Millimeters; 3],
    },
}

/// Obstacles, ready to be measured.
#[derive(Clone)]
pub struct Scene {
    solids: Vec<Solid>,
}

#[derive(Clone)]
struct Solid {
    pose: ParryPose,
    shape: Round,
    /// Of a ball around it.
    middle: Point3<f64>,
    reach: f64,
}

#[derive(Clone)]
enum Round {
    Box(Cuboid),
    Cylinder(Cylinder),
}

const MAX_OBSTACLES: usize = 1000;
const MAX_MM: f64 = 1e5;

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene")
            .field("obstacles", &self.solids.len())
            .finish()
    }
}

impl Scene {
    /// A scene of obstacles.
    ///
    /// # Errors
    /// Names the obstacle and the size that is wrong.
    pub fn try_new(obstacles: &[Obstacle]) -> Result<Scene, ArmError> {
        if obstacles.len() > MAX_OBSTACLES {
            return Err(ArmError::Obstacles {
                count: obstacles.len(),
                most: MAX_OBSTACLES,
            });
        }
        let solids = (1..)
            .zip(obstacles)
            .map(|(index, obstacle)| solid(index, obstacle))
            .collect::<Result<_, _>>()?;
        Ok(Scene { solids })
    }

    /// The obstacle (counted from 1) that the capsule touches or comes nearer than `margin` to, and
    /// its distance, mm.
    pub(crate) fn touched(
        &self,
        (a, b, radius): (Point3<f64>, Point3<f64>, f64),
        margin: f64,
    ) -> Option<(usize, f64)> {
        let near = radius + margin;
        let segment = Segment::new(vector(&a.coords), vector(&b.coords));
        (1..).zip(&self.solids).find_map(|(index, solid)| {
            if distance_to_segment(&solid.middle, &a, &b) > solid.reach + near {
                return None;
            }
            let shape: &dyn Shape = match &solid.shape {
                Round::Box(shape) => shape,
                Round::Cylinder(shape) => shape,
            };
            // Two convex shapes are always supported; if not, it counts as touched.
            let distance = query::distance(&ParryPose::IDENTITY, &segment, &solid.pose, shape)
                .map_or(0.0, |found| found.distance);
            (distance < near).then_some((index, distance - radius))
        })
    }
}

fn solid(index: usize, obstacle: &Obstacle) -> Result<Solid, ArmError> {
    let size = |item: &'static str, value: f64| {
        if value > 0.0 && value <= MAX_MM {
            Ok(value)
        } else {
            Err(ArmError::Obstacle {
                obstacle: index,
                item,
                value,
            })
        }
    };
    match obstacle {
        Obstacle::Box {
            pose,
            size: [x, y, z],
        } => Ok(cuboid(
            *pose.isometry(),
            [
                size("size x", x.0)?,
                size("size y", y.0)?,
                size("size z", z.0)?,
            ],
        )),
        Obstacle::KeepOut { min, max } => {
            let [x0, y0, z0] = min.map(|value| value.0);
            let [x1, y1, z1] = max.map(|value| value.0);
            let sizes = [
                size("size x", x1 - x0)?,
                size("size y", y1 - y0)?,
                size("size z", z1 - z0)?,
            ];
            let middle = [x0 + x1, y0 + y1, z0 + z1].map(|sum| 0.5 * sum);
            for (item, value) in ["middle x", "middle y", "middle z"].into_iter().zip(middle) {
                if value.abs() > MAX_MM {
                    return Err(ArmError::Obstacle {
                        obstacle: index,
                        item,
                        value,
                    });
                }
            }
            let [x, y, z] = middle;
            Ok(cuboid(Isometry3::translation(x, y, z), sizes))
        }
        Obstacle::Cylinder {
            pose,
            radius,
            height,
        } => {
            let (radius, half) = (size("radius", radius.0)?, 0.5 * size("height", height.0)?);
            // parry's cylinders stand along y.
            let turn =
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
            Ok(Solid {
                pose: parry(&(pose.isometry() * turn)),
                shape: Round::Cylinder(Cylinder::new(half, radius)),
                middle: pose.isometry().translation.vector.into(),
                reach: radius.hypot(half),
            })
        }
    }
}

fn cuboid(pose: Isometry3<f64>, sizes: [f64; 3]) -> Solid {
    let half = Vector3::from(sizes) * 0.5;
    Solid {
        pose: parry(&pose),
        shape: Round::Box(Cuboid::new(vector(&half))),
        middle: pose.translation.vector.into(),
        reach: half.norm(),
    }
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn parry(pose: &Isometry3<f64>) -> ParryPose {
    let r = pose.rotation.coords;
    ParryPose::from_parts(
        vector(&pose.translation.vector),
        Rotation::from_xyzw(r.x, r.y, r.z, r.w),
    )
}

fn distance_to_segment(point: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let way = b - a;
    let square = way.norm_squared();
    let share = if square > 0.0 {
        ((point - a).dot(&way) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point - (a + way * share)).norm()
}
