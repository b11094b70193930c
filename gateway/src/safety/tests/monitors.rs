//! Rules on the change of torques, on what the drives measure, and on what the feedback adds.

use super::{config, next_up, Cycle, COMPLETE, TS};
use crate::config::{parse, PoseLimit, AXES};
use crate::rules::{Reason, Trip};
use crate::safety::{Bounds, Safety};

fn safety(powered: bool) -> Safety {
    let mut config = parse(include_str!("../../../machines/akd.toml")).unwrap();
    // others judge a machine whose encoders stand still
    config.safety.frozen_still_cycles = 0;
    Safety::new(&config, TS, COMPLETE, powered)
}

/// The first trip of cycles that `bend` changes, by their number.
fn first(cycles: i64, bend: impl Fn(i64, &mut Cycle)) -> Option<Trip> {
    let mut safety = safety(true);
    (0..cycles).find_map(|n| {
        let mut cycle = Cycle { n, ..Cycle::rest() };
        bend(n, &mut cycle);
        cycle.judged(&mut safety)
    })
}

fn seen(trip: Option<Trip>) -> Option<(Reason, Option<usize>, i64)> {
    trip.map(|t| (t.reason, t.axis, t.cycle))
}

#[test]
fn a_torque_that_steps_is_stopped_before_it_is_sent() {
    let step = |size: f64| {
        first(40, move |n, c| {
            c.tau[2] = if n < 20 { 0.5 } else { 0.5 + size };
            c.tau_meas[2] = 0.5;
        })
    };
    assert_eq!(seen(step(2.0)), None, "the limit itself is allowed");
    let trip = step(-2.001).unwrap();
    assert_eq!((trip.reason, trip.axis, trip.cycle), (Reason::TorqueStep, Some(2), 20));
    assert!((trip.value + 2.001).abs() < 1e-12 && trip.limit == 2.0, "{trip}");
}

#[test]
fn a_torque_may_change_more_over_cycles_that_were_skipped() {
    for (skipped, wanted) in [(0, true), (1, true), (2, false)] {
        let trip = first(10, |n, c| {
            (c.tau[0], c.skipped) =
                (if n < 5 { 0.0 } else { 5.0 }, if n == 5 { skipped } else { 0 });
            c.tau_meas[0] = c.tau[0];
        });
        assert_eq!(trip.map(|t| t.reason), wanted.then_some(Reason::TorqueStep), "{skipped}");
    }
}

#[test]
fn a_new_phase_may_begin_at_another_torque() {
    let mut safety = safety(true);
    let mut cycle = Cycle::rest();
    assert_eq!(cycle.judged(&mut safety), None);
    safety.enter(*safety.bounds());
    cycle.tau = [6.0; AXES];
    assert_eq!(cycle.judged(&mut safety), None);
    // the controller goes on from what the lift-off sent
    for (sent, wanted) in [(4.0, None), (3.9, Some(Reason::TorqueStep))] {
        safety.begin(*safety.bounds(), [sent; AXES]);
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted);
    }
}

#[test]
fn a_drive_that_gives_another_torque_is_told_within_its_time() {
    // commanded 0.002 N m more each cycle; the drive stays where it was
    let trip = |measured: fn(i64) -> f64| {
        first(800, move |n, c| {
            c.tau[4] = 0.002 * n as f64;
            c.tau_meas[4] = measured(n);
        })
    };
    // the frame of cycle n carries what was judged in n - 1, and shows in cycle n + 1
    assert_eq!(seen(trip(|n| 0.002 * (n - 2) as f64)), None);
    assert_eq!(seen(trip(|n| 0.002 * (n - 2) as f64 + 0.9)), None);
    let stuck = trip(|_| 0.0).unwrap();
    assert_eq!((stuck.reason, stuck.axis), (Reason::MeasuredTorque, Some(4)));
    // the difference is 1 N m in cycle 502, and its mean over 10 ms 40 cycles later
    assert!((535..550).contains(&stuck.cycle), "{stuck}");
}

#[test]
fn a_measured_torque_of_an_incomplete_reply_is_not_judged() {
    let trip = first(400, |n, c| {
        c.tau_meas[1] = if n % 5 == 0 { 20.0 } else { 0.0 };
        c.answered = n % 5 != 0;
    });
    assert_eq!(seen(trip), None);
}

#[test]
fn a_feedback_that_carries_the_machine_alone_is_told() {
    for (carried, wanted) in [(0.59, None), (0.7, Some(Reason::FeedbackTorque))] {
        let trip = first(12_000, |_, c| {
            let mut feedback = [0.0; AXES];
            feedback[5] = -carried;
            c.feedback = Some(feedback);
        });
        assert_eq!(trip.map(|t| t.reason), wanted, "{carried}");
        // 0.7 (1 - exp(-t / 1 s)) = 0.6 at 1.946 s
        assert!(trip.is_none_or(|t| (7775..7795).contains(&t.cycle)), "{trip:?}");
    }
    // a swing of the same size is none
    let swing = first(4000, |n, c| c.feedback = Some([(0.05 * n as f64).sin() * 3.0; AXES]));
    assert_eq!(seen(swing), None);
}

