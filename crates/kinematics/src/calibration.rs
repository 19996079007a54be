//! Tool calibration: the R and p behind A6 in the thesis, out of taught points.
//!
//! Three points: the tool's tip stands at one place in the world in several orientations, so
//! `R_i p + t_i` is the same for all, and p follows from the differences by least squares. Six
//! points: with the same tip, an orient origin and a point in each of the tool's X and Z
//! directions.

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};
use units::{Degrees, Millimeters};

use crate::pose::Pose;

/// Orientations closer together than this leave p undetermined: the smallest singular value of the
/// system, as a part of the largest.
const LEAST_SPREAD: f64 = 0.05;
/// Direction points nearer than this to the orient origin are no direction.
const LEAST_WAY: Millimeters = Millimeters(10.0);
/// The flange may turn by this much between the direction points.
const MOST_TURN: Degrees = Degrees(0.5);
/// X and Z must be at least this far from parallel, and are taken as at right angles.
const LEAST_ANGLE: Degrees = Degrees(10.0);
/// More points than this nobody teaches.
const MOST_POINTS: usize = 1000;

/// Where the tool's tip is on the flange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipCalibration {
    /// `p_FT`, in millimeters.
    pub tip: Vector3<f64>,
    /// The place in the world at which the tip stood, in millimeters.
    pub place: Vector3<f64>,
    /// How far the farthest of the points is from it.
    pub worst: Millimeters,
    /// The mean square root of these distances.
    pub mean: Millimeters,
}

/// Why there is no tool.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Three points at least.
    #[error("{given} points were given; it must be 3 to 1000")]
    PointCount {
        /// How many.
        given: usize,
    },
    /// The orientations are too alike.
    #[error(
        "the orientations are too alike: their spread is {spread:.4}, it must be at least {least}"
    )]
    TooAlike {
        /// The smallest singular value as a part of the largest.
        spread: f64,
        /// The least.
        least: f64,
    },
    /// A direction point too near to the orient origin.
    #[error("the {point} point is {way:.3} from the orient origin; it must be at least {least}")]
    TooNear {
        /// `X` or `Z`.
        point: &'static str,
        /// How far it is.
        way: Millimeters,
        /// The least.
        least: Millimeters,
    },
    /// The flange was turned on the way to a direction point.
    #[error("the flange is turned by {turned:.3} at the {point} point; it may be {most}")]
    Turned {
        /// `X` or `Z`.
        point: &'static str,
        /// By how much.
        turned: Degrees,
        /// The most.
        most: Degrees,
    },
    /// X and Z point the same way.
    #[error("X and Z are {angle:.3} from one line; it must be at least {least}")]
    Parallel {
        /// How far.
        angle: Degrees,
        /// The least.
        least: Degrees,
    },
}

/// The tip out of three or more flange poses `X_WF` with the tip at one place.
///
/// Least squares over all pairs with the first; `worst` says how well the points agree, which is
/// the operator's to judge.
///
/// # Errors
/// Too few points, or orientations that are too alike.
pub fn calibrate_tip(flanges: &[Pose]) -> Result<TipCalibration, CalibrationError> {
    let given = flanges.len();
    let (Some(first), 3..=MOST_POINTS) = (flanges.first(), given) else {
        return Err(CalibrationError::PointCount { given });
    };
    // (R_i - R_mean) p = t_mean - t_i, for all points.
    let count = u32::try_from(given).map_or(f64::MAX, f64::from);
    let mean_r = flanges
        .iter()
        .fold(Matrix3::zeros(), |sum, x| sum + x.rotation_matrix())
        / count;
    let from = first.isometry().translation.vector;
    let mean_t = flanges.iter().fold(Vector3::zeros(), |sum, x| {
        sum + (x.isometry().translation.vector - from)
    }) / count;
    let mut system = DMatrix::zeros(3 * given, 3);
    let mut right = DVector::zeros(3 * given);
    for (i, flange) in flanges.iter().enumerate() {
        let rotation = flange.rotation_matrix() - mean_r;
        let way = mean_t - (flange.isometry().translation.vector - from);
        system.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&rotation);
        right.fixed_rows_mut::<3>(3 * i).copy_from(&way);
    }
    let svd = system.svd(true, true);
    let values = &svd.singular_values;
    // Turned apart as far as can be, the three singular values are of the size of sqrt(points).
    let spread = values.min() / count.sqrt();
    let tip = svd.solve(&right, 0.0).ok();
    let (Some(tip), true) = (tip, spread >= LEAST_SPREAD) else {
        return Err(CalibrationError::TooAlike {
            spread,
            least: LEAST_SPREAD,
        });
    };
    let tip = Vector3::from_iterator(tip.iter().copied());
    let place = mean_r * tip + mean_t + from;
    let off = flanges
        .iter()
        .map(|x| (x.rotation_matrix() * tip + x.isometry().translation.vector - place).norm());
    let (worst, squares) = off.fold((0.0_f64, 0.0), |(worst, squares), off| {
        (worst.max(off), squares + off * off)
    });
    Ok(TipCalibration {
        tip,
        place,
        worst: Millimeters(worst),
        mean: Millimeters((squares / count).sqrt()),
    })
}

/// `X_FT` by the six-point method: three or more flange poses with the tip at one place, then, with
/// the flange's rotation kept, an orient origin, a point along the tool's X and one along its Z.
///
/// Z is taken as it is, X is brought to a right angle with it.
///
/// # Errors
/// As [`calibrate_tip`]; the direction points are too near, turned, or in one line.
pub fn calibrate_tool(
    tips: &[Pose],
    orient_origin: &Pose,
    along_x: &Pose,
    along_z: &Pose,
) -> Result<(Pose, TipCalibration), CalibrationError> {
    let tip = calibrate_tip(tips)?;
    let direction = |point: &'static str, to: &Pose| {
        let (way, turned) = orient_origin.distance_to(to);
        if way < LEAST_WAY {
            let least = LEAST_WAY;
            return Err(CalibrationError::TooNear { point, way, least });
        }
        let turned = Degrees::from(turned);
        if turned > MOST_TURN {
            return Err(CalibrationError::Turned {
                point,
                turned,
                most: MOST_TURN,
            });
        }
        let (to, from) = (to.isometry(), orient_origin.isometry());
        let way = to.translation.vector - from.translation.vector;
        Ok((from.rotation.inverse() * way).normalize())
    };
    let (x, z) = (direction("X", along_x)?, direction("Z", along_z)?);
    let across = z.cross(&x);
    let angle = Degrees(across.norm().atan2(z.dot(&x).abs()).to_degrees());
    if angle < LEAST_ANGLE {
        return Err(CalibrationError::Parallel {
            angle,
            least: LEAST_ANGLE,
        });
    }
    let y = across.normalize();
    let rotation = Matrix3::from_columns(&[y.cross(&z), y, z]);
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(rotation);
    let tool = Pose::from_parts(tip.tip, UnitQuaternion::from_rotation_matrix(&rotation));
    Ok((tool, tip))
}
