//! Torques watched while the machine is enabled: their change in a cycle, what the drives measure against what
//! they were sent, and what the feedback has to add to the model.

use super::measured::Measured;
use super::shares::Shares;
use crate::config::{Config, AXES};
use crate::rules::{Reason, Trip};

type Axes = [f64; AXES];

/// A low-pass of first order for each axis.
#[derive(Clone, Debug)]
struct Mean {
    value: Axes,
    share: f64,
}

impl Mean {
    fn new(time: f64, base_step: f64) -> Mean {
        Mean { value: [0.0; AXES], share: (base_step / time).min(1.0) }
    }

    /// Takes a value of an axis; its mean.
    fn note(&mut self, k: usize, x: f64) -> f64 {
        self.value[k] += self.share * (x - self.value[k]);
        self.value[k]
    }
}

/// What the monitors remember from cycle to cycle.
#[derive(Clone, Debug)]
pub struct Monitors {
    /// Torques of the next frame as they were judged in the last two cycles, the newest first.
    sent: [Option<Axes>; 2],
    feedback: Mean,
    measured: Mean,
    /// Of the square of the measured torque.
    square: Mean,
}

impl Monitors {
    pub fn new(config: &Config, base_step: f64) -> Monitors {
        let s = &config.safety;
        Monitors {
            sent: [None; 2],
            feedback: Mean::new(s.feedback_s, base_step),
            measured: Mean::new(s.measured_s, base_step),
            square: Mean::new(s.thermal_s, base_step),
        }
    }

    /// The torque that a phase begins from [N m].
    pub fn begin_from(&mut self, tau: Axes) {
        self.sent = [Some(tau), None];
    }

    /// Another phase begins: its torques are not those of the last.
    pub fn restart(&mut self) {
        *self = Monitors {
            sent: [None; 2],
            feedback: Mean { value: [0.0; AXES], ..self.feedback.clone() },
            measured: self.measured.clone(),
            square: self.square.clone(),
        };
    }

    /// The first torque that is not plausible. A limit of 0 is not judged.
    pub fn judge(
        &mut self,
        m: &Measured,
        (config, blind): (&Config, &[bool; AXES]),
        (powered, complete): (bool, bool),
        shares: &Shares,
    ) -> Option<Trip> {
        if !powered {
            return None;
        }
        let [newest, before] = self.sent;
        let mut first = None;
        for k in 0..AXES {
            let l = config.limits(k);
            let mut over = |reason, value: f64, limit: f64| {
                shares.note(reason, value, limit);
                if limit > 0.0 && (value.is_nan() || value.abs() > limit) {
                    first = first.or(Some(Trip::of(reason, Some(k), value, limit, m.cycle)));
                }
            };
            if let Some(sent) = newest {
                // skipped cycles are computed, but their torques are not sent
                let cycles = 1.0 + m.skipped as f64;
                over(Reason::TorqueStep, m.tau[k] - sent[k], l.torque_step * cycles);
            }
            // a current follows its command within a cycle
            if let (Some(before), true, 0, false) = (before, complete, m.skipped, blind[k]) {
                let off = self.measured.note(k, m.tau_meas[k] - before[k]);
                over(Reason::MeasuredTorque, off, l.measured_torque);
            }
            // without a reply nothing was measured
            if complete {
                let square = self.square.note(k, m.tau_meas[k] * m.tau_meas[k]);
                over(Reason::Thermal, square.sqrt(), l.rated_torque);
            }
            if let Some(feedback) = m.feedback {
                let carried = self.feedback.note(k, feedback[k]);
                over(Reason::FeedbackTorque, carried, l.feedback_torque);
            }
        }
        let mut tau = [0.0; AXES];
        tau.copy_from_slice(&m.tau[..AXES]);
        self.sent = [Some(tau), newest];
        first
    }
}
