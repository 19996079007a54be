//! Bodies by their moments of mass, and what of them a joint feels.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::dynamics::inertia::LinkInertia;

/// Mass, first moment and second moments of a body about the origin of its frame: the integrals of
/// 1, `r` and `r r^T` over its mass. Kilograms and meters.
///
/// They add up, and a point of the mass is like any other: the classical inertia is
/// `trace(S) E - S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) mass: f64,
    pub(crate) first: Vector3<f64>,
    pub(crate) second: Matrix3<f64>,
}

impl Body {
    pub(crate) fn nothing() -> Self {
        Self {
            mass: 0.0,
            first: Vector3::zeros(),
            second: Matrix3::zeros(),
        }
    }

    pub(crate) fn of(inertia: &LinkInertia) -> Self {
        let (mass, center) = (inertia.mass_kg(), inertia.center_of_mass_m());
        let about_center = inertia.inertia_kg_m2();
        let spread = Matrix3::from_diagonal_element(about_center.trace() / 2.0) - about_center;
        Self {
            mass,
            first: center * mass,
            second: spread + center * center.transpose() * mass,
        }
    }

    /// The same body in the frame in which its own is at `at`, in meters.
    pub(crate) fn seen_from(&self, at: &Isometry3<f64>) -> Self {
        let turn = at.rotation.to_rotation_matrix();
        let p = at.translation.vector;
        let first = turn * self.first;
        Self {
            mass: self.mass,
            first: first + p * self.mass,
            second: turn.matrix() * self.second * turn.matrix().transpose()
                + first * p.transpose()
                + p * first.transpose()
                + p * p.transpose() * self.mass,
        }
    }

    pub(crate) fn plus(&self, other: &Body) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// Splits off what could as well be on the Z axis: mass, and its moments along Z. Gives the
    /// rest and that.
    ///
    /// Where Z is the axis about which the body turns, masses on it are at rest in the link before:
    /// the motion of the joints does not tell whose they are, so the link before may have them, and
    /// the rest takes fewer terms. Gautier and Khalil (1990) call it regrouping.
    pub(crate) fn without_axis(&self) -> (Self, Self) {
        let on_axis = Self {
            mass: self.mass,
            first: Vector3::new(0.0, 0.0, self.first.z),
            second: Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, self.second.m33)),
        };
        let rest = Self {
            mass: 0.0,
            first: self.first - on_axis.first,
            second: self.second - on_axis.second,
        };
        (rest, on_axis)
    }
}
