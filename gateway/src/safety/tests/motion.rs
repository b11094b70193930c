//! Rules on angle, speed and following error.

use super::{after_rest, config, next_up, safety, Cycle, COMPLETE, TS};
use crate::config::AXES;
use crate::rules::Reason;
use crate::safety::{Bounds, Safety};

#[test]
fn a_jump_is_told_by_its_size_and_not_as_speed() {
    let over = next_up(0.001);
    assert_eq!(after_rest(|c| c.theta[5] = -over), Some((Reason::Jump, Some(5), -over, 0.001)));
    assert_eq!(after_rest(|c| c.theta[5] = 0.001), None);
}

#[test]
fn a_jump_may_be_larger_after_cycles_without_a_reply() {
    for (moved, wanted) in [(0.0029, None), (0.0031, Some(Reason::Jump))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        cycle.judged(&mut safety);
        cycle.answered = false;
        assert_eq!(cycle.judged(&mut safety), None);
        assert_eq!(cycle.judged(&mut safety), None);
        cycle.answered = true;
        cycle.theta[0] = moved;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted, "{moved}");
    }
}

#[test]
fn cycles_that_were_left_out_allow_more_motion_once() {
    for (moved, wanted) in [(0.0049, None), (0.0051, Some(Reason::Jump))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        for _ in 0..20 {
            assert_eq!(cycle.judged(&mut safety), None);
        }
        cycle.skipped = 4;
        cycle.theta[0] = moved;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted, "{moved}");
        cycle.skipped = 0;
        cycle.theta[0] += 0.0011;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), Some(Reason::Jump));
    }
}

/// 16 skipped cycles, then one without a reply: its angle is from before the gap.
#[test]
fn an_angle_from_before_a_gap_makes_no_speed() {
    for (speed, wanted) in [(1.0, None), (3.01, Some((Reason::Speed, 38)))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut trip = None;
        for n in 0..60 {
            let time = n + if n < 29 { 0 } else { 16 };
            cycle.n = n;
            (cycle.skipped, cycle.answered) = (if n == 29 { 16 } else { 0 }, n != 29);
            if cycle.answered {
                // slow until the gap: what is found is found after it
                let after = (time - 46).max(0) as f64;
                cycle.theta[3] = TS * (time.min(46) as f64 + speed * after);
            }
            trip = trip.or(cycle.judged(&mut safety));
        }
        assert_eq!(trip.map(|t| (t.reason, t.cycle)), wanted, "{speed}");
    }
}

#[test]
fn speed_is_the_mean_over_its_cycles() {
    for (speed, wanted) in [(2.99, None), (3.01, Some((Reason::Speed, 8)))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut trip = None;
        for n in 0..40 {
            cycle.n = n;
            cycle.theta[3] = speed * TS * n as f64;
            trip = trip.or(cycle.judged(&mut safety));
        }
        assert_eq!(trip.map(|t| (t.reason, t.cycle)), wanted, "{speed}");
    }
}

#[test]
fn position_trips_at_either_end() {
    for (theta, limit) in [(0.52, None), (-0.52, None), (0.521, Some(0.52)), (-0.521, Some(-0.52))]
    {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        cycle.theta[0] = theta;
        let trip = cycle.judged(&mut safety);
        assert_eq!(trip.map(|t| t.limit), limit, "{theta}");
        assert!(trip.is_none_or(|t| t.reason == Reason::Position));
    }
}

#[test]
fn following_error_trips_only_with_power() {
    let over = next_up(0.05);
    assert_eq!(after_rest(|c| c.e[4] = 0.05), None);
    assert_eq!(after_rest(|c| c.e[4] = over), Some((Reason::FollowingError, Some(4), over, 0.05)));
    let mut safety = Safety::new(&config(), TS, COMPLETE, false);
    let mut cycle = Cycle::rest();
    cycle.e[4] = 1.0;
    cycle.statusword = [0x0250; AXES];
    assert_eq!(cycle.judged(&mut safety), None);
}

#[test]
fn a_frozen_encoder_needs_time_and_motion() {
    // 12 cycles with the same counts, and more than 0.0003 rad of reference
    for (motion, wanted) in [(0.00029, None), (0.00031, Some(12)), (0.1, Some(12))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut trip = None;
        for n in 0..60 {
            cycle.n = n;
            cycle.r[1] = motion * (n as f64 / 10.0).min(1.0);
            trip = trip.or(cycle.judged(&mut safety));
        }
        assert_eq!(trip.map(|t| t.cycle), wanted, "{motion}");
        assert!(trip.is_none_or(|t| t.reason == Reason::FrozenEncoder && t.axis == Some(1)));
    }
}

#[test]
fn counts_that_never_change_are_frozen_whatever_the_reference_does() {
    for (changes, wanted) in [(false, Some(400)), (true, None)] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut trip = None;
        for n in 0..900 {
            cycle.n = n;
            // a live encoder shows another count now and then
            cycle.theta = [1e-9 * (n / 30) as f64; AXES];
            cycle.theta[4] = if changes { cycle.theta[4] } else { 0.0 };
            trip = trip.or(cycle.judged(&mut safety));
        }
        assert_eq!(
            trip.map(|t| (t.reason, t.axis, t.cycle)),
            wanted.map(|n| (Reason::FrozenEncoder, Some(4), n))
        );
    }
}

#[test]
fn a_blind_axis_is_not_judged_by_its_encoder_and_the_others_are() {
    for (axis, wanted) in [(2, None), (3, Some(Reason::Jump))] {
        let mut safety = safety();
        let blind = std::array::from_fn(|k| k == 2);
        safety.enter(Bounds { blind, ..Bounds::of(&config(), true) });
        let mut cycle = Cycle::rest();
        cycle.judged(&mut safety);
        (cycle.theta[axis], cycle.e[axis]) = (0.7, 0.7);
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted);
    }
}

#[test]
fn a_landing_may_begin_fast_and_outside_and_keeps_its_own_limits() {
    let bounds = Bounds::of(&config(), true).slower(1.0);
    assert_eq!((bounds.speed[0], bounds.low[0], bounds.high[0]), (1.0, -0.52, 0.52));
    let mut pose = [0.0; AXES];
    pose[1] = 0.6;
    let wide = bounds.wider(&[0.0, 3.0, 0.5, 0.0, 0.0, 0.0], &[pose], 0.05);
    assert_eq!(wide.speed, [1.0, 3.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!((wide.high[1], wide.high[0], wide.low[1]), (0.6 + 0.05, 0.52, -0.52));
}

#[test]
fn an_encoder_that_moves_now_and_then_is_not_frozen() {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    for n in 0..400 {
        cycle.n = n;
        cycle.r[1] = 1e-4 * n as f64;
        cycle.theta[1] = 1e-9 * (n / 11) as f64;
        assert_eq!(cycle.judged(&mut safety), None, "{n}");
    }
}

/// A computer that leaves out one cycle in eight has a speed rule all the same.
#[test]
fn a_speed_is_judged_although_cycles_are_skipped_again_and_again() {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    let mut trip = None;
    for n in 0..200 {
        cycle.skipped = u64::from(n % 8 == 7);
        for theta in &mut cycle.theta {
            *theta += 3.2 * TS * (1 + cycle.skipped) as f64;
        }
        // the reference moves along, and no angle leaves its limits
        if n % 16 == 0 {
            cycle.theta = [0.0; AXES];
            safety.note_rest(&[f64::NAN; AXES]);
        }
        trip = trip.or(cycle.judged(&mut safety).filter(|t| t.reason == Reason::Speed));
    }
    assert!(trip.is_some());
}
