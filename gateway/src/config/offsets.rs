//! Takes the offsets of the encoders from the homing file into the configuration.

use super::hash::hash;
use super::mistakes::{ConfigError, Mistake};
use super::{Config, Homed};

impl Config {
    /// Takes the offsets of `homing.file`, and expects the drives that they were found with.
    pub fn home(&mut self) -> Result<(), ConfigError> {
        let Some(path) = self.homing.file.clone() else { return Ok(()) };
        let at = |mistake: Mistake| ConfigError::from(mistake).of(&path);
        let mend = "home the machine with `flexhex-gateway home`, or leave homing.file out";
        let text = std::fs::read_to_string(&path);
        let text = text.map_err(|why| at(Mistake::Unreadable(why, mend)))?;
        let homed = Homed::parse(&text).map_err(at)?;
        for (k, (drive, axis)) in self.drive.iter_mut().zip(&homed.axis).enumerate() {
            if let Some(configured) = drive.serial.filter(|serial| *serial != axis.serial) {
                let homed = axis.serial;
                return Err(at(Mistake::OtherDrive { axis: k, homed, configured }));
            }
            (drive.serial, drive.offset_counts) = (Some(axis.serial), axis.offset_counts);
        }
        self.hash ^= hash(&text).rotate_left(1);
        self.homed = Some(homed);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::homing::homed;
    use super::super::parse;

    #[test]
    fn offsets_and_serials_come_from_the_file_and_count_for_the_hash() {
        let folder = std::env::temp_dir().join(format!("flexhex-homing-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("homing.toml");
        std::fs::write(&file, toml::to_string(&homed()).unwrap()).unwrap();
        let mut config = parse(include_str!("../../machines/akd.toml")).unwrap();
        let hash = config.hash;
        config.homing.file = Some(file.clone());
        config.home().unwrap();
        assert_eq!((config.drive[5].offset_counts, config.drive[5].serial), (-42, Some(1006)));
        assert_ne!(config.hash, hash);
        config.drive[2].serial = Some(9);
        let why = config.home().unwrap_err().to_string();
        assert!(why.contains("axis 3: homed with the drive of serial number 1003"), "{why}");
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(config.home().unwrap_err().to_string().contains("flexhex-gateway home"));
    }
}
