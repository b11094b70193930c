//! Lift-off and landing without the controller: a planned path, a PID for each axis, and the weight or what a model
//! says. It uses no sockets, clocks or FMUs, so it works when these have failed.

mod brake;
mod path;
#[cfg(test)]
mod tests;

use flexhex_system::Motion;

use crate::config::AXES;
pub use brake::Brakes;
pub use path::{Pace, Path};

type Axes = [f64; AXES];

/// Deflection [rad] below which a rest pose says nothing about the weight.
const SMALL: f64 = 0.05;

/// Gains of `feedback.fmu`: tau = kp (1 + 1 / (t_i s) + t_d s / (t_f s + 1)) e.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    pub kp: Axes,
    pub t_i: f64,
    pub t_d: f64,
    pub t_f: f64,
}

/// What lift-off and landing know of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Mechanics {
    pub gains: Gains,
    /// Torque that holds the neutral pose [N m].
    pub weight: Axes,
    /// Largest torque [N m].
    pub torque: f64,
    pub pace: Pace,
}

impl Mechanics {
    /// Torque that holds a pose [N m]: the line through two known poses, the weight at the neutral one and
    /// nothing at `rest`, where the machine rests without torque.
    pub fn holding(&self, pose: &Axes, rest: &Axes) -> Axes {
        std::array::from_fn(|k| {
            let share = if rest[k].abs() < SMALL { 1.0 } else { 1.0 - pose[k] / rest[k] };
            self.weight[k] * share.clamp(0.0, 2.0)
        })
    }
}

/// Follows a path.
#[derive(Clone, Copy, Debug)]
pub struct Mover {
    mechanics: Mechanics,
    path: Path,
    rest: Axes,
    /// Axes whose feedback is not used: they get the push alone. In a landing their drives brake them, without power.
    pub blind: [bool; AXES],
    pub push: Axes,
    /// Torques of the motion by a model of the machine [N m]. None: the line through two known poses alone.
    pub model: Option<Axes>,
    /// Largest torque of each axis [N m].
    pub most: Axes,
    cycle: u32,
    e_last: Option<Axes>,
    e_sum: Axes,
    e_rate: Axes,
    /// Wanted angles and errors of the newest cycle [rad].
    pub r: Axes,
    pub e: Axes,
    /// Torque of the next frame [N m].
    pub tau: Axes,
}

impl Mover {
    /// `rest`: the pose in which the machine rests without torque.
    pub fn new(mechanics: Mechanics, path: Path, rest: Axes, blind: [bool; AXES]) -> Mover {
        Mover {
            mechanics,
            path,
            rest,
            blind,
            push: [0.0; AXES],
            model: None,
            most: [mechanics.torque; AXES],
            cycle: 0,
            e_last: None,
            e_sum: [0.0; AXES],
            e_rate: [0.0; AXES],
            r: path.at(0),
            e: [0.0; AXES],
            tau: [0.0; AXES],
        }
    }

    /// Begins with torques [N m] where the errors are zero, as far as it may: by what was `given` beyond what was
    /// `expected`.
    pub fn begin_with(&mut self, given: &Axes, expected: &Axes) {
        let g = self.mechanics.gains;
        for k in 0..AXES {
            let more = (given[k] - expected[k]).clamp(-self.most[k], self.most[k]);
            self.e_sum[k] = more * g.t_i / g.kp[k];
        }
    }

    /// Torques without any error of the angles [N m].
    pub fn holding(&self) -> Axes {
        self.model.unwrap_or_else(|| self.mechanics.holding(&self.r, &self.rest))
    }

    /// The motion of the next cycle, in which its torques act.
    pub fn motion(&self) -> Motion {
        self.path.motion(self.cycle)
    }

    /// Goes on along another path: nothing that was learned is lost, and where it begins elsewhere, that is no
    /// rate of the error.
    pub fn follow(&mut self, path: Path) {
        let from = path.at(0);
        for k in (0..AXES).filter(|k| from[*k] != self.r[*k]) {
            self.e_rate[k] = 0.0;
            if let Some(last) = &mut self.e_last {
                last[k] += from[k] - self.r[k];
            }
        }
        (self.path, self.cycle) = (path, 0);
    }

    /// Cycles left.
    pub fn left(&self) -> u32 {
        self.path.cycles().saturating_sub(self.cycle)
    }

    /// Takes the angles of a cycle [rad]. The path waits where the clock `skipped` cycles, and what changed
    /// meanwhile is no rate.
    pub fn step(&mut self, theta: &Axes, skipped: u64) {
        self.r = self.path.at(self.cycle);
        let hold = self.holding();
        let e: Axes =
            std::array::from_fn(|k| if self.blind[k] { 0.0 } else { self.r[k] - theta[k] });
        let last = self.e_last.filter(|_| skipped == 0).unwrap_or(e);
        let (g, h) = (self.mechanics.gains, self.mechanics.pace.base_step);
        for k in 0..AXES {
            let sum = self.e_sum[k] + h / 2.0 * (last[k] + e[k]);
            self.e_rate[k] =
                ((2.0 * g.t_f - h) * self.e_rate[k] + 2.0 * (e[k] - last[k])) / (2.0 * g.t_f + h);
            let wanted = hold[k] + g.kp[k] * (e[k] + sum / g.t_i + g.t_d * self.e_rate[k]);
            let most = self.most[k];
            // anti-windup: at the limit the sum may only lead away from it
            let saturated = wanted.abs() > most && (sum - self.e_sum[k]) * wanted > 0.0;
            self.e_sum[k] = if saturated { self.e_sum[k] } else { sum };
            let open = self.push[k].clamp(-most, most);
            self.tau[k] = if self.blind[k] { open } else { wanted.clamp(-most, most) };
        }
        (self.e, self.e_last) = (e, Some(e));
        self.cycle += 1;
    }
}
