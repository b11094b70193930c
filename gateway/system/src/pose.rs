//! Poses of the platform.

use std::fmt::{self, Display, Formatter};

/// Position `x_E` [m] of the platform from the base, and its orientation as a rotation vector `phi_E` \[rad\]: axis times
/// angle, as in files of motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub position: [f64; 3],
    pub rotation: [f64; 3],
}

impl Pose {
    /// Of a unit quaternion, scalar first; both signs of it are the same orientation.
    pub(crate) fn of(position: [f64; 3], [scalar, vector @ ..]: [f64; 4]) -> Pose {
        let sine = size(&vector);
        let half = sine.atan2(scalar.abs());
        let over = if sine == 0.0 { 0.0 } else { 2.0 * half / sine };
        Pose { position, rotation: vector.map(|part| scalar.signum() * over * part + 0.0) }
    }

    /// The orientation as a unit quaternion, scalar first.
    pub(crate) fn quaternion(&self) -> [f64; 4] {
        let angle = size(&self.rotation);
        let over = if angle == 0.0 { 0.5 } else { (angle / 2.0).sin() / angle };
        let [x, y, z] = self.rotation.map(|part| over * part);
        [(angle / 2.0).cos(), x, y, z]
    }

    /// A share of the way to another one.
    pub fn towards(&self, to: &Pose, share: f64) -> Pose {
        let part = |from: [f64; 3], to: [f64; 3]| {
            std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
        };
        Pose {
            position: part(self.position, to.position),
            rotation: part(self.rotation, to.rotation),
        }
    }

    /// Largest difference from another one [m, rad].
    pub fn off(&self, other: &Pose) -> f64 {
        let parts = self.position.iter().zip(&other.position);
        let parts = parts.chain(self.rotation.iter().zip(&other.rotation));
        parts.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
    }
}

impl Display for Pose {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "x_E = {:.5?} m, phi_E = {:.5?} rad", self.position, self.rotation)
    }
}

fn size(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_vector_is_axis_times_angle() {
        let pose = Pose { position: [0.0; 3], rotation: [0.0, 1.2, 0.0] };
        let [scalar, x, y, z] = pose.quaternion();
        assert!((scalar - 0.6_f64.cos()).abs() < 1e-15 && (y - 0.6_f64.sin()).abs() < 1e-15);
        assert_eq!((x, z), (0.0, 0.0));
    }

    #[test]
    fn a_pose_comes_back_from_its_quaternion_with_either_sign() {
        for rotation in [[0.0; 3], [0.3, -0.2, 0.1], [-1e-9, 0.0, 2e-9], [0.0, 0.0, -3.0]] {
            let pose = Pose { position: [0.1, 0.2, 0.3], rotation };
            let quaternion = pose.quaternion();
            for quaternion in [quaternion, quaternion.map(|part| -part)] {
                assert!(Pose::of(pose.position, quaternion).off(&pose) < 1e-14, "{rotation:?}");
            }
        }
    }
}
