//! The buttons of an operator's console: their words, what pressing one does to a running cell, and what is said of it then.
//!
//! In: a button, and the state that the cell is in when a step begins. Out: what [`Operator`] is told, or that the state
//! forbids it. Stop comes before everything else; what would set robots in motion is refused while they stop.
//!
//! A new button is a variant and a row of [`ButtonKind::ALL`], and says in [`Operator::press`] what it does: consoles, the command
//! line, the launcher, the MP and recordings take it from here.

use core::fmt;
use core::str::SplitWhitespace;

use super::Operator;
use super::cell_state::CellState;
use super::hold::Renewal;
use super::jog::order::{percent, share};
use super::jog::{JogOrder, JogRefusal};
use super::no_request::NoRequest;
use crate::model::name::Name;

/// A button of the console.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Button {
    /// All robots stop on their paths, and the cell is latched.
    Stop,
    /// All robots stop on their paths, and the instruction ends.
    Abort,
    /// All robots stop on their paths, and stand until `Resume`.
    Suspend,
    /// Goes on after `Suspend`.
    Resume,
    /// The speed as a share of the planned one, 0 to 1.
    Speed(f64),
    /// Says that the operator has taken notice of the fault.
    Acknowledge,
    /// Lets the programs start again after an acknowledged fault.
    Reset,
    /// Reduced speed, or no longer.
    Reduced(bool),
    /// A person holds what lets robots move at reduced speed.
    Hold(Renewal),
    /// The person lets go; with the number of the hold.
    LetGo(u64),
    /// A person holds what jogs a robot at reduced speed.
    Jog(Renewal, Name, JogOrder),
    /// The person has done with jogging a robot: its program goes on.
    JogDone(Name),
}

/// What there is to say of a kind of buttons.
#[derive(Clone, Copy, Debug)]
pub struct ButtonKind {
    /// Its word.
    pub word: &'static str,
    /// What stands behind the word, as a help names it; empty: nothing does.
    pub rest: &'static str,
    /// What to write, if something stands behind the word.
    example: &'static str,
    /// What it does, for whoever writes it on a command line; empty: a key that is held sends it.
    pub does: &'static str,
}

impl ButtonKind {
    /// All of them: a button's kind is its place in this list, and kinds are carried out in this order.
    pub const ALL: [ButtonKind; Button::KINDS] = [
        kind("stop", "", "", "Stop on the path for good, as after a fault"),
        kind("abort", "", "", "Stop on the path and end the instruction; end a cell that awaits its reset"),
        kind("suspend", "", "", "Stop all robots on their paths"),
        kind("resume", "", "", "Go on"),
        kind("speed", "PERCENT", "0% to 100%: speed 50%", "Slow down or speed up on the path"),
        kind(
            "acknowledge",
            "",
            "",
            "Take notice of a fault, in a cell whose file says after_fault = \"await reset\"",
        ),
        kind("reset", "", "", "Start again, after `acknowledge`"),
        kind(
            "reduced",
            "ON|OFF",
            "reduced on, or reduced off",
            "Robots move at reduced speed only, and only while a key is held: `on`, `off`",
        ),
        kind("hold", "", "the number of the hold and the count of the renewal: hold 4711 0", ""),
        kind("let-go", "", "the number of the hold: let-go 4711", ""),
        kind(
            "jog",
            "",
            "the number of the hold, the count of the renewal, the robot and what it is to do: jog 4711 0 left tool x 20%",
            "",
        ),
        kind(
            "jog-done",
            "ROBOT",
            "the robot: jog-done left",
            "Go on with the program of a robot that was jogged",
        ),
    ];
}

const fn kind(
    word: &'static str,
    rest: &'static str,
    example: &'static str,
    does: &'static str,
) -> ButtonKind {
    ButtonKind { word, rest, example, does }
}

impl Button {
    /// How many kinds there are.
    pub const KINDS: usize = 12;

    /// Those behind whose word nothing stands.
    const PLAIN: [Button; 6] =
        [Button::Stop, Button::Abort, Button::Suspend, Button::Resume, Button::Acknowledge, Button::Reset];

