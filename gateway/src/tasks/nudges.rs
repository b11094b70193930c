//! Pushes each axis to and fro, without any feedback, and sees which way its encoder goes.

use super::failure::Wrong;
use super::step::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// A push ends at this motion of an axis [rad], or after this time [s].
const MOVED: f64 = 3e-3;
const PUSH_S: f64 = 0.15;
/// Time before each push, with two windows at its end in which the motion without it is seen [s].
const WAIT_S: f64 = 0.3;
const WINDOW_S: f64 = 0.05;
/// Another axis that moves so many times as much is the one that was pushed.
const EXCHANGED: f64 = 2.0;

/// What a push did to its axis, and to the one of the others that moved more. Motions are those beyond
/// what the machine did before [rad].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nudge {
    pub moved: f64,
    pub other: Option<(usize, f64)>,
}

impl Nudge {
    /// What is wrong, if anything is.
    pub fn fault(&self) -> Option<Wrong> {
        match self.other {
            Some((other, far)) => Some(Wrong::Exchanged(other, far)),
            _ if self.moved.abs() < MOVED => Some(Wrong::Still),
            _ if self.moved < 0.0 => Some(Wrong::Against),
            _ => None,
        }
    }
}

pub struct Nudges {
    torque: f64,
    /// Lengths in cycles: wait before a push, the two windows at its end, longest push.
    wait: u32,
    window: u32,
    most: u32,
    axis: usize,
    /// Cycles of this axis so far: it waits, is pushed, stopped, pushed back and stopped.
    cycle: u32,
    /// Length of a push in cycles, once it is known.
    push: Option<u32>,
    /// Angles two windows, one window and no time before the push [rad].
    before: [Axes; 3],
    pub done: [Nudge; AXES],
}

impl Nudges {
    pub fn new(torque: f64, base_step: f64) -> Nudges {
        let cycles = |time: f64| (time / base_step).round() as u32;
        Nudges {
            torque,
            wait: cycles(WAIT_S),
            window: cycles(WINDOW_S),
            most: cycles(PUSH_S),
            axis: 0,
            cycle: 0,
            push: None,
            before: [[0.0; AXES]; 3],
            done: [Nudge::default(); AXES],
        }
    }

    /// Where the machine rests; the torque is given by `step`.
    pub fn begin(&mut self, rest: &Axes) -> Leg {
        Leg::new(*rest, *rest)
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        self.cycle += 1;
        if !seen.complete {
            return Step::Stay;
        }
        let k = self.axis;
        if self.cycle <= self.wait {
            let left = self.wait - self.cycle;
            if left.is_multiple_of(self.window) && left <= 2 * self.window {
                self.before[2 - (left / self.window) as usize] = *seen.theta;
            }
            return if left == 0 { Step::Push(k, self.torque) } else { Step::Stay };
        }
        let since = self.cycle - self.wait;
        let enough = self.push.is_some() || self.note(seen.theta, since);
        if !enough && since < self.most {
            return Step::Stay;
        }
        let push = *self.push.get_or_insert(since);
        // to, stop, back, stop: it ends where it was, as slow as it was
        match since / push {
            1 | 2 => Step::Push(k, -self.torque),
            3 => Step::Push(k, self.torque),
            _ if k + 1 == AXES => Step::Over,
            _ => {
                (self.axis, self.cycle, self.push) = (k + 1, 0, None);
                Step::Push(k, 0.0)
            }
        }
    }

    /// Motion of an axis beyond the parabola through its angles before the push [rad].
    fn beyond(&self, j: usize, theta: &Axes, since: u32) -> f64 {
        let [a, b, c] = self.before.map(|theta| theta[j]);
        let s = f64::from(since) / f64::from(self.window);
        theta[j] - (c + s * (c - b) + 0.5 * s * (s + 1.0) * (c - 2.0 * b + a))
    }

    /// Takes the motion of a push; whether it is enough.
    fn note(&mut self, theta: &Axes, since: u32) -> bool {
        let k = self.axis;
        let moved = |j: usize| self.beyond(j, theta, since);
        let most = (0..AXES).fold(k, |a, b| if moved(b).abs() > moved(a).abs() { b } else { a });
        let more = moved(most).abs() >= EXCHANGED * moved(k).abs().max(MOVED / EXCHANGED);
        let other = (most != k && more).then(|| (most, moved(most)));
        let nudge = Nudge { moved: moved(k), other };
        let enough = nudge.moved.abs() >= MOVED || other.is_some();
        self.done[k] = nudge;
        enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.00025;

    /// Pushes masses on springs that swing; `gain[j][k]`: how axis j is moved when k is pushed.
    fn pushed(gain: impl Fn(usize, usize) -> f64) -> [Nudge; AXES] {
        let mut nudges = Nudges::new(0.5, H);
        let (mut tau, mut theta, mut rate) = ([0.0; AXES], [0.02; AXES], [0.03; AXES]);
        nudges.begin(&theta);
        for _ in 0..20_000 {
            for j in 0..AXES {
                let pushed: f64 = (0..AXES).map(|k| gain(j, k) * tau[k]).sum();
                rate[j] += H * (pushed - 2.0 * theta[j]) / 0.1;
                theta[j] += H * rate[j];
            }
            let seen = Seen { complete: true, theta: &theta, tau_meas: &tau, r: &theta, left: 0 };
            match nudges.step(&seen) {
                Step::Push(k, torque) => tau[k] = torque,
                Step::Over => return nudges.done,
                _ => {}
            }
            let quiet = theta.iter().zip(&rate).all(|(t, r)| t.abs() < 0.05 && r.abs() < 0.4);
            assert!(quiet, "{theta:?} {rate:?}");
        }
        panic!("it never ends");
    }

    #[test]
    fn each_fault_is_told_and_a_sound_axis_has_none() {
        let unit = |j: usize, k: usize| f64::from(u8::from(j == k));
        let sound = pushed(unit);
        assert!(sound.iter().all(|n| n.fault().is_none() && n.moved < 1.2 * MOVED), "{sound:?}");
        let failure = |gain: &dyn Fn(usize, usize) -> f64, k: usize| {
            pushed(gain)[k].fault().unwrap().to_string()
        };
        let turned = |j: usize, k: usize| if j == 3 { -unit(j, k) } else { unit(j, k) };
        assert!(failure(&turned, 3).contains("moved against its torque"));
        let stiff = |j: usize, k: usize| if j == 3 { 0.01 * unit(j, k) } else { unit(j, k) };
        assert!(failure(&stiff, 3).contains("moved"));
        let swapped = |j: usize, k: usize| unit([1, 0, 2, 3, 4, 5][j], k);
        assert!(failure(&swapped, 0).contains("axis 2 moved more"));
        assert!(pushed(swapped)[4].fault().is_none());
    }
}
