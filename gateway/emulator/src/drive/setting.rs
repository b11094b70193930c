//! What a drive is set to.
use super::kind::Kind;

/// Settings of a drive.
#[derive(Debug, Clone)]
pub struct Setting {
    pub kind: Kind,
    /// `[N m/A]`
    pub torque_constant: f64,
    /// Object 0x6076 `[mN m]`.
    pub rated_torque_mnm: u32,
    /// Largest current `[mA]`, or largest torque [0.1 % of the rated one].
    pub limit: i64,
    pub counts_per_rev: f64,
    /// 1 or -1: counts and current against the axis.
    pub direction: i64,
    /// Counts where the axis is at 0.
    pub offset: i64,
    /// Dynamic braking while not enabled: short-circuited windings `[N m s/rad]`; 0: it coasts.
    pub braking: f64,
}

impl Setting {
    /// Torque of one step of target and measured torque `[N m]`.
    pub fn torque_step(&self) -> f64 {
        match self.kind {
            Kind::Akd => self.torque_constant * 0.001,
            Kind::Cst => f64::from(self.rated_torque_mnm) * 0.001 * 0.001,
        }
    }

    /// Angle of one count `[rad]`.
    pub fn angle_step(&self) -> f64 {
        std::f64::consts::TAU / self.counts_per_rev
    }
}
