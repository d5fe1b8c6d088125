//! The buttons of an operator's console, and what pressing one does to a running cell.
//!
//! In: a button, and the state that the cell is in when a step begins. Out: what [`Operator`] is told, or that the state
//! forbids it. Stop comes before everything else; what would set robots in motion is refused while they stop.

use core::fmt;

use crate::model::name::Name;
use crate::model::wire::Wire;
use crate::operator::Operator;
use crate::operator::hold::Renewal;
use crate::operator::jog::order::{percent, share};
use crate::operator::jog::{JogOrder, JogRefusal};
pub use crate::operator::no_button::NoButton;
use crate::safety::latch::Latch;

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

impl Button {
    /// How many kinds there are.
    pub const KINDS: usize = 12;

    /// How many words of a message one takes.
    pub const WORDS: usize = 2 + NAME + JogOrder::WORDS;

    /// Their words; the place of one is its kind, and kinds are carried out in this order.
    pub const NAMES: [&str; Button::KINDS] = [
        "stop",
        "abort",
        "suspend",
        "resume",
        "speed",
        "acknowledge",
        "reset",
        "reduced",
        "hold",
        "let-go",
        "jog",
        "jog-done",
    ];

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

    /// Reads a button's word, and what belongs to it: the speed in percent, as `50`, `50%` or `50 %`; `reduced on` or `off`;
    /// `hold`'s number and count, `let-go`'s number; `jog`'s number and count, the robot, and [what it is to do](JogOrder::read);
    /// `jog-done`'s robot.
    ///
    /// # Errors
    /// [`NoButton`]: what is wrong, and what to write.
    pub fn read(word: &str, rest: &str) -> Result<Button, NoButton> {
        let bad = |what: String, help: &str| NoButton { what, help: help.to_owned() };
        let plain = match word {
            "stop" => Button::Stop,
            "abort" => Button::Abort,
            "suspend" => Button::Suspend,
            "resume" => Button::Resume,
            "acknowledge" => Button::Acknowledge,
            "reset" => Button::Reset,
            "reduced" => {
                return match rest.trim() {
                    "on" => Ok(Button::Reduced(true)),
                    "off" => Ok(Button::Reduced(false)),
                    _ => Err(bad(
                        format!("reduced `{}`", rest.trim().escape_default()),
                        "write reduced on, or reduced off",
                    )),
                };
            }
            "hold" => {
                let mut numbers = rest.split_whitespace().map(str::parse::<u64>);
                let word = match (numbers.next(), numbers.next(), numbers.next()) {
                    (Some(Ok(hold)), Some(Ok(count)), None) => Renewal::of(hold, count),
                    _ => None,
                };
                let help = "write the number of the hold and the count of the renewal: hold 4711 0";
                return word
                    .map(Button::Hold)
                    .ok_or_else(|| bad(format!("`{}` is no renewal", rest.trim().escape_default()), help));
            }
            "let-go" => {
                let number = rest.trim().parse().map(Button::LetGo);
                let help = "write the number of the hold: let-go 4711";
                return number
                    .map_err(|_| bad(format!("`{}` is no hold", rest.trim().escape_default()), help));
            }
            "jog" => return read_jog(rest),
            "jog-done" => {
                let robot = Name::new(rest.trim()).map(Button::JogDone);
                return robot.map_err(|error| bad(error.to_string(), "write the robot: jog-done left"));
            }
            "speed" => {
                let rest = rest.trim();
                return match share(rest) {
                    Some(speed) if (0.0..=1.0).contains(&speed) => Ok(Button::Speed(speed)),
                    _ if rest.is_empty() => {
                        Err(bad("speed needs a value".to_owned(), "write 0% to 100%: speed 50%"))
                    }
                    _ => Err(bad(
                        format!("`{}` is no speed", rest.escape_default()),
                        "write 0% to 100%: speed 50%",
                    )),
                };
            }
            _ => {
                let help = crate::suggestion::suggestion(word, &Button::NAMES, "there are");
                return Err(NoButton { what: format!("`{word}` is no button"), help });
            }
        };
        if rest.trim().is_empty() {
            Ok(plain)
        } else {
            Err(bad(format!("`{}` is too much", rest.escape_default()), &format!("write {word} alone")))
        }
    }

    /// As words of a message.
    pub fn to_words(self) -> [u64; Button::WORDS] {
        let mut words = [0; Button::WORDS];
        words[0] = self.kind() as u64;
        words[1] = match self {
            Button::Speed(speed) => speed.to_bits(),
            Button::Reduced(reduced) => u64::from(reduced),
            Button::Hold(renewal) => renewal.to_word(),
            Button::LetGo(hold) => hold,
            Button::Jog(renewal, robot, order) => {
                robot.put(&mut words[2..]);
                order.put(&mut words[2 + NAME..]);
                renewal.to_word()
            }
            Button::JogDone(robot) => {
                robot.put(&mut words[2..]);
                0
            }
            Button::Stop
            | Button::Abort
            | Button::Suspend
            | Button::Resume
            | Button::Acknowledge
            | Button::Reset => 0,
        };
        words
    }

    /// From words of a message.
    pub fn from_words(words: [u64; Button::WORDS]) -> Option<Button> {
        let [kind, value, ref more @ ..] = words;
        if let (10 | 11, robot) = (kind, Name::get(more)) {
            let (robot, done) = (robot.ok()?, kind == 11);
            let jog =
                || Some(Button::Jog(Renewal::from_word(value), robot, JogOrder::get(&more[NAME..]).ok()?));
            return if done { Some(Button::JogDone(robot)) } else { jog() };
        }
        let plain = [
            Button::Stop,
            Button::Abort,
            Button::Suspend,
            Button::Resume,
            Button::Acknowledge,
            Button::Reset,
        ];
        let valued = [
            Button::Speed(f64::from_bits(value)),
            Button::Reduced(value != 0),
            Button::Hold(Renewal::from_word(value)),
            Button::LetGo(value),
        ];
        plain.into_iter().chain(valued).find(|button| button.kind() as u64 == kind)
    }
}

