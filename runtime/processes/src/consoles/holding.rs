//! A key of a terminal that is held lets robots move at reduced speed.
//!
//! In: bytes of a terminal whose keys repeat while they are held, and the robot that they jog, if one is named. Out: a hold that is renewed while they come, and let go when
//! they do not.
//!
//! A terminal does not say when a key is let go. So a hold begins only when a key repeats, and not when it is pressed; it is let
//! go when the key has not repeated for [`GAP`]. If this process stands still, or is ended, the hold lapses in the cell.

use std::io::{self, IsTerminal, Read};
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};

use mrroc_core::console::{refused, say};
use mrroc_core::fault::Name;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::jog::JogOrder;
use mrroc_core::operator::{Answer, Renewal, Request};
use mrroc_launch::outcome::report;

use super::caller::Caller;
use super::protocol::ConsoleMessage;
use crate::link::monotonic;

/// Longest time between two bytes of a key that is held: keys repeat at 10 to 50 Hz.
const GAP: Duration = Duration::from_millis(150);

/// How often a hold is renewed at most.
const RENEWAL: Duration = Duration::from_millis(50);

/// What the bytes of a terminal mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Key {
    /// None is held, as far as anybody knows.
    #[default]
    Free,
    /// One was pressed: whether it is held is not known yet.
    Pressed { last: Duration },
    /// One is held.
    Held { last: Duration, renewed: Duration, renewal: Renewal },
}

impl Key {
    /// What to tell the cell when a byte came at `now`, on a clock that only goes forward.
    fn byte(self, now: Duration) -> (Key, Option<Button>) {
        let begin = |last| {
            let renewal = Renewal::first(now.as_millis() as u64);
            (Key::Held { last, renewed: now, renewal }, Some(Button::Hold(renewal)))
        };
        match self {
            Key::Pressed { last } if now - last <= GAP => begin(now),
            Key::Held { last, renewed, renewal } if now - last <= GAP => {
                if now - renewed < RENEWAL {
                    return (Key::Held { last: now, renewed, renewal }, None);
                }
                match renewal.next() {
                    Some(renewal) => {
                        (Key::Held { last: now, renewed: now, renewal }, Some(Button::Hold(renewal)))
                    }
                    None => begin(now),
                }
            }
            Key::Held { renewal, .. } => (Key::Pressed { last: now }, Some(Button::LetGo(renewal.hold()))),
            Key::Free | Key::Pressed { .. } => (Key::Pressed { last: now }, None),
        }
    }

    /// The same when none has come by `now`.
    fn silence(self, now: Duration) -> (Key, Option<Button>) {
        match self {
            Key::Held { last, renewal, .. } if now - last > GAP => {
                (Key::Free, Some(Button::LetGo(renewal.hold())))
            }
            Key::Free | Key::Pressed { .. } | Key::Held { .. } => (self, None),
        }
    }
}

/// What ends a hold: q, and Ctrl-C, Ctrl-D, Ctrl-Z and Ctrl-\\.
const ENDS: [u8; 5] = [b'q', 3, 4, 26, 28];

/// A terminal that gives every byte at once and shows none.
struct Raw {
    before: Termios,
}

impl Raw {
    fn begin() -> io::Result<Raw> {
        let before = tcgetattr(io::stdin())?;
        let mut raw = before.clone();
        // Ctrl-C comes as a byte as well: a signal would leave the terminal as it is then.
        raw.local_modes -= LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG;
        tcsetattr(io::stdin(), OptionalActions::Now, &raw)?;
        Ok(Raw { before })
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // What the terminal does not take back it keeps; there is nobody to tell.
        let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
    }
}

/// Lets a key of this terminal hold the cell, until `q` is pressed or the cell ends.
pub(crate) fn hold(mut caller: Caller, jog: Option<(Name, JogOrder)>) -> ExitCode {
    if !io::stdin().is_terminal() {
        return refused(
            &"a key is held at a terminal, and this is none\n help: run it in a terminal of your own",
        );
    }
    let raw = match Raw::begin() {
        Ok(raw) => raw,
        Err(error) => return refused(&format!("this terminal gives no single keys: {error}")),
    };
    let _ = say("hold the space bar: robots move while it repeats; let it go and they stop; q ends\n");
    let ended = hold_by_keys(&mut caller, jog);
    drop(raw);
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error);
            ExitCode::FAILURE
        }
    }
}

