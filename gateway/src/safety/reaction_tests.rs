use super::Reaction;
use crate::config::AXES;
use crate::rules::ReactionKind;

#[test]
fn a_ramp_fades_the_torque_and_then_takes_the_power() {
    let mut ramp = Reaction::new(ReactionKind::Ramp, [8.0; AXES], 4);
    let steps: Vec<_> =
        (0..5).map(|_| ramp.next(&[0x0237; AXES])).map(|(t, w)| (t[0], w)).collect();
    assert_eq!(steps, [(6.0, 0x0f), (4.0, 0x0f), (2.0, 0x0f), (0.0, 0x06), (0.0, 0x06)]);
    assert!(ramp.over(&[0x0231; AXES]));
    assert!(!ramp.over(&[0x0237; AXES]));
}

#[test]
fn quick_stop_and_zero_give_no_torque_from_the_first_frame() {
    for (kind, word) in [(ReactionKind::QuickStop, 0x02), (ReactionKind::Zero, 0x00)] {
        let mut reaction = Reaction::new(kind, [8.0; AXES], 4);
        assert_eq!(reaction.next(&[0x0237; AXES]), ([0.0; AXES], word));
    }
}

#[test]
fn drives_that_do_not_answer_end_a_reaction_in_time() {
    let mut reaction = Reaction::new(ReactionKind::QuickStop, [0.0; AXES], 0);
    let n = (0..1000).take_while(|_| {
        reaction.next(&[0x0237; AXES]);
        !reaction.over(&[0x0237; AXES])
    });
    assert_eq!(n.count(), 400);
}

#[test]
fn a_ramp_never_leads_a_drive_back_to_power() {
    let mut ramp = Reaction::new(ReactionKind::Ramp, [8.0; AXES], 400);
    assert_eq!(ramp.next(&[0x0237; AXES]).1, 0x0f);
    let mut left = [0x0237; AXES];
    left[3] = 0x0231; // ready to switch on
    assert_eq!(ramp.next(&left), ([0.0; AXES], 0x00));
    assert_eq!(ramp.next(&[0x0237; AXES]), ([0.0; AXES], 0x00));
}
