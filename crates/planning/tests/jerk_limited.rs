//! Jerk-limited moves: numbers by hand, laws, and rsruckig over random states and limits.
#![allow(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    clippy::needless_range_loop,
    reason = "the helpers of tests, too, may fail loudly"
)]

use planning::State;
use planning::jerk::{JointMove, MotionLimits, MoveError, Quantity};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rsruckig::prelude::*;

const UNIT: MotionLimits = MotionLimits {
    velocity: 1.0,
    acceleration: 1.0,
    jerk: 1.0,
};

fn state(position: f64, velocity: f64, acceleration: f64) -> State {
    State {
        position,
        velocity,
        acceleration,
    }
}

fn shortest(start: State, goal: State, limits: MotionLimits) -> JointMove<1> {
    JointMove::try_new(&[start], &[goal], &[limits]).unwrap()
}

#[test]
fn durations_by_hand() {
    let from_rest =
        |way: f64, limits| shortest(State::at_rest(0.0), State::at_rest(way), limits).duration();
    // All phases: way / v + v / a + a / j = 6 + 1 + 1.
    assert!((from_rest(6.0, UNIT) - 8.0).abs() < 1e-12);
    assert!((from_rest(-6.0, UNIT) - 8.0).abs() < 1e-12);
    // Neither velocity nor acceleration reached: four equal phases of T/4, way = j T^3 / 32; for
    // way = 1/4 and j = 1, T = 2.
    assert!((from_rest(0.25, UNIT) - 2.0).abs() < 1e-12);
    // The acceleration 1 is held, the velocity 10 not reached: with j = 1 and the peak velocity
    // V = a T / 2 - a^2 / j = T / 2 - 1 the way is V T / 2; for T = 6, V = 2, way = 6.
    let fast = MotionLimits {
        velocity: 10.0,
        ..UNIT
    };
    assert!((from_rest(6.0, fast) - 6.0).abs() < 1e-12);
    // Nothing to do.
    assert!(from_rest(0.0, UNIT).abs() < 1e-12);
    // From the velocity 1 to rest in the least time: a^2 = v j, so a = 1, 2 s, way 1.
    let brake = shortest(state(0.0, 1.0, 0.0), State::at_rest(1.0), UNIT);
    assert!((brake.duration() - 2.0).abs() < 1e-9);
}

#[test]
fn a_goal_behind_a_moving_joint_needs_the_way_back() {
    // At the velocity 1 standstill needs 2 s and the way 1; then 1 back: j T^3 / 32 = 1, T = 32^(1/3)
    // = 3.1748 s, if the joint stopped on the way. It does not: acceleration is kept through the
    // turn, which is faster.
    let turn = shortest(state(0.0, 1.0, 0.0), State::at_rest(0.0), UNIT);
    assert!(turn.duration() < 2.0 + 32.0_f64.cbrt());
    assert!(turn.duration() > 3.0);
    let end = turn.at(turn.duration() - 1e-9)[0];
    assert!(end.position.abs() < 1e-9 && end.velocity.abs() < 1e-8);
}

#[test]
fn a_move_can_be_slower_but_not_by_any_amount() {
    // Past 1 at the velocity 1: there is no time to fall back by 0.1 and catch up. The next chance
    // is to go so slowly, T (1 - w / 2) = 1 with the drop w = T / 2 - 1 of the velocity, that T^2 -
    // 6 T + 4 = 0: T = 3 + sqrt 5.
    let (start, goal) = ([state(0.0, 1.0, 0.0)], [state(1.0, 1.0, 0.0)]);
    let shortest = JointMove::try_new(&start, &goal, &[UNIT]).unwrap();
    assert!((shortest.duration() - 1.0).abs() < 1e-12);
    for wanted in [0.9, 1.1, 5.2] {
        let refused = JointMove::try_lasting(&start, &goal, &[UNIT], wanted).unwrap_err();
        let by_hand = if wanted < 1.0 {
            1.0
        } else {
            3.0 + 5.0_f64.sqrt()
        };
        match refused {
            MoveError::Impossible {
                joint: 1,
                duration,
                next,
            } => assert!((duration - wanted).abs() < 1e-12 && (next - by_hand).abs() < 1e-9),
            other => panic!("{other}"),
        }
    }
    let slower = JointMove::try_lasting(&start, &goal, &[UNIT], 7.0).unwrap();
    keeps_its_promises(&slower, &start, &goal, &[UNIT]);
}

