//! Pushes each axis to and fro, without any feedback, and sees which way its encoder goes.

use super::failure::{Failure, Wrong};
use super::step::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// A push ends at this motion of an axis [rad], or after this time [s].
const MOVED: f64 = 3e-3;
const PUSH_S: f64 = 0.15;
/// Before each push the angles are seen at the ends of so many windows: of the last three follows what it does without
/// a push, and of the first three whether that can be told. As long as it cannot, the machine still swings.
const WINDOWS: usize = 6;
const WINDOW_S: f64 = 0.05;
/// Longest wait until it can be told [s].
const PATIENCE_S: f64 = 120.0;
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
    /// Lengths in cycles: a window, the longest wait, the longest push.
    window: u32,
    patience: u32,
    most: u32,
    axis: usize,
    /// Cycles of this axis so far: it waits, is pushed, stopped, pushed back and stopped.
    cycle: u32,
    /// The cycle in which it was pushed, and the length of the push in cycles, once they are known.
    began: Option<u32>,
    push: Option<u32>,
    /// Angles at the ends of the last windows, the newest last [rad].
    before: [Axes; WINDOWS],
    pub done: [Nudge; AXES],
}

impl Nudges {
    pub fn new(torque: f64, base_step: f64) -> Nudges {
        let cycles = |time: f64| (time / base_step).round() as u32;
        Nudges {
            torque,
            window: cycles(WINDOW_S),
            patience: cycles(PATIENCE_S),
            most: cycles(PUSH_S),
            axis: 0,
            cycle: 0,
            began: None,
            push: None,
            before: [[0.0; AXES]; WINDOWS],
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
        let Some(began) = self.began else { return self.wait(seen.theta) };
        let since = self.cycle - began;
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
                (self.axis, self.cycle, self.began, self.push) = (k + 1, 0, None, None);
                Step::Push(k, 0.0)
            }
        }
    }

    /// A cycle before the push, which begins when the motion without it can be told to half of what it must cause.
    fn wait(&mut self, theta: &Axes) -> Step {
        if !self.cycle.is_multiple_of(self.window) {
            return Step::Stay;
        }
        self.before.rotate_left(1);
        self.before[WINDOWS - 1] = *theta;
        if self.cycle < WINDOWS as u32 * self.window {
            return Step::Stay;
        }
        let off = |s: usize, j: usize| beyond(&self.before[..3], j, &self.before[2 + s], s as f64);
        let most = (0..AXES).flat_map(|j| (1..=3).map(move |s| (s, j)));
        let most = most.fold(0.0, |most: f64, (s, j)| most.max(off(s, j).abs()));
        if most < MOVED / 2.0 {
            self.began = Some(self.cycle);
            return Step::Push(self.axis, self.torque);
        }
        let over = self.cycle >= self.patience;
        if over {
            Step::Fail(Failure::Swings { off: most, allowed: MOVED / 2.0 })
        } else {
            Step::Stay
        }
    }

    /// Takes the motion of a push; whether it is enough.
    fn note(&mut self, theta: &Axes, since: u32) -> bool {
        let k = self.axis;
        let s = f64::from(since) / f64::from(self.window);
        let moved = |j: usize| beyond(&self.before[WINDOWS - 3..], j, theta, s);
        let most = (0..AXES).fold(k, |a, b| if moved(b).abs() > moved(a).abs() { b } else { a });
        let more = moved(most).abs() >= EXCHANGED * moved(k).abs().max(MOVED / EXCHANGED);
        let other = (most != k && more).then(|| (most, moved(most)));
        let nudge = Nudge { moved: moved(k), other };
        let enough = nudge.moved.abs() >= MOVED || other.is_some();
        self.done[k] = nudge;
        enough
    }
}

/// Motion of an axis beyond the parabola through its angles at the ends of three windows, `s` windows later [rad].
fn beyond(before: &[Axes], j: usize, theta: &Axes, s: f64) -> f64 {
    let (a, b, c) = (before[0][j], before[1][j], before[2][j]);
    theta[j] - (c + s * (c - b) + 0.5 * s * (s + 1.0) * (c - 2.0 * b + a))
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
