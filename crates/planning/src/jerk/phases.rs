//! Seven phases of constant jerk.

use crate::state::State;

/// Durations of the phases up, hold, down, cruise, down, hold, up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Phases(pub(super) [f64; 7]);

/// The jerk of each phase, as a multiple of the limit.
const SIGNS: [f64; 7] = [1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0];

impl Phases {
    /// The state at the end; `jerk` is negative for the mirrored pattern.
    pub(super) fn end(&self, start: State, jerk: f64) -> State {
        let Phases([up, hold, down, cruise, down_again, hold_again, up_again]) = *self;
        let mut state = start.after(up, jerk);
        if hold > 0.0 {
            state = state.after(hold, 0.0);
        }
        state = state.after(down, -jerk);
        if cruise > 0.0 {
            state = state.after(cruise, 0.0);
        }
        if down_again > 0.0 {
            state = state.after(down_again, -jerk);
        }
        if hold_again > 0.0 {
            state = state.after(hold_again, 0.0);
        }
        state.after(up_again, jerk)
    }

    /// After how many seconds the position is reached, which is before the cruise or at its start.
    pub(super) fn time_to(&self, start: State, jerk: f64, position: f64) -> f64 {
        let (mut state, mut before) = (start, 0.0);
        for (duration, sign) in self.0.into_iter().zip(SIGNS).take(3) {
            let next = state.after(duration, sign * jerk);
            if position <= next.position {
                return before + state.time_to(position, sign * jerk, duration);
            }
            state = next;
            before += duration;
        }
        before
    }

    /// The state `t` seconds after the start.
    pub(super) fn at(&self, start: State, jerk: f64, t: f64) -> State {
        let (mut state, mut left) = (start, t.max(0.0));
        for (duration, sign) in self.0.into_iter().zip(SIGNS) {
            if left < duration {
                return state.after(left, sign * jerk);
            }
            state = state.after(duration, sign * jerk);
            left -= duration;
        }
        state
    }
}