#[test]
fn bad_input_is_refused_by_name() {
    let rest = [State::at_rest(0.0); 2];
    let goal = [State::at_rest(1.0); 2];
    let refused = |start: State, limits: MotionLimits| {
        JointMove::try_new(&[rest[0], start], &goal, &[UNIT, limits]).unwrap_err()
    };
    assert_eq!(
        refused(state(0.0, 1.5, 0.0), UNIT),
        MoveError::OutsideLimits {
            joint: 2,
            end: "start",
            quantity: Quantity::Velocity,
            value: 1.5,
            limit: 1.0
        }
    );
    assert_eq!(
        refused(state(0.0, 0.8, 1.0), UNIT).to_string(),
        "joint 2, start: the velocity that its acceleration entails is 1.3, its limit is 1"
    );
    assert_eq!(
        refused(state(f64::NAN, 0.0, 0.0), UNIT).to_string(),
        "joint 2, start: the position is NaN; it must be a finite number"
    );
    let no_jerk = MotionLimits { jerk: 0.0, ..UNIT };
    assert_eq!(
        refused(State::at_rest(0.0), no_jerk).to_string(),
        "joint 2: the limit of the jerk is 0; it must be a number from 1e-9 to 1e9"
    );
    assert_eq!(
        JointMove::<0>::try_new(&[], &[], &[]).unwrap_err(),
        MoveError::NoJoints
    );
    for duration in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = JointMove::try_lasting(&rest, &goal, &[UNIT; 2], duration).unwrap_err();
        assert!(matches!(refused, MoveError::Duration { .. }), "{refused}");
    }
}

/// Random joints whose states the limits allow.
struct Cases(Pcg64Mcg);

impl Cases {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    fn limits(&mut self) -> MotionLimits {
        MotionLimits {
            velocity: self.between(0.3, 4.0),
            acceleration: self.between(0.3, 4.0),
            jerk: self.between(0.5, 15.0),
        }
    }

    /// `sense` 1 for a start, -1 for a goal.
    fn state(&mut self, limits: &MotionLimits, sense: f64) -> State {
        loop {
            let v = self.between(-1.0, 1.0) * limits.velocity;
            let a = self.between(-1.0, 1.0) * limits.acceleration;
            let entailed = v + sense * a * a.abs() / (2.0 * limits.jerk);
            if entailed.abs() < 0.999 * limits.velocity {
                return state(self.between(-3.0, 3.0), v, a);
            }
        }
    }

    fn joints<const N: usize>(&mut self) -> ([State; N], [State; N], [MotionLimits; N]) {
        let limits: [MotionLimits; N] = std::array::from_fn(|_| self.limits());
        let start = limits.map(|limits| self.state(&limits, 1.0));
        let goal = limits.map(|limits| self.state(&limits, -1.0));
        (start, goal, limits)
    }
}

fn keeps_its_promises<const N: usize>(
    plan: &JointMove<N>,
    start: &[State; N],
    goal: &[State; N],
    limits: &[MotionLimits; N],
) {
    let steps = 400;
    let duration = plan.duration();
    let mut before = *start;
    for step in 0..=steps {
        // Just before the end: at the end the goal itself is returned.
        let t = duration * (1.0 - 1e-12) * f64::from(step) / f64::from(steps);
        let now = plan.at(t);
        let dt = duration / f64::from(steps);
        for joint in 0..N {
            let (a, b, limit) = (before[joint], now[joint], limits[joint]);
            assert!(
                b.velocity.abs() <= limit.velocity * (1.0 + 1e-9),
                "{b:?} {limit:?}"
            );
            assert!(b.acceleration.abs() <= limit.acceleration * (1.0 + 1e-9));
            let change = (b.acceleration - a.acceleration).abs();
            assert!(
                change <= limit.jerk * dt * (1.0 + 1e-6) + 1e-9,
                "{change} in {dt}"
            );
            // Each is the integral of the next one.
            let way = b.position - a.position - 0.5 * dt * (a.velocity + b.velocity);
            assert!(step == 0 || way.abs() <= limit.jerk * dt.powi(3) / 3.0 + 1e-9);
        }
        before = now;
    }
    for (end, goal) in before.iter().zip(goal) {
        assert!(
            (end.position - goal.position).abs() < 1e-8,
            "{end:?} {goal:?}"
        );
        assert!(
            (end.velocity - goal.velocity).abs() < 1e-8,
            "{end:?} {goal:?}"
        );
        assert!((end.acceleration - goal.acceleration).abs() < 1e-7);
    }
}