fn hold_by_keys(caller: &mut Caller, jog: Option<(Name, JogOrder)>) -> io::Result<()> {
    let began = Instant::now();
    let start = Duration::from_nanos(monotonic());
    let mut key = Key::default();
    let mut bytes = [0; 64];
    loop {
        let nap = Timespec::try_from(GAP / 3).ok();
        let stdin = io::stdin();
        let mut input = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
        let came = poll(&mut input, nap.as_ref()).is_ok_and(|count| count > 0);
        let now = start + began.elapsed();
        let (next, told) = if came {
            let count = stdin.lock().read(&mut bytes)?;
            if count == 0 || bytes[..count].iter().any(|byte| ENDS.contains(byte)) {
                if let Key::Held { renewal, .. } = key {
                    tell(caller, Button::LetGo(renewal.hold()))?;
                }
                return Ok(());
            }
            key.byte(now)
        } else {
            key.silence(now)
        };
        key = next;
        match (told, jog) {
            (Some(Button::Hold(renewal)), Some((robot, order))) => {
                tell(caller, Button::Jog(renewal, robot, order))?;
            }
            (Some(button), _) => tell(caller, button)?,
            (None, _) => {}
        }
    }
}

fn tell(caller: &mut Caller, button: Button) -> io::Result<()> {
    let shown = match button {
        Button::Hold(renewal) if renewal.count() == 0 => "held\n",
        Button::Jog(renewal, ..) if renewal.count() == 0 => "jogged\n",
        Button::LetGo(_) => "let go\n",
        _ => "",
    };
    match caller.ask(&Request::Press(button), None)? {
        ConsoleMessage::Answer(Answer::Done(_)) => {
            let _ = say(shown);
            Ok(())
        }
        ConsoleMessage::Answer(Answer::Refused(why)) => Err(io::Error::other(why)),
        // The program computes: what is held now may be over by then.
        ConsoleMessage::Answer(Answer::Pending(_)) | ConsoleMessage::Picture(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// What is told when bytes come at these times [ms], and nobody presses anything until `end`.
    fn told(bytes: &[u32], end: u32) -> Vec<(u32, Button)> {
        let (mut key, mut all) = (Key::default(), Vec::new());
        for now in 0..end {
            let (next, told) = if bytes.contains(&now) { key.byte(MS * now) } else { key.silence(MS * now) };
            key = next;
            all.extend(told.map(|told| (now, told)));
        }
        all
    }

    #[test]
    fn a_hold_begins_when_a_key_repeats_and_is_let_go_when_it_no_longer_does() {
        // Pressed once; and pressed, and repeated from half a second later at 30 Hz.
        assert_eq!(told(&[10], 2000), []);
        let held: Vec<u32> = [10].into_iter().chain((510..1000).step_by(33)).collect();
        let told = told(&held, 2000);
        let first = Renewal::first(543);
        assert_eq!(told[0], (543, Button::Hold(first)));
        assert_eq!(told[1], (609, Button::Hold(first.next().expect("not the last"))));
        let last = held[held.len() - 1];
        assert_eq!(told[told.len() - 1], (last + 151, Button::LetGo(543)));
        // Renewed at least every tenth of a second.
        let renewed: Vec<_> = told[..told.len() - 1].iter().map(|(now, _)| *now).collect();
        assert!(renewed.windows(2).all(|two| two[1] - two[0] <= 100), "{renewed:?}");
    }

    #[test]
    fn a_key_that_is_pressed_again_begins_another_hold() {
        let told = told(&[0, 30, 60, 400, 430], 500);
        let holds: Vec<_> = told
            .iter()
            .map(|(_, told)| match told {
                Button::Hold(renewal) => (true, renewal.hold()),
                Button::LetGo(hold) => (false, *hold),
                other => unreachable!("{other}"),
            })
            .collect();
        assert_eq!(holds, [(true, 30), (false, 30), (true, 430)]);
    }
}
