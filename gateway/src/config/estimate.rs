//! What the estimator has learned: where a run takes it from, and what it may be.

use serde::Deserialize;
use std::path::PathBuf;

use super::mistakes::Mistakes;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Estimate {
    /// File of an earlier run to start from; left out: from the values of the system description.
    pub resume: Option<PathBuf>,
    /// Largest distance of a value, saved or new, from its first one, in its scale: `p`, `p0`, `scale`.
    pub range: f64,
    /// Largest innovation, the torque [N m] that the model did not expect; 0: not judged.
    #[serde(rename = "innovation_N_m")]
    pub innovation: f64,
}

impl Default for Estimate {
    fn default() -> Self {
        Estimate { resume: None, range: 5.0, innovation: 1.5 }
    }
}

impl Estimate {
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        let mend = "largest distance of a saved p from p0, in units of scale";
        mistakes.check_range("estimate.range", self.range, 1e-6..=1e6, mend);
        let mend = "largest torque that the model did not expect, 0: not judged";
        mistakes.check_range("estimate.innovation_N_m", self.innovation, 0.0..=1e6, mend);
    }
}