    /// Whether every console may press it, whoever holds the control token: it lets nothing move that would not move without it.
    pub const fn is_for_all(self) -> bool {
        matches!(self, Button::Stop | Button::Abort | Button::LetGo(_))
    }

    /// Its place among the kinds.
    pub const fn kind(self) -> usize {
        match self {
            Button::Stop => 0,
            Button::Abort => 1,
            Button::Suspend => 2,
            Button::Resume => 3,
            Button::Speed(_) => 4,
            Button::Acknowledge => 5,
            Button::Reset => 6,
            Button::Reduced(_) => 7,
            Button::Hold(_) => 8,
            Button::LetGo(_) => 9,
            Button::Jog(..) => 10,
            Button::JogDone(_) => 11,
        }
    }

    /// Reads what stands behind the word of a kind: the speed in percent, as `50`, `50%` or `50 %`; `reduced on` or `off`;
    /// `hold`'s number and count, `let-go`'s number; `jog`'s number and count, the robot, and [what it is to do](JogOrder::read);
    /// `jog-done`'s robot.
    ///
    /// # Errors
    /// [`NoRequest`]: what is wrong, and what to write.
    pub(super) fn read(kind: &ButtonKind, rest: &str) -> Result<Button, NoRequest> {
        let mut words = rest.split_whitespace();
        let button = match kind.word {
            "speed" => share(rest).filter(|speed| (0.0..=1.0).contains(speed)).map(Button::Speed),
            "reduced" => {
                ["off", "on"].iter().position(|word| *word == rest).map(|on| Button::Reduced(on == 1))
            }
            "hold" => renewal(&mut words).filter(|_| words.next().is_none()).map(Button::Hold),
            "let-go" => rest.parse().ok().map(Button::LetGo),
            "jog" => {
                let robot = |word| Name::new(word).ok();
                match renewal(&mut words).zip(words.next().and_then(robot)) {
                    Some((renewal, robot)) => Some(Button::Jog(renewal, robot, JogOrder::read(&mut words)?)),
                    None => None,
                }
            }
            "jog-done" => Name::new(rest).ok().map(Button::JogDone),
            word => {
                let is_it = |button: &Button| ButtonKind::ALL[button.kind()].word == word && rest.is_empty();
                Button::PLAIN.into_iter().find(is_it)
            }
        };
        button.ok_or_else(|| NoRequest::of(kind.word, rest, kind.example))
    }

    /// What is said of it once it is carried out, in the state that the cell was in.
    #[must_use]
    pub fn done(self, state: CellState) -> String {
        match (self, state) {
            (Button::Stop, CellState::Latched | CellState::Acknowledged) => "stopped already".to_owned(),
            (Button::Stop, _) => "stopping".to_owned(),
            (Button::Abort, _) => "aborting".to_owned(),
            (Button::Suspend, _) => "suspended".to_owned(),
            (Button::Resume, _) => "resumed".to_owned(),
            (Button::Speed(_), _) => self.to_string(),
            (Button::Acknowledge, _) => "acknowledged".to_owned(),
            (Button::Reset, _) => "resetting".to_owned(),
            (Button::Reduced(true), _) => "reduced speed: robots move only while you hold".to_owned(),
            (Button::Reduced(false), _) => "full speed, and suspended: resume goes on".to_owned(),
            (Button::Hold(_), _) => "held".to_owned(),
            (Button::LetGo(_), _) => "let go".to_owned(),
            (Button::Jog(_, robot, _), _) => format!("{robot} is jogged"),
            (Button::JogDone(robot), _) => format!("jogging {robot} is done"),
        }
    }