fn theirs<const N: usize>(
    start: &[State; N],
    goal: &[State; N],
    limits: &[MotionLimits; N],
) -> Option<Trajectory<N>> {
    let mut otg = Ruckig::<N, ThrowErrorHandler>::new(None, 0.01);
    let mut input = InputParameter::<N>::new(None);
    for joint in 0..N {
        input.current_position[joint] = start[joint].position;
        input.current_velocity[joint] = start[joint].velocity;
        input.current_acceleration[joint] = start[joint].acceleration;
        input.target_position[joint] = goal[joint].position;
        input.target_velocity[joint] = goal[joint].velocity;
        input.target_acceleration[joint] = goal[joint].acceleration;
        input.max_velocity[joint] = limits[joint].velocity;
        input.max_acceleration[joint] = limits[joint].acceleration;
        input.max_jerk[joint] = limits[joint].jerk;
    }
    let mut trajectory = Trajectory::<N>::new(None);
    let _ = otg.calculate(&input, &mut trajectory).ok()?;
    Some(trajectory)
}

fn their_position<const N: usize>(trajectory: &Trajectory<N>, joint: usize, t: f64) -> f64 {
    let mut position = DataArrayOrVec::<f64, N>::new(None, 0.0);
    trajectory.at_time(
        t,
        &mut Some(&mut position),
        &mut None,
        &mut None,
        &mut None,
        &mut None,
    );
    position[joint]
}

/// Plans random moves of `N` joints with both. Those that rsruckig can plan, more than `at_least`, are as fast as ours to
/// `within` (relative), and `look` sees them.
fn both_are_as_fast<const N: usize>(
    seed: u64,
    (moves, at_least): (usize, usize),
    within: f64,
    look: impl Fn(usize, &JointMove<N>, &Trajectory<N>),
) {
    let mut cases = Cases(Pcg64Mcg::seed_from_u64(seed));
    let mut compared = 0;
    for case in 0..moves {
        let (start, goal, limits) = cases.joints::<N>();
        let ours = JointMove::try_new(&start, &goal, &limits)
            .unwrap_or_else(|error| panic!("case {case}: {error}"));
        keeps_its_promises(&ours, &start, &goal, &limits);
        let Some(theirs) = theirs(&start, &goal, &limits) else {
            continue;
        };
        let (a, b) = (ours.duration(), theirs.get_duration());
        assert!(
            (a - b).abs() < within * (1.0 + b),
            "case {case}: {a} s, rsruckig {b} s"
        );
        look(case, &ours, &theirs);
        compared += 1;
    }
    assert!(compared > at_least, "{compared} of {moves}");
}

#[test]
fn one_joint_is_as_fast_as_rsruckig_and_on_the_same_way() {
    both_are_as_fast::<1>(1, (4000, 3900), 1e-7, |case, ours, theirs| {
        for part in 1..10 {
            let t = theirs.get_duration() * f64::from(part) / 10.0;
            let difference = ours.at(t)[0].position - their_position(theirs, 0, t);
            assert!(
                difference.abs() < 1e-6,
                "case {case} at {t} s: {difference}"
            );
        }
    });
}

#[test]
fn six_joints_arrive_together_as_fast_as_with_rsruckig() {
    both_are_as_fast::<6>(2, (1000, 950), 1e-6, |_, _, _| {});
}

#[test]
fn from_rest_to_rest_it_is_as_fast_as_rsruckig_for_any_limits() {
    let mut cases = Cases(Pcg64Mcg::seed_from_u64(3));
    for case in 0..2000 {
        let (start, goal, limits) = cases.joints::<3>();
        let start = start.map(|state| State::at_rest(state.position));
        let mut goal = goal.map(|state| State::at_rest(state.position));
        if case % 3 == 0 {
            // One joint has nothing to do.
            goal[1] = start[1];
        }
        let ours = JointMove::try_new(&start, &goal, &limits).unwrap();
        keeps_its_promises(&ours, &start, &goal, &limits);
        let theirs = theirs(&start, &goal, &limits).unwrap();
        let (a, b) = (ours.duration(), theirs.get_duration());
        assert!(
            (a - b).abs() < 1e-9 * (1.0 + b),
            "case {case}: {a} s, rsruckig {b} s"
        );
        let slowest = ours.slowest();
        for part in 1..10 {
            let t = b * f64::from(part) / 10.0;
            let difference = ours.at(t)[slowest].position - their_position(&theirs, slowest, t);
            assert!(
                difference.abs() < 1e-7,
                "case {case} at {t} s: {difference}"
            );
        }
        // A joint that waits never turns back.
        for (joint, (start, goal)) in start.iter().zip(&goal).enumerate() {
            let sign = (goal.position - start.position).signum();
            for part in 0..=20 {
                let now = ours.at(a * f64::from(part) / 20.0)[joint];
                assert!(now.velocity * sign >= -1e-9, "case {case}: {now:?}");
            }
        }
    }
}
