//! How soon each axis stands: in the time of a brake, or sooner where that would end outside its limits.

use flexhex_system::Motion;

use crate::config::AXES;

type Axes = [f64; AXES];

/// Largest deceleration of a brake over its mean one.
const PEAK: f64 = 1.5;

/// Cycles of a brake whose torque grows to `most` by half of the `steps` [N m] that are allowed in a cycle, as the
/// feedback adds its own: it grows as 4 (s - s^2). A step of 0 is not judged.
pub fn shortest(most: f64, steps: &Axes) -> f64 {
    let judged = steps.iter().filter(|step| **step > 0.0);
    judged.fold(1.0, |cycles: f64, step| cycles.max(8.0 * most / step))
}

/// Times [s] in which axes at `theta` [rad] with `rate` [rad/s] come to rest within `limits` [rad], between
/// the `shortest` and the `longest` time: a brake has half of its first rate on average.
pub fn within(
    theta: &Axes,
    rate: &Axes,
    limits: &[(f64, f64); AXES],
    (shortest, longest): (f64, f64),
) -> Axes {
    std::array::from_fn(|k| {
        let ((low, high), rate) = (limits[k], rate[k]);
        let left = if rate < 0.0 { low - theta[k] } else { high - theta[k] };
        if rate == 0.0 {
            return longest;
        }
        (2.0 * left / rate).max(shortest).min(longest)
    })
}

/// The largest decelerations of brakes that take so many seconds, half-way, where the rates are half of the first.
pub fn hardest(theta: &Axes, rate: &Axes, times: &Axes) -> Motion {
    Motion {
        theta: *theta,
        thetad: rate.map(|rate| rate / 2.0),
        thetadd: std::array::from_fn(|k| -PEAK * rate[k] / times[k]),
    }
}

/// Times from `usual` down to `soon` [s] in which no torque is above `most` [N m]. Torques are affine in the
/// accelerations, so the `torques` of the one and the other say how far it can go.
pub fn affordable(usual: f64, soon: &Axes, torques: [&Axes; 2], most: f64) -> Axes {
    let share = (0..AXES).fold(1.0, |share: f64, k| {
        let (begin, more) = (torques[0][k], torques[1][k] - torques[0][k]);
        let room = if more < 0.0 { most + begin } else { most - begin };
        share.min((room / more.abs()).max(0.0))
    });
    // accelerations go as the inverse of the time
    let longer = |time: f64| time * (1.0 - share) / (time + share * (usual - time));
    soon.map(|time| time + (usual - time) * longer(time))
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: f64 = 0.1;
    const STEP: f64 = 2.5e-4;
    const STROKE: [(f64, f64); AXES] = [(-0.52, 0.52); AXES];

    #[test]
    fn a_torque_grows_by_no_more_than_half_of_its_step() {
        let (most, step) = (6.0, 2.0);
        let cycles = shortest(most, &[step, 0.0, 3.0, step, step, step]);
        let torque = |k: f64| most * 4.0 * (k / cycles) * (1.0 - k / cycles);
        assert!(torque(1.0) < step / 2.0 && torque(2.0) > step / 2.0, "{cycles}");
        assert_eq!(shortest(most, &[0.0; AXES]), 1.0);
    }

    #[test]
    fn an_axis_brakes_sooner_only_where_it_would_leave_its_limits() {
        let theta = [0.0, 0.5, 0.5, -0.5, 0.52, 0.53];
        let rate = [3.0, -1.0, 1.0, -0.8, 0.0, 1e-6];
        let times = within(&theta, &rate, &STROKE, (STEP, USUAL));
        // 0.02 rad at half the first rate
        let wanted = [0.1, 0.1, 0.04, 0.05, 0.1, STEP];
        assert!((0..AXES).all(|k| (times[k] - wanted[k]).abs() < 1e-12), "{times:?}");
    }

    /// Axes of 0.1 kg m2 that carry 1 N m.
    fn torques(rate: &Axes, times: &Axes) -> Axes {
        hardest(&[0.0; AXES], rate, times).thetadd.map(|thetadd| 1.0 + 0.1 * thetadd)
    }

    #[test]
    fn no_brake_is_shorter_than_the_torque_allows_nor_longer_than_it_must_be() {
        let rate = [1.0, -1.0, 0.0, 0.0, 0.0, 0.0];
        for (soon, most, wanted) in [
            (0.05, 6.0, 0.05),
            // 1.5 / 0.025 rad/s2 are the 7 N m upwards, of which 1 is carried: 5 leave 0.03 s
            (0.025, 6.0, 0.03),
            (STEP, 6.0, 0.03),
            // the weight and the usual brake are all
            (0.05, 2.5, 0.1),
            (0.05, 2.0, 0.1),
        ] {
            let mut times = [USUAL; AXES];
            times[1] = soon;
            let at = [&torques(&rate, &[USUAL; AXES]), &torques(&rate, &times)];
            let affordable = affordable(USUAL, &times, at, most);
            assert!((affordable[1] - wanted).abs() < 1e-12, "{soon} s, {most} N m: {affordable:?}");
            assert_eq!(affordable[0], USUAL);
        }
    }
}
