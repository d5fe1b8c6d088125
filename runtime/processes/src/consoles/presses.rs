//! Presses of buttons on their way to the MP and back.
//!
//! In: buttons that consoles have asked for, and the MP's entry on the state board. Out: one press of each kind at a
//! time to the MP, and its answer to all consoles that wait for it.

use std::io::Write;
use std::time::{Duration, Instant};

use super::console::{Console, PendingRequest};
use super::mp_session::Flight;
use super::service::Service;
use crate::control::Frame;
use mrroc_core::fault::Fault;
use mrroc_core::operator::button::{Button, Pressed};
use mrroc_core::operator::{Answer, CellState};

/// How long a console waits for its press to be carried out.
const TIMEOUT: Duration = Duration::from_secs(1);

/// How long an MP that was told to stop may go on computing before its launcher ends the cell.
pub(crate) const STOPPING: Duration = Duration::from_secs(5);

impl Service {
    /// Answers consoles whose presses were carried out or refused.
    pub(super) fn look_after_presses(&mut self, session: usize) {
        let mp = self.mp(session);
        let over = !self.mp_runs(session);
        for (kind, flight) in self.sessions[session].flights.iter_mut().enumerate() {
            let Some(Flight { number, button, since }) = *flight else { continue };
            let pressed = mp.as_ref().map(|mp| mp.answers[kind]).filter(|pressed| pressed.number == number);
            let persisting = mp.as_ref().and_then(|mp| mp.persisting.as_ref());
            let answer = match pressed {
                Some(pressed) => say(button, pressed, persisting),
                None if over => Answer::Refused("the cell closes".to_owned()),
                None if since.elapsed() > TIMEOUT => Answer::Pending(pending(button)),
                None => continue,
            };
            // A late press may still be carried out, but the next press does not wait for it.
            *flight = None;
            let asked = PendingRequest::Answer(kind, number);
            let waits = |console: &&mut Console| console.asked == asked && console.session == session;
            self.consoles.iter_mut().filter(waits).for_each(|console| console.answer(&answer));
        }
    }

    /// Sends the first waiting button of each kind to the MP, unless a press of that kind is under way.
    pub(super) fn press(&mut self, session: usize) {
        let at = &mut self.sessions[session];
        for kind in 0..Button::KINDS {
            let waits = |console: &Console| match console.asked {
                PendingRequest::Press(button) if button.kind() == kind && console.session == session => {
                    Some(button)
                }
                PendingRequest::Press(_) | PendingRequest::Answer(..) | PendingRequest::Nothing => None,
            };
            if at.flights[kind].is_some() {
                continue;
            }
            let Some(button) = self.consoles.iter().find_map(waits) else { continue };
            at.presses_made += 1;
            let number = at.presses_made;
            // Sending fails only when the launcher is gone, which closes the console server as well.
            drop(self.presses.send((at.mp, Frame::Press { number, button })));
            drop(self.waker.write(&[1]));
            at.flights[kind] = Some(Flight { number, button, since: Instant::now() });
            for console in &mut self.consoles {
                if console.asked == PendingRequest::Press(button) && console.session == session {
                    console.asked = PendingRequest::Answer(kind, number);
                }
            }
        }
    }
}

/// When a button is carried out that was pressed while the MP begins no step.
fn pending(button: Button) -> String {
    match button {
        // It is also asked for on the state board.
        Button::Stop => format!(
            "{button}: the MP begins no step, and its robots stop by themselves; when it goes on, or in {} s, when the cell is ended",
            STOPPING.as_secs()
        ),
        _ => format!("{button}: the program computes; when it moves or waits again"),
    }
}

/// `suspended: step 1203`; `refused nothing runs: step 1203`.
fn say(button: Button, pressed: Pressed, persisting: Option<&Fault>) -> Answer {
    let Pressed { step, state, done, .. } = pressed;
    if done {
        return Answer::Done(format!("{}: step {step}", button.done(state)));
    }
    let why = persisting.filter(|_| (button, state) == (Button::Reset, CellState::Acknowledged));
    let why = why.map_or_else(String::new, |why| format!(": {why}").replace('\n', " "));
    Answer::Refused(format!("{}{why}: step {step}", pressed.reason(button)))
}