#[test]
fn nothing_of_it_is_judged_without_power() {
    let mut safety = safety(false);
    let mut cycle = Cycle::rest();
    for n in 0..2000 {
        cycle.tau = [if n % 2 == 0 { 9.0 } else { -9.0 }; AXES];
        cycle.feedback = Some(cycle.tau);
        assert_eq!(cycle.judged(&mut safety), None);
    }
}

/// Property: whatever finite torques are wanted, the ones that pass change by no more than the limit.
#[test]
fn no_sequence_of_torques_that_passes_has_a_larger_step() {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..200 {
        let mut safety = safety(true);
        let size = 8.0 * random();
        let mut last: Option<[f64; AXES]> = None;
        for n in 0..200 {
            let tau: [f64; AXES] = std::array::from_fn(|_| size * (random() - 0.5));
            let cycle = Cycle { n, tau, tau_meas: last.unwrap_or(tau), ..Cycle::rest() };
            let stepped = last.is_some_and(|l| (0..AXES).any(|k| (tau[k] - l[k]).abs() > 2.0));
            match cycle.judged(&mut safety) {
                None => assert!(!stepped),
                Some(trip) if trip.reason == Reason::TorqueStep => {
                    assert!(stepped);
                    break;
                }
                Some(_) => break,
            }
            last = Some(tau);
        }
    }
}

#[test]
fn a_lift_off_allows_less_error_than_a_run() {
    let mut safety = safety(true);
    let mut cycle = Cycle::rest();
    cycle.e[1] = 0.011;
    assert_eq!(cycle.judged(&mut safety), None);
    let bounds: Bounds = *safety.bounds();
    safety.enter(bounds.closer(0.01));
    let trip = cycle.judged(&mut safety).unwrap();
    assert_eq!((trip.reason, trip.limit), (Reason::FollowingError, 0.01));
}

#[test]
fn a_motor_bears_its_rated_torque_for_ever_and_more_for_a_while() {
    // the mean square of a step is 1 - exp(-t / T) of its end, T = 10 s; drives measure what they were sent
    let loaded = |tau: f64| first(400_000, move |_, c| (c.tau[1], c.tau_meas[1]) = (tau, tau));
    assert_eq!(seen(loaded(9.0)), None);
    let trip = loaded(12.0).unwrap();
    assert_eq!((trip.reason, trip.axis, trip.limit), (Reason::Thermal, Some(1), 9.0));
    let wanted = -10.0 * (1.0 - (9.0f64 / 12.0).powi(2)).ln() / TS;
    assert!((trip.cycle as f64 - wanted).abs() < 10.0, "{trip} {wanted}");
    let unanswered = first(60_000, |n, c| {
        (c.tau[1], c.tau_meas[1], c.answered) = (12.0, 12.0, n % 5 != 4);
    });
    assert!(unanswered.unwrap().cycle > trip.cycle, "what is not measured is not counted");
}

#[test]
fn a_pose_trips_on_either_side_of_its_limits_and_only_in_a_run() {
    let mut config = parse(include_str!("../../../machines/akd.toml")).unwrap();
    let limit = |min, max| PoseLimit { signal: String::new(), min, max };
    config.pose = vec![limit(0.25, 0.35), limit(-0.1, 0.1)];
    let judged = |pose: [f64; 2]| {
        let mut safety = Safety::new(&config, TS, COMPLETE, true);
        let trip = Cycle { pose, ..Cycle::rest() }.judged(&mut safety);
        trip.map(|t| (t.reason, t.value, t.limit))
    };
    assert_eq!(judged([0.25, 0.1]), None);
    assert_eq!(judged([0.35, -0.1]), None);
    assert_eq!(judged([0.2499, 0.0]), Some((Reason::Pose, 0.2499, 0.25)));
    assert_eq!(judged([0.3, 0.1001]), Some((Reason::Pose, 0.1001, 0.1)));
    assert!(judged([0.3, f64::NAN]).is_some_and(|t| t.0 == Reason::Pose));
}

#[test]
fn a_singular_pose_trips_above_its_gain_where_the_machine_has_power() {
    let judged = |gain: Option<f64>, powered: bool| {
        let mut safety = Safety::new(&config(), TS, COMPLETE, powered);
        let trip = Cycle { gain, ..Cycle::rest() }.judged(&mut safety);
        trip.map(|t| (t.reason, t.axis, t.value, t.limit))
    };
    assert_eq!(judged(None, true), None);
    assert_eq!(judged(Some(2.0), true), None);
    let above = next_up(2.0);
    assert_eq!(judged(Some(above), true), Some((Reason::Singular, None, above, 2.0)));
    for gain in [f64::INFINITY, f64::NAN] {
        assert!(judged(Some(gain), true).is_some_and(|t| t.0 == Reason::Singular), "{gain}");
    }
    assert_eq!(judged(Some(f64::INFINITY), false), None, "moved by hand in a dry run");
}
