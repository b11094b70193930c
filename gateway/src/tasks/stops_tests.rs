use super::*;

const H: f64 = 0.00025;
/// Of every leg.
const CYCLES: u32 = 20_000;
const SEARCH: Search = Search { torque: 1.0, speed: 0.05, within: 0.6, side: -1.0, base_step: H };

/// An axis that follows its leg until its stop.
struct Axis {
    theta: Axes,
    at: Axes,
    r: Axes,
    left: u32,
    leg: Leg,
}

impl Axis {
    fn step(&mut self) {
        let cycles = CYCLES;
        self.left = self.left.saturating_sub(1);
        let share = 1.0 - f64::from(self.left) / f64::from(cycles);
        for k in 0..AXES {
            let wanted = self.leg.from[k] + share * (self.leg.to[k] - self.leg.from[k]);
            self.r[k] = wanted;
            self.theta[k] = wanted.max(self.at[k]);
        }
    }

    fn go(&mut self, leg: Leg) {
        (self.leg, self.left) = (leg, CYCLES);
    }
}

/// Runs the search against these stops; `shift`: moves the stop of axis 3 after its first pass.
fn searched(at: Axes, shift: f64) -> (Step, Stops) {
    let mut stops = Stops::new(SEARCH);
    let rest = [0.0; AXES];
    let first = stops.begin(&rest);
    let mut axis = Axis { theta: rest, at, r: rest, left: CYCLES, leg: first };
    for _ in 0..2_000_000 {
        if axis.left > 0 {
            axis.step();
        }
        let (left, tau) = (axis.left, [0.0; AXES]);
        let seen = Seen { complete: true, theta: &axis.theta, tau_meas: &tau, r: &axis.r, left };
        let (pass, k) = (stops.pass, stops.axis);
        match stops.step(&seen) {
            Step::Go(leg) => axis.go(leg),
            Step::Stay => {}
            end => return (end, stops),
        }
        if (pass, stops.pass, k) == (0, 1, 2) {
            axis.at[2] += shift;
        }
    }
    panic!("it never ends");
}

#[test]
fn stops_are_found_in_two_passes_of_every_axis() {
    let at = [-0.1, -0.15, -0.2, -0.02, -0.3, -0.18];
    let (end, stops) = searched(at, 0.0);
    assert_eq!(end, Step::Over);
    assert_eq!(stops.angles(), at);
    assert_eq!(stops.spread(), [0.0; AXES]);
}

#[test]
fn what_does_not_repeat_or_is_not_there_is_refused() {
    let at = [-0.1; AXES];
    let (end, _) = searched(at, 9e-4);
    assert_eq!(end, Step::Over);
    let (end, _) = searched(at, 1.1e-3);
    let Step::Fail(why) = end else { panic!("{end:?}") };
    let why = why.to_string();
    assert!(why.contains("axis 3: the end stop was met at -0.10000 and at -0.09890 rad"), "{why}");
    let far = [-0.1, -0.7, -0.1, -0.1, -0.1, -0.1];
    let Step::Fail(why) = searched(far, 0.0).0 else { panic!() };
    let why = why.to_string();
    assert!(why.contains("axis 2: no end stop within 0.6 rad"), "{why}");
}

#[test]
fn an_axis_that_does_not_come_away_is_blocked() {
    let at = [-0.1, -0.1, 0.02999, -0.1, -0.1, -0.1];
    let Step::Fail(why) = searched(at, 0.0).0 else { panic!() };
    let why = why.to_string();
    assert!(why.contains("axis 3: its encoder stands still"), "{why}");
}
