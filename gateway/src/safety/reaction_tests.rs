use super::{disabled, in_landing, of_motion, Disabling, InLanding};
use crate::config::AXES;
use crate::rules::{ReactionKind, Reactions, Reason, Trip};

const OFF: [u16; AXES] = [0x0250; AXES];
const ON: [u16; AXES] = [0x0237; AXES];

#[test]
fn controlwords_follow_the_kind_of_stop() {
    for (kind, word) in [
        (ReactionKind::QuickStop, 0x02),
        (ReactionKind::Zero, 0x00),
        (ReactionKind::Damp, 0x00),
        (ReactionKind::Land, 0x06),
    ] {
        let mut disabling = Disabling::new(kind);
        let words: Vec<_> = (0..300).map(|_| disabling.next()).collect();
        assert_eq!((words[0], words[299]), (word, 0x00));
    }
}

#[test]
fn drives_that_keep_their_power_end_it_in_time() {
    let mut disabling = Disabling::new(ReactionKind::QuickStop);
    let n = (0..1000).take_while(|_| {
        disabling.next();
        !disabling.over(&[false; AXES])
    });
    assert_eq!(n.count(), 400);
}

#[test]
fn disabled_is_what_a_reply_of_this_drive_says() {
    let op = [8; AXES];
    assert_eq!(disabled(&OFF, &op, (true, 18)), [true; AXES]);
    assert_eq!(disabled(&ON, &op, (true, 18)), [false; AXES]);
    assert_eq!(disabled(&OFF, &op, (false, 18)), [false; AXES], "an old reply");
    assert_eq!(disabled(&OFF, &op, (true, 15)), [false; AXES], "one did not take part");
    let mut one = OFF;
    one[2] = 0x0237;
    assert_eq!(disabled(&one, &op, (true, 18)), [true, true, false, true, true, true]);
    // cut between 3 and 4: the counter is that of three, and AL states say which
    let cut = [8, 8, 8, 0, 0, 0];
    assert_eq!(disabled(&OFF, &cut, (true, 9)), [true, true, true, false, false, false]);
    // a drive with a fault has no power
    assert_eq!(disabled(&[0x0218; AXES], &op, (true, 18)), [true; AXES]);
}

#[test]
fn a_landing_goes_on_only_while_five_axes_are_sound() {
    use ReactionKind::{Damp, Land, QuickStop, Zero};
    let reasons =
        [Reason::Jump, Reason::Speed, Reason::Overrun, Reason::Singular, Reason::DriveFault];
    for reason in reasons {
        let goes_on = matches!(reason, Reason::Overrun | Reason::Singular);
        for kind in [Land, Damp, QuickStop, Zero] {
            for axis in [None, Some(0), Some(5)] {
                for first in [None, Some(2)] {
                    let mut blind = [false; AXES];
                    first.into_iter().for_each(|k: usize| blind[k] = true);
                    let trip = Trip::of(reason, axis, 1.0, 0.0, 7);
                    let reaction = in_landing(&trip, kind, &blind);
                    match reaction {
                        InLanding::GoOn => assert!(goes_on && kind.lands()),
                        InLanding::Blind(k) => {
                            assert_eq!((Some(k), kind, first), (axis, Damp, None));
                        }
                        InLanding::TakePower(stop) => {
                            assert!(!stop.lands(), "{reason:?} {kind:?}");
                            assert!(kind.lands() || stop == kind, "as configured");
                        }
                    }
                }
            }
        }
    }
    let late = Trip::of(Reason::Overrun, None, 3000.0, 2000.0, 7);
    assert_eq!(in_landing(&late, Land, &[false; AXES]), InLanding::GoOn);
    assert_eq!(in_landing(&late, Zero, &[false; AXES]), InLanding::TakePower(Zero));
}

#[test]
fn an_axis_that_leaves_the_path_of_a_lift_off_is_not_landed_by_its_own_feedback() {
    use ReactionKind::{Damp, Land, QuickStop, Zero};
    let stop = |reason, axis, kind| {
        let mut reactions = Reactions { frozen_encoder: Damp, ..Reactions::default() };
        (reactions.speed, reactions.following_error, reactions.position) = (kind, kind, kind);
        of_motion(&Trip::of(reason, axis, 1.0, 0.0, -7), &reactions)
    };
    for reason in [Reason::Speed, Reason::FollowingError, Reason::Position] {
        assert_eq!(stop(reason, Some(2), Land), Damp, "as an encoder that is frozen");
        assert_eq!(stop(reason, None, Land), Land);
        for kind in [Damp, QuickStop, Zero] {
            assert_eq!(stop(reason, Some(2), kind), kind, "as configured");
        }
    }
    assert_eq!(stop(Reason::Overrun, None, Zero), Land);
    assert_eq!(stop(Reason::Torque, Some(1), Zero), Land);
}
