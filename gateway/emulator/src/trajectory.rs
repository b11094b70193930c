//! Digest of all plant cycles, and on request a CSV file in the form of a measured log.
use crate::error::Error;
use crate::plant::AXES;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

pub struct Trajectory {
    digest: u64,
    dt: f64,
    file: Option<(PathBuf, BufWriter<File>)>,
    line: String,
}

/// FNV-1a, 64 bits.
const OFFSET: u64 = 0xCBF2_9CE4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01B3;

impl Trajectory {
    pub fn new(dt: f64, path: Option<&Path>) -> Result<Trajectory, Error> {
        let mut trajectory = Trajectory { digest: OFFSET, dt, file: None, line: String::new() };
        if let Some(path) = path {
            let file = File::create(path)
                .map_err(|error| Error::new(format!("{}: {error}", path.display())))?;
            trajectory.file = Some((path.to_path_buf(), BufWriter::new(file)));
            trajectory.head()?;
        }
        Ok(trajectory)
    }

    fn head(&mut self) -> Result<(), Error> {
        let (mut names, mut units) = (String::from("time"), String::from("s"));
        for (name, unit) in [("theta", "rad"), ("tau_meas", "N m"), ("tau", "N m")] {
            for axis in 1..=AXES {
                let _ = write!(names, ",{name}[{axis}]");
                let _ = write!(units, ",{unit}");
            }
        }
        self.line = format!("{names}\n{units}\n");
        self.write()
    }

    /// Cycle n: the measurements at n and the torque of the step from n to n + 1.
    pub fn note(
        &mut self,
        cycle: u64,
        theta: &[f64; AXES],
        tau_meas: &[f64; AXES],
        tau: &[f64; AXES],
    ) -> Result<(), Error> {
        let values = || theta.iter().chain(tau_meas).chain(tau);
        for byte in values().flat_map(|value| value.to_bits().to_le_bytes()) {
            self.digest = (self.digest ^ u64::from(byte)).wrapping_mul(PRIME);
        }
        if self.file.is_none() {
            return Ok(());
        }
        self.line.clear();
        // whole numbers of steps, so that 0.25 ms come out as 0.00025 and no longer
        let _ = write!(self.line, "{}", cycle as f64 / (1.0 / self.dt).round());
        for value in values() {
            let _ = write!(self.line, ",{value}");
        }
        self.line.push('\n');
        self.write()
    }

    fn write(&mut self) -> Result<(), Error> {
        if let Some((path, file)) = &mut self.file {
            file.write_all(self.line.as_bytes())
                .map_err(|error| Error::new(format!("{}: {error}", path.display())))?;
        }
        Ok(())
    }

    /// The digest so far; the file is complete on disk.
    pub fn finish(&mut self) -> Result<u64, Error> {
        if let Some((path, file)) = &mut self.file {
            file.flush().map_err(|error| Error::new(format!("{}: {error}", path.display())))?;
        }
        Ok(self.digest)
    }
}
