//! The latch of an MP and the gate of a robot, event by event.

use super::*;

mod every_order_of_events;

const PRESS: Event = Event::Reset { pressed: true };
const RELEASE: Event = Event::Reset { pressed: false };

/// The latch after events, and what was said of the last one.
fn after(events: &[Event]) -> (Latch, Result<(), LatchRefusal>) {
    let start = (Latching::default(), Ok(()));
    let (latching, said) = events.iter().fold(start, |(latching, _), &event| latching.meet(event));
    (latching.latch, said)
}

#[test]
fn fault_40_a_reset_is_a_rising_edge_after_the_acknowledgement_and_after_the_cause() {
    use Event::{Acknowledge, Cause, Fault, Standstill};
    use LatchRefusal as Why;
    let (persists, is_gone) = (Cause { persists: true }, Cause { persists: false });
    let latched = [Fault, Standstill];
    let then = |events: &[Event]| after(&[&latched, events].concat());
    assert_eq!(then(&[Acknowledge, PRESS]), (Latch::Resetting, Ok(())));
    assert_eq!(then(&[PRESS]), (Latch::Latched, Err(Why::NotAcknowledged)));
    // Pressed before the acknowledgement and held: it has to be let go first.
    assert_eq!(then(&[PRESS, Acknowledge, PRESS]), (Latch::Acknowledged, Err(Why::Held)));
    assert_eq!(then(&[PRESS, Acknowledge, RELEASE, PRESS]), (Latch::Resetting, Ok(())));
    // Held since before the fault.
    assert_eq!(after(&[PRESS, Fault, Standstill, Acknowledge, PRESS]), (Latch::Acknowledged, Err(Why::Held)));
    // Held while the cause persists: that it is gone is no edge.
    assert_eq!(then(&[persists, Acknowledge, PRESS]), (Latch::Acknowledged, Err(Why::CausePersists)));
    assert_eq!(then(&[persists, Acknowledge, PRESS, is_gone]), (Latch::Acknowledged, Ok(())));
    assert_eq!(then(&[persists, Acknowledge, PRESS, is_gone, PRESS]), (Latch::Acknowledged, Err(Why::Held)));
    assert_eq!(then(&[persists, Acknowledge, PRESS, is_gone, RELEASE, PRESS]), (Latch::Resetting, Ok(())));
    // Nothing is made up for: what is asked too early is not remembered.
    assert_eq!(after(&[Fault, Acknowledge]), (Latch::Stopping, Err(Why::Stopping)));
    assert_eq!(after(&[Fault, PRESS]), (Latch::Stopping, Err(Why::Stopping)));
    assert_eq!(after(&[Acknowledge]), (Latch::Clear, Err(Why::NotLatched)));
    assert_eq!(then(&[Acknowledge, PRESS, RELEASE, PRESS]), (Latch::Resetting, Err(Why::Resetting)));
    // A fault in a reset: the acknowledgement was for the one before.
    assert_eq!(then(&[Acknowledge, PRESS, Fault, Standstill]), (Latch::Latched, Ok(())));
    assert_eq!(then(&[Acknowledge, PRESS, Event::Restart]), (Latch::Clear, Ok(())));
    // Only a reset that is under way restarts.
    assert_eq!(then(&[Acknowledge, Event::Restart]), (Latch::Acknowledged, Ok(())));
}

#[test]
fn every_state_travels_in_a_word() {
    let latches = [Latch::Clear, Latch::Stopping, Latch::Latched, Latch::Acknowledged, Latch::Resetting];
    for (latch, levels) in latches.into_iter().flat_map(|latch| (0..4).map(move |levels| (latch, levels))) {
        let latching = Latching { latch, pressed: levels & 1 != 0, persists: levels & 2 != 0 };
        assert_eq!(Latching::from_word(latching.to_word()), latching);
    }
}

#[test]
fn nothing_of_an_earlier_epoch_is_done_and_nothing_moves_behind_a_gate_that_is_shut() {
    use Admission::{Done, Ignored, Refused};
    let open = Gate { epoch: 5, shut: false };
    let shut = open.closed();
    #[rustfmt::skip]
    let table = [
        // gate, epoch: Move     Look     Stop     Reset    Reset while it moves
        (open, 4, [Ignored, Ignored, Ignored, Ignored, Ignored]),
        (shut, 4, [Ignored, Ignored, Ignored, Ignored, Ignored]),
        (open, 5, [Done,    Done,    Done,    Ignored, Ignored]),
        (shut, 5, [Refused, Done,    Done,    Ignored, Ignored]),
        (open, 6, [Ignored, Ignored, Done,    Refused, Refused]),
        (shut, 6, [Ignored, Ignored, Done,    Done,    Refused]),
    ];
    for (gate, epoch, admissions) in table {
        let asked =
            [GateRequest::Move, GateRequest::Look, GateRequest::Stop, GateRequest::Reset, GateRequest::Reset];
        for (i, (asked, admission)) in asked.into_iter().zip(admissions).enumerate() {
            let (next, what) = gate.meet(epoch, asked, i < 4);
            assert_eq!(what, admission, "{asked:?} of epoch {epoch} at {gate:?}");
            let opens = gate.shut && !next.shut;
            assert_eq!(
                opens,
                asked == GateRequest::Reset && what == Done,
                "{asked:?} of epoch {epoch} at {gate:?}"
            );
        }
    }
}