    /// Why a state of the cell refuses it.
    #[must_use]
    pub const fn reason(self, state: CellState) -> &'static str {
        match state {
            CellState::Acknowledged if matches!(self, Button::Reset) => "the cause of the fault persists",
            _ if matches!(self, Button::Hold(_) | Button::Jog(..)) => {
                "the cell is not at reduced speed: write reduced on"
            }
            CellState::Idle => "nothing runs",
            CellState::Running => "it runs",
            CellState::Suspended => "it is suspended",
            CellState::Aborting => "it is being aborted",
            CellState::Stopping => "it is stopping",
            CellState::Latched => "it has stopped for a fault, which is not acknowledged",
            CellState::Acknowledged => "it has stopped for a fault, which is not reset",
            CellState::Resetting => "it is being reset",
        }
    }
}

/// A renewal, of the number of its hold and of its count.
fn renewal(words: &mut SplitWhitespace<'_>) -> Option<Renewal> {
    let mut number = || words.next()?.parse().ok();
    number().zip(number()).and_then(|(hold, count)| Renewal::of(hold, count))
}

/// `speed 50%`: what [`Request::read`](super::Request::read) reads.
impl fmt::Display for Button {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(ButtonKind::ALL[self.kind()].word)?;
        match self {
            // Without the last digits of the product: 7%, not 7.000000000000001%.
            Button::Speed(speed) => write!(f, " {}%", percent(*speed)),
            Button::Reduced(true) => f.write_str(" on"),
            Button::Reduced(false) => f.write_str(" off"),
            Button::Hold(renewal) => write!(f, " {} {}", renewal.hold(), renewal.count()),
            Button::LetGo(hold) => write!(f, " {hold}"),
            Button::Jog(renewal, robot, order) => {
                write!(f, " {} {} {robot} {order}", renewal.hold(), renewal.count())
            }
            Button::JogDone(robot) => write!(f, " {robot}"),
            _ => Ok(()),
        }
    }
}

/// What became of a button that was pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pressed {
    /// The number that it was pressed under; 0 for none.
    pub number: u64,
    /// The step that carried it out or refused it.
    pub step: u64,
    /// The state that the cell was in when it was pressed.
    pub state: CellState,
    /// Whether it was carried out.
    pub done: bool,
    /// Why a jog was not.
    pub why: Option<JogRefusal>,
}

impl Pressed {
    /// Why a button was refused.
    #[must_use]
    pub fn reason(&self, button: Button) -> &'static str {
        self.why.map_or_else(|| button.reason(self.state), JogRefusal::reason)
    }
}