/// How many words a name takes.
const NAME: usize = <Name as Wire>::LEN;

/// Reads `4711 0 left tool x 50%`.
fn read_jog(rest: &str) -> Result<Button, NoButton> {
    let mut words = rest.split_whitespace();
    let mut number = || words.next().and_then(|word| word.parse::<u64>().ok());
    let renewal = number().zip(number()).and_then(|(hold, count)| Renewal::of(hold, count));
    let robot = words.next().and_then(|word| Name::new(word).ok());
    let Some((renewal, robot)) = renewal.zip(robot) else {
        let help = "write the number of the hold, the count of the renewal, the robot and what it is to do: jog 4711 0 left tool x 20%";
        return Err(NoButton {
            what: format!("`{}` is no jog", rest.trim().escape_default()),
            help: help.to_owned(),
        });
    };
    JogOrder::read(&mut words).map(|order| Button::Jog(renewal, robot, order))
}

/// `speed 50%`: what [`Button::read`] reads.
impl fmt::Display for Button {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Button::NAMES[self.kind()])?;
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

/// What a cell does, as far as it matters to its operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellState {
    /// No Move or Wait of the MP is at work.
    #[default]
    Idle,
    /// One is.
    Running,
    /// One stands, or is coming to a standstill, until the operator resumes it.
    Suspended,
    /// The operator ends one.
    Aborting,
    /// All robots stop for good.
    Stopping,
    /// They have, and the fault is latched.
    Latched,
    /// The operator has taken notice of it.
    Acknowledged,
    /// Robots are made ready to start again.
    Resetting,
}

impl CellState {
    /// All of them; one travels as its place in this list.
    pub const ALL: [CellState; 8] = [
        CellState::Idle,
        CellState::Running,
        CellState::Suspended,
        CellState::Aborting,
        CellState::Stopping,
        CellState::Latched,
        CellState::Acknowledged,
        CellState::Resetting,
    ];

    /// Its word.
    pub const fn word(self) -> &'static str {
        match self {
            CellState::Idle => "idle",
            CellState::Running => "running",
            CellState::Suspended => "suspended",
            CellState::Aborting => "aborting",
            CellState::Stopping => "stopping",
            CellState::Latched => "latched",
            CellState::Acknowledged => "acknowledged",
            CellState::Resetting => "resetting",
        }
    }

    /// Why it refuses a button.
    pub const fn reason(self, button: Button) -> &'static str {
        match self {
            CellState::Acknowledged if matches!(button, Button::Reset) => "the cause of the fault persists",
            _ if matches!(button, Button::Hold(_) | Button::Jog(..)) => {
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

/// What became of a button that was pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
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

impl Answer {
    /// Why a button was refused.
    #[must_use]
    pub fn reason(&self, button: Button) -> &'static str {
        self.why.map_or_else(|| self.state.reason(button), JogRefusal::reason)
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

    /// The state of a cell.
    pub fn state(&self) -> CellState {
        match self.latch() {
            Latch::Clear => {}
            Latch::Stopping => return CellState::Stopping,
            Latch::Latched => return CellState::Latched,
            Latch::Acknowledged => return CellState::Acknowledged,
            Latch::Resetting => return CellState::Resetting,
        }
        match (self.is_aborting(), self.is_suspended(), self.is_running()) {
            (true, ..) => CellState::Aborting,
            (_, true, _) => CellState::Suspended,
            (.., true) => CellState::Running,
            (.., false) => CellState::Idle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::jog::JogMotion;
    use crate::safety::latch::Event;

    fn all() -> [Button; Button::KINDS] {
        let left = Name::new("left").expect("a name");
        let motion = JogMotion::Joint { joint: 2 };
        let jog = JogOrder { motion, speed: -0.25, way: Some(0.1) };
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
    fn every_button_is_read_as_it_is_written_and_sent_as_it_is() {
        for (kind, button) in all().into_iter().enumerate() {
            assert_eq!(button.kind(), kind);
            let text = button.to_string();
            let (word, rest) = text.split_once(' ').unwrap_or((&text, ""));
            assert_eq!(Button::read(word, rest), Ok(button));
            assert_eq!(Button::from_words(button.to_words()), Some(button));
        }
        assert_eq!(Button::read("speed", "12.5 %"), Ok(Button::Speed(0.125)));
        assert_eq!(Button::read("speed", "50"), Ok(Button::Speed(0.5)));
        assert_eq!(Button::read("speed", "4.63e-200"), Ok(Button::Speed(0.0)));
        assert_eq!(Button::from_words([12; Button::WORDS]), None);
        assert_eq!(Button::from_words([10; Button::WORDS]), None);
        for (word, rest, told) in [
            ("speed", "0.5.", "write 0% to 100%"),
            ("speed", "%", "write 0% to 100%"),
            ("speed", "101%", "write 0% to 100%"),
            ("speed", "NaN%", "write 0% to 100%"),
            ("speed", "", "write 0% to 100%"),
            ("suspnd", "", "did you mean `suspend`?"),
            ("stop", "now", "write stop alone"),
            ("jog", "4711 0 left", "tool x -50%"),
            ("jog", "left tool x 10%", "jog 4711 0 left tool x 20%"),
            ("jog", "4711 70000 left tool x 10%", "jog 4711 0 left tool x 20%"),
            ("jog-done", "", "write the robot: jog-done left"),
        ] {
            let error = Button::read(word, rest).expect_err("no button").to_string();
            assert!(error.contains(told), "{error}");
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
