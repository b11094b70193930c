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
    EncoderDrift,
    ModeChange,
    ControlIgnored,
    StatusFrozen,
    Sto,
    Push,
    Jam,
    TorqueFrozen,
    SafeOp,
    WkcShort,
    CableCut,
    FrameLost,
    FrameDuplicated,
    FrameDelayed,
    FrameReordered,
    Pause,
    Stall,
    Warning,
    FrameDamaged,
    LinkNoise,
}

impl FaultKind {
    /// Name in the options file.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::DriveFault => "drive_fault",
            FaultKind::EncoderJump => "encoder_jump",
            FaultKind::EncoderFrozen => "encoder_frozen",
            FaultKind::EncoderDrift => "encoder_drift",
            FaultKind::ModeChange => "mode_change",
            FaultKind::ControlIgnored => "control_ignored",
            FaultKind::StatusFrozen => "status_frozen",
            FaultKind::Sto => "sto",
            FaultKind::Push => "push",
            FaultKind::Jam => "jam",
            FaultKind::TorqueFrozen => "torque_frozen",
            FaultKind::SafeOp => "safe_op",
            FaultKind::WkcShort => "wkc_short",
            FaultKind::CableCut => "cable_cut",
            FaultKind::FrameLost => "frame_lost",
            FaultKind::FrameDuplicated => "frame_duplicated",
            FaultKind::FrameDelayed => "frame_delayed",
            FaultKind::FrameReordered => "frame_reordered",
            FaultKind::Pause => "pause",
            FaultKind::Stall => "stall",
            FaultKind::Warning => "warning",
            FaultKind::FrameDamaged => "frame_damaged",
            FaultKind::LinkNoise => "link_noise",
        }
    }

    fn default_count(self) -> u64 {
        match self {
            FaultKind::EncoderJump
            | FaultKind::EncoderFrozen
            | FaultKind::EncoderDrift
            | FaultKind::ControlIgnored
            | FaultKind::StatusFrozen
            | FaultKind::Sto
            | FaultKind::Jam
            | FaultKind::TorqueFrozen
            | FaultKind::CableCut => 0,
            _ => 1,
        }
    }

    /// It concerns frames on the cable, or what a device does with them.
    fn of_frames(self) -> bool {
        matches!(
            self,
            FaultKind::FrameLost
                | FaultKind::WkcShort
                | FaultKind::FrameDuplicated
                | FaultKind::FrameDelayed
                | FaultKind::FrameReordered
        )
    }
}

/// What `cycle` of a fault counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Counting {
    /// Cycles since all drives were enabled.
    #[default]
    Cycles,
    /// Process-data frames since power-up.
    Frames,
    /// Frames of any kind since power-up.
    AnyFrames,
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
    /// Port of the device at which a frame is damaged or noise arrives: 0 (IN) or 1 (OUT).
    #[serde(default)]
    pub port: u16,
    /// Error code of a drive fault, AL status code of safe_op.
    pub code: Option<u16>,
    /// Only the first `burst` cycles of every `every` ones.
    #[serde(default = "Fault::default_burst")]
    pub burst: u64,
    #[serde(default = "Fault::default_burst")]
    pub every: u64,
    #[serde(default)]
    pub counting: Counting,
    /// Counts of an encoder jump, counts a cycle of a drift; mode of a change of mode; mN m of a push.
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
    fn default_burst() -> u64 {
        1
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
        if self.burst == 0 || self.every < self.burst {
            let (burst, every) = (self.burst, self.every);
            return wrong(format!("burst = {burst}, every = {every}, allowed 1 <= burst <= every"));
        }
        if self.counting == Counting::Frames && !self.kind.of_frames() {
            return wrong(
                "counting = \"frames\" is for frames that are lost, short, doubled or late".into(),
            );
        }
        if self.counting == Counting::AnyFrames && self.kind != FaultKind::Pause {
            return wrong("counting = \"any_frames\" is for a pause".into());
        }
        if self.port > 1 {
            return wrong(format!("port = {}, allowed 0 (IN) and 1 (OUT)", self.port));
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
            && (cycle - self.cycle) % self.every < self.burst
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
#[path = "faults_tests.rs"]
mod tests;
