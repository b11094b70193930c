//! Faults and the plant cycles in which they are active. Random faults are drawn from the seed, the
//! place of the fault in the list and the cycle, so they do not depend on other events.
use crate::error::Error;
use serde::Deserialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    DriveFault,
    EncoderJump,
    EncoderFrozen,
    ModeChange,
    ControlIgnored,
    SafeOp,
    WkcShort,
    CableCut,
    FrameLost,
    FrameDuplicated,
    FrameDelayed,
    FrameReordered,
}

impl FaultKind {
    /// Name in the options file.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::DriveFault => "drive_fault",
            FaultKind::EncoderJump => "encoder_jump",
            FaultKind::EncoderFrozen => "encoder_frozen",
            FaultKind::ModeChange => "mode_change",
            FaultKind::ControlIgnored => "control_ignored",
            FaultKind::SafeOp => "safe_op",
            FaultKind::WkcShort => "wkc_short",
            FaultKind::CableCut => "cable_cut",
            FaultKind::FrameLost => "frame_lost",
            FaultKind::FrameDuplicated => "frame_duplicated",
            FaultKind::FrameDelayed => "frame_delayed",
            FaultKind::FrameReordered => "frame_reordered",
        }
    }

    fn default_count(self) -> u64 {
        match self {
            FaultKind::EncoderJump
            | FaultKind::EncoderFrozen
            | FaultKind::ControlIgnored
            | FaultKind::CableCut => 0,
            _ => 1,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LossTime {
    Before,
    After,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    pub kind: FaultKind,
    /// First plant cycle.
    pub cycle: u64,
    /// Duration in cycles; 0: until the end.
    pub count: Option<u64>,
    /// Position on the bus, from 0.
    #[serde(default)]
    pub position: usize,
    /// Error code of a drive fault, AL status code of safe_op.
    pub code: Option<u16>,
    /// Counts of an encoder jump; mode of a change of mode.
    #[serde(default = "Fault::default_size")]
    pub size: i64,
    /// The frame is lost before its outputs act, or its reply is lost after.
    #[serde(default = "Fault::default_acting")]
    pub acting: LossTime,
    /// Delay of a reply in frames.
    #[serde(default = "Fault::default_frames")]
    pub frames: u64,
    /// Probability in each cycle.
    #[serde(default = "Fault::default_probability")]
    pub probability: f64,
    #[serde(default)]
    pub seed: u64,
}

impl Fault {
    fn default_size() -> i64 {
        1_000_000
    }
    fn default_acting() -> LossTime {
        LossTime::Before
    }
    fn default_frames() -> u64 {
        1
    }
    fn default_probability() -> f64 {
        1.0
    }

    /// Refuses values outside their ranges; `devices`: number on the bus.
    pub fn check(&self, place: usize, devices: usize) -> Result<(), Error> {
        let name = self.kind.name();
        let wrong = |what: String| Err(Error::new(format!("fault {} ({name}): {what}", place + 1)));
        if !(0.0..=1.0).contains(&self.probability) {
            return wrong(format!("probability = {}, allowed 0 to 1", self.probability));
        }
        // a cable may be cut behind the last device too
        let last = if self.kind == FaultKind::CableCut { devices } else { devices - 1 };
        if self.position > last {
            return wrong(format!("position = {}, allowed 0 to {last}", self.position));
        }
        if self.cycle == 0 {
            return wrong(
                "cycle = 0 starts the plant and must be without a fault; allowed 1 and up".into(),
            );
        }
        if self.frames == 0 {
            return wrong("frames = 0, allowed 1 and up".into());
        }
        Ok(())
    }

    fn last(&self) -> u64 {
        match self.count.unwrap_or(self.kind.default_count()) {
            0 => u64::MAX,
            count => self.cycle.saturating_add(count - 1),
        }
    }

    /// Active in this cycle. `place`: index in the list.
    pub fn acts(&self, place: usize, cycle: u64) -> bool {
        (self.cycle..=self.last()).contains(&cycle)
            && (self.probability >= 1.0 || chance(self.seed, place, cycle) < self.probability)
    }

    /// The first cycle after the fault, in which its effect is removed.
    pub fn ends(&self, cycle: u64) -> bool {
        self.last().checked_add(1) == Some(cycle)
    }
}

/// Uniform in [0, 1) [Steele et al. 2014, SplitMix64].
pub fn chance(seed: u64, place: usize, cycle: u64) -> f64 {
    let mut mixed = seed;
    for value in [place as u64, cycle] {
        mixed = mix(mixed.wrapping_add(mix(value)));
    }
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

pub fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> Fault {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn a_fault_begins_and_ends_at_its_exact_cycle() {
        let short = fault("kind = 'wkc_short'\ncycle = 100\ncount = 3");
        let cycles: Vec<u64> = (90..120).filter(|n| short.acts(0, *n)).collect();
        assert_eq!(cycles, [100, 101, 102]);
        assert!(short.ends(103) && !short.ends(102));
        let ever = fault("kind = 'cable_cut'\ncycle = 100");
        assert!(ever.acts(0, u64::MAX) && !ever.acts(0, 99) && !ever.ends(0));
    }

    #[test]
    fn a_chance_is_what_it_says_and_repeats() {
        let lost = fault("kind = 'frame_lost'\ncycle = 1\ncount = 0\nprobability = 0.1\nseed = 7");
        let hits = |fault: &Fault, place| (1..100_001).filter(|n| fault.acts(place, *n)).count();
        // 10 000 expected, standard deviation 95
        assert!((9_600..10_400).contains(&hits(&lost, 0)), "{}", hits(&lost, 0));
        assert_eq!(hits(&lost, 0), hits(&lost.clone(), 0));
        assert_ne!(hits(&lost, 0), hits(&lost, 1));
    }

    #[test]
    fn impossible_faults_are_refused_with_the_allowed_range() {
        let text = |toml: &str| fault(toml).check(0, 6).unwrap_err().to_string();
        assert!(text("kind = 'frame_lost'\ncycle = 0").contains("allowed 1 and up"));
        assert!(text("kind = 'safe_op'\ncycle = 5\nposition = 6").contains("allowed 0 to 5"));
        assert!(text("kind = 'cable_cut'\ncycle = 5\nposition = 7").contains("allowed 0 to 6"));
        assert!(text("kind = 'frame_lost'\ncycle = 5\nprobability = 2.0").contains("0 to 1"));
    }
}
