//! From one place of a path to the next, in smaller steps where the joints are far apart.

/// How often a step is halved before it is a jump.
const MOST_HALVINGS: u32 = 10;

/// An arm on a path.
pub(super) trait OnPath {
    /// Its joints.
    type Joints: Clone;
    /// Why it cannot be there.
    type Error;

    /// The joints at `parameter`, those nearest to `near`.
    fn joints_at(&self, parameter: f64, near: &Self::Joints) -> Result<Self::Joints, Self::Error>;

    /// Are they too far apart for one step?
    fn far_apart(&self, a: &Self::Joints, b: &Self::Joints) -> bool;

    /// Of joints that are far apart however small the step is.
    fn jump(&self, parameter: f64, from: &Self::Joints, to: &Self::Joints) -> Self::Error;
}

/// The joints at `parameter`, a `step` after `before`; the step is halved while they are far apart.
pub(super) fn after<A: OnPath>(
    arm: &A,
    parameter: f64,
    step: f64,
    before: &A::Joints,
) -> Result<A::Joints, A::Error> {
    halved(arm, parameter, step, before, 0)
}

fn halved<A: OnPath>(
    arm: &A,
    parameter: f64,
    step: f64,
    before: &A::Joints,
    count: u32,
) -> Result<A::Joints, A::Error> {
    let joints = arm.joints_at(parameter, before)?;
    if !arm.far_apart(before, &joints) {
        return Ok(joints);
    }
    if count == MOST_HALVINGS {
        return Err(arm.jump(parameter, before, &joints));
    }
    let half = 0.5 * step;
    let middle = halved(arm, parameter - half, half, before, count + 1)?;
    halved(arm, parameter, half, &middle, count + 1)
}