impl Operator {
    /// Carries out a button in a state of the cell; whether it was. Pressed twice it changes nothing more.
    pub fn press(&self, button: Button, state: CellState) -> bool {
        use CellState::{Aborting, Acknowledged, Latched, Running, Suspended};
        match (button, state) {
            (Button::Stop, state) => {
                // Latched, the cell has stopped: a stop kept for later would stop it after its reset.
                if !matches!(state, Latched | Acknowledged) {
                    self.protective_stop();
                }
                true
            }
            (Button::Abort, Running | Suspended | Aborting) => {
                self.abort();
                self.is_aborting()
            }
            // It stands: what is left to end is the cell.
            (Button::Abort, Latched | Acknowledged) => {
                self.give_up();
                true
            }
            (Button::Suspend, Running | Suspended) => {
                self.suspend();
                true
            }
            (Button::Resume, Suspended) => {
                self.resume();
                true
            }
            (Button::Speed(speed), _) => self.set_speed(speed).is_ok(),
            (Button::Acknowledge, _) => self.acknowledge().is_ok(),
            (Button::Reset, _) => self.reset().is_ok(),
            (Button::Reduced(reduced), _) => {
                self.set_reduced(reduced);
                true
            }
            (Button::Hold(renewal), _) => {
                if self.is_reduced() {
                    self.renew_hold(renewal);
                }
                self.is_reduced()
            }
            (Button::LetGo(hold), _) => {
                self.let_go(hold);
                true
            }
            (Button::Jog(renewal, robot, order), _) => {
                if self.is_reduced() {
                    self.jog(renewal, robot, order);
                }
                self.is_reduced()
            }
            (Button::JogDone(robot), _) => {
                self.end_jog(robot);
                true
            }
            (Button::Abort | Button::Suspend | Button::Resume, _) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Request;
    use crate::operator::jog::JogMotion;
    use crate::safety::latch::Event;

    fn all() -> [Button; Button::KINDS] {
        let left = Name::new("left").expect("a name");
        let jog = JogOrder { motion: JogMotion::Joint { joint: 2 }, speed: -0.25, distance: Some(0.1) };
        [
            Button::Stop,
            Button::Abort,
            Button::Suspend,
            Button::Resume,
            Button::Speed(0.5),
            Button::Acknowledge,
            Button::Reset,
            Button::Reduced(true),
            Button::Hold(Renewal::first(4711)),
            Button::LetGo(4711),
            Button::Jog(Renewal::first(4711), left, jog),
            Button::JogDone(left),
        ]
    }

    #[test]
    fn every_button_is_read_as_it_is_written() {
        for (kind, button) in all().into_iter().enumerate() {
            assert_eq!(button.kind(), kind);
            assert_eq!(Request::read(&button.to_string()), Ok(Request::Press(button)));
        }
        for (line, button) in [
            ("speed 12.5 %", Button::Speed(0.125)),
            ("speed 50", Button::Speed(0.5)),
            ("speed 4.63e-200", Button::Speed(0.0)),
        ] {
            assert_eq!(Request::read(line), Ok(Request::Press(button)));
        }
    }

    /// An operator of a cell in this state.
    fn operator(state: CellState) -> Operator {
        let operator = Operator::new();
        let events = [Event::Fault, Event::Standstill, Event::Acknowledge, Event::Reset { pressed: true }];
        let met = match state {
            CellState::Idle => 0,
            CellState::Running | CellState::Suspended | CellState::Aborting => {
                operator.begin();
                match state {
                    CellState::Suspended => operator.suspend(),
                    CellState::Aborting => operator.abort(),
                    _ => {}
                }
                0
            }
            CellState::Stopping => 1,
            CellState::Latched => 2,
            CellState::Acknowledged => 3,
            CellState::Resetting => 4,
        };
        events[..met].iter().for_each(|&event| operator.meet(event).expect("in this order"));
        assert_eq!(operator.state(), state);
        operator
    }

    /// Fault 36: what each button does in each state, as the states of SAFETY.md say it.
    #[test]
    fn fault_36_a_button_that_contradicts_the_state_of_the_cell_is_refused() {
        use CellState::{Aborting, Acknowledged, Latched, Running, Suspended};
        let all = CellState::ALL;
        for (button, allowed) in [
            (Button::Stop, &all[..]),
            (Button::Abort, &[Running, Suspended, Aborting, Latched, Acknowledged]),
            (Button::Suspend, &[Running, Suspended]),
            (Button::Resume, &[Suspended]),
            (Button::Speed(0.5), &all),
            (Button::Speed(f64::NAN), &[]),
            (Button::Acknowledge, &[Latched, Acknowledged]),
            (Button::Reset, &[Acknowledged]),
        ] {
            let carried_out = |&state: &CellState| operator(state).press(button, state);
            assert_eq!(all.into_iter().filter(carried_out).collect::<Vec<_>>(), allowed, "{button}");
        }
    }

    #[test]
    fn an_abort_ends_a_cell_that_awaits_its_reset_and_no_other() {
        for state in CellState::ALL {
            let operator = operator(state);
            operator.press(Button::Abort, state);
            let ends = matches!(state, CellState::Latched | CellState::Acknowledged);
            assert_eq!(operator.has_given_up(), ends, "{state:?}");
        }
    }

    #[test]
    fn a_stop_is_heard_once_and_none_is_kept_for_after_a_reset() {
        let running = operator(CellState::Running);
        assert!(running.press(Button::Stop, CellState::Running));
        assert_eq!((running.take_protective_stop(), running.take_protective_stop()), (true, false));
        let latched = operator(CellState::Latched);
        assert!(latched.press(Button::Stop, CellState::Latched) && !latched.take_protective_stop());
    }
}
