//! Pushes each axis a little, without any feedback, and sees which way its encoder goes.

use super::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// The push ends at this motion of any axis [rad].
const MOVED: f64 = 2e-3;
/// The torque grows to its limit in this time, falls in a tenth of it, and is 0 as long before the next axis [s].
const GROWS_S: f64 = 1.0;

/// What a push did to its axis and to the one of the others that moved most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nudge {
    pub torque: f64,
    pub moved: f64,
    /// Axis, from 0, that moved more, and by how much [rad].
    pub other: Option<(usize, f64)>,
}

impl Nudge {
    /// What is wrong, if anything is.
    pub fn fault(&self) -> Option<String> {
        match self.other {
            Some((other, far)) => Some(format!(
                "axis {} moved more, by {far:.5} rad: drives or encoders are exchanged",
                other + 1
            )),
            _ if self.moved.abs() < MOVED => Some(
                "it hardly moved: it is blocked, rests on a stop, or needs more torque (--torque)"
                    .to_owned(),
            ),
            _ if self.moved < 0.0 => Some(
                "it moved against its torque: encoder or motor phases of this drive count the other way; \
                 `direction` turns both and does not mend it"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

pub struct Nudges {
    /// Largest torque [N m].
    most: f64,
    base_step: f64,
    axis: usize,
    tau: f64,
    pushes: bool,
    /// Cycles without torque.
    still: u32,
    from: Axes,
    pub done: [Nudge; AXES],
}

impl Nudges {
    pub fn new(most: f64, base_step: f64) -> Nudges {
        Nudges {
            most,
            base_step,
            axis: 0,
            tau: 0.0,
            pushes: true,
            still: 0,
            from: [0.0; AXES],
            done: [Nudge::default(); AXES],
        }
    }

    pub fn begin(&mut self, rest: &Axes) -> Leg {
        self.from = *rest;
        Leg::new(*rest, *rest)
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        let k = self.axis;
        if !seen.complete {
            return Step::Stay;
        }
        let grows = self.most * self.base_step / GROWS_S;
        if self.pushes {
            self.note(seen.theta);
            let moved = (0..AXES).any(|k| (seen.theta[k] - self.from[k]).abs() >= MOVED);
            self.pushes = !moved && self.tau < self.most;
            self.tau = (self.tau + grows).min(self.most);
            return Step::Push(k, self.tau);
        }
        if self.tau > 0.0 {
            self.tau = (self.tau - 10.0 * grows).max(0.0);
            return Step::Push(k, self.tau);
        }
        self.still += 1;
        if f64::from(self.still) * self.base_step < GROWS_S {
            return Step::Stay;
        }
        if k + 1 == AXES {
            return Step::Over;
        }
        (self.axis, self.still, self.pushes, self.from) = (k + 1, 0, true, *seen.theta);
        Step::Stay
    }

    fn note(&mut self, theta: &Axes) {
        let k = self.axis;
        let moved = |k: usize| theta[k] - self.from[k];
        let most = (0..AXES).fold(k, |a, b| if moved(b).abs() > moved(a).abs() { b } else { a });
        let other = (most != k && moved(most).abs() >= MOVED).then(|| (most, moved(most)));
        self.done[k] = Nudge { torque: self.tau, moved: moved(k), other };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pushes springs of 2 N m/rad; `gain[j][k]`: how axis j moves when k is pushed.
    fn pushed(gain: impl Fn(usize, usize) -> f64) -> [Nudge; AXES] {
        let mut nudges = Nudges::new(0.5, 0.00025);
        let mut tau = [0.0; AXES];
        nudges.begin(&[0.0; AXES]);
        for _ in 0..200_000 {
            let theta = std::array::from_fn(|j| {
                (0..AXES).map(|k| gain(j, k) * tau[k] / 2.0).sum::<f64>()
            });
            let seen = Seen { complete: true, theta: &theta, tau_meas: &tau, tau: &tau, left: 0 };
            match nudges.step(&seen) {
                Step::Push(k, torque) => tau[k] = torque,
                Step::Over => {
                    assert_eq!(tau, [0.0; AXES]);
                    return nudges.done;
                }
                _ => {}
            }
            assert!(tau.iter().all(|tau| (0.0..=0.5).contains(tau)));
            assert!(theta.iter().all(|theta| theta.abs() < 1.1 * MOVED));
        }
        panic!("it never ends");
    }

    #[test]
    fn each_fault_is_told_and_a_sound_axis_has_none() {
        let unit = |j: usize, k: usize| f64::from(u8::from(j == k));
        assert!(pushed(unit).iter().all(|n| n.fault().is_none() && n.torque < 0.01));
        let told = |gain: &dyn Fn(usize, usize) -> f64, k: usize| pushed(gain)[k].fault().unwrap();
        let turned = |j: usize, k: usize| if j == 3 { -unit(j, k) } else { unit(j, k) };
        assert!(told(&turned, 3).contains("moved against its torque"));
        let stiff = |j: usize, k: usize| if j == 3 { 1e-6 } else { unit(j, k) };
        assert!(told(&stiff, 3).contains("hardly moved"));
        let swapped = |j: usize, k: usize| unit([1, 0, 2, 3, 4, 5][j], k);
        assert!(told(&swapped, 0).contains("axis 2 moved more"));
        assert!(pushed(swapped)[4].fault().is_none());
    }
}
