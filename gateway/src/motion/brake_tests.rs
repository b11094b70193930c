//! Brakes of landings.

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
    let times = within(&theta, &rate, &STROKE, (STEP, USUAL), STEP);
    // 0.02 rad at half the first rate
    let wanted = [0.1, 0.1, 0.04, 0.05, 0.1, STEP];
    // or a cycle sooner: what is left is not exact
    let near = |k: usize| times[k] < wanted[k] + 1e-12 && times[k] > wanted[k] - STEP - 1e-12;
    assert!((0..AXES).all(near), "{times:?}");
    let ends = |k: usize| theta[k] + rate[k] * times[k] / 2.0;
    assert!(
        (0..4).all(|k| ends(k) <= STROKE[k].1 && ends(k) >= STROKE[k].0 || k == 0),
        "{times:?}"
    );
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
