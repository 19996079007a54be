//! The numbers of an ortho-parallel arm with a spherical wrist, out of its Denavit-Hartenberg
//! table.
//!
//! Axis 1 is at right angles to axis 2, axes 2 and 3 are parallel, axis 4 is at right angles to
//! axis 3, and axes 4, 5 and 6 meet in the wrist center. Most six-axis arms are built so. In the
//! plane of the arm, with `u` pointing away from the shoulder and `v` along the second axis of
//! frame 1, the wrist center is `a2 * e^(i q2) + forearm * e^(i (q2 + q3 + forearm_phase))`.

use crate::dh::DhLink;
use crate::joints::Axis;

/// A right angle may be off by this many radians and is then taken as exact.
const RIGHT_ANGLE: f64 = 1e-9;
/// An offset shorter than this, in millimeters, is taken as none.
const NO_LENGTH: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Geometry {
    /// Height of the shoulder, and its distance from axis 1.
    pub(crate) d1: f64,
    pub(crate) a1: f64,
    /// Upper arm.
    pub(crate) a2: f64,
    /// Offset of the arm's plane from axis 1, along axis 2.
    pub(crate) lateral: f64,
    /// From axis 3 to the wrist center, and its direction at q2 + q3 = 0 as cosine and sine.
    pub(crate) forearm: f64,
    pub(crate) forearm_cos: f64,
    pub(crate) forearm_sin: f64,
    /// From the wrist center to the flange.
    pub(crate) d6: f64,
    /// The longest distance of the wrist center from axis 1: what data sheets call the reach.
    pub(crate) reach: f64,
    /// Sines of the twists: each 1 or -1.
    pub(crate) s1: f64,
    pub(crate) s3: f64,
    pub(crate) s4: f64,
    pub(crate) s5: f64,
}

/// Why the closed form does not cover a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NotCovered {
    Twist { axis: Axis, wanted: &'static str },
    A { axis: Axis, wanted: &'static str },
    D { axis: Axis, wanted: &'static str },
}

impl Geometry {
    pub(crate) fn try_from_dh(links: &[DhLink; 6]) -> Result<Self, NotCovered> {
        let [l1, l2, l3, l4, l5, l6] = links;
        let s1 = right_angle(Axis::J1, l1)?;
        parallel(Axis::J2, l2)?;
        let s3 = right_angle(Axis::J3, l3)?;
        let s4 = right_angle(Axis::J4, l4)?;
        let s5 = right_angle(Axis::J5, l5)?;
        parallel(Axis::J6, l6)?;
        for (axis, length) in [(Axis::J4, l4.a), (Axis::J5, l5.a), (Axis::J6, l6.a)] {
            if length.0.abs() > NO_LENGTH {
                return Err(NotCovered::A {
                    axis,
                    wanted: "and it would have to be 0",
                });
            }
        }
        if l5.d.0.abs() > NO_LENGTH {
            return Err(NotCovered::D {
                axis: Axis::J5,
                wanted: "and it would have to be 0",
            });
        }
        let (a2, a3, d4) = (l2.a.0, l3.a.0, l4.d.0);
        if a2 <= NO_LENGTH {
            return Err(NotCovered::A {
                axis: Axis::J2,
                wanted: "and the upper arm would have to be longer than 0",
            });
        }
        let forearm = a3.hypot(d4);
        if forearm <= NO_LENGTH {
            return Err(NotCovered::D {
                axis: Axis::J4,
                wanted: "and the forearm would have to be longer than 0",
            });
        }
        let lateral = l2.d.0 + l3.d.0;
        Ok(Self {
            d1: l1.d.0,
            a1: l1.a.0,
            a2,
            lateral,
            forearm,
            forearm_cos: a3 / forearm,
            forearm_sin: -s3 * d4 / forearm,
            d6: l6.d.0,
            reach: (l1.a.0.abs() + a2 + forearm).hypot(lateral),
            s1,
            s3,
            s4,
            s5,
        })
    }
}

/// The sine of a twist of ±90 degrees.
fn right_angle(axis: Axis, link: &DhLink) -> Result<f64, NotCovered> {
    let (sine, cosine) = link.alpha.0.sin_cos();
    if cosine.abs() > RIGHT_ANGLE {
        return Err(NotCovered::Twist {
            axis,
            wanted: "and it would have to be 90 or -90",
        });
    }
    Ok(sine.signum())
}

fn parallel(axis: Axis, link: &DhLink) -> Result<(), NotCovered> {
    let (sine, cosine) = link.alpha.0.sin_cos();
    if sine.abs() > RIGHT_ANGLE || cosine < 0.0 {
        return Err(NotCovered::Twist {
            axis,
            wanted: "and it would have to be 0",
        });
    }
    Ok(())
}
