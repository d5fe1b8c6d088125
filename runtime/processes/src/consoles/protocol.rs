//! What a console and the console server of a cell write to each other: lines of text.
//!
//! A console sends one request a line, and reads the answer before it sends the next request:
//!
//! | request | answer |
//! |---|---|
//! | `stop`, `abort`, `let-go 4711` | to every console: they only bring robots to rest |
//! | `suspend`, `resume`, `speed 50%`, `acknowledge`, `reset`, `reduced on`, `hold 4711 0`, `jog 4711 0 left tool x 20%`, `jog-done left` | only to the console that holds the control token; a console that asks while the token is free takes it |
//! | `take`, `release` | takes or returns the token; the end of a console returns it as well |
//! | `status` | a picture |
//! | `watch` | a picture, and from then on up to 20 pictures a second between the answers |
//! | `of press suspend` | any of these, of the lower cell `press`; each cell has a control token of its own |
//! | `by 3 81726354 suspend` | any of these, asked by page 3 of a panel, which heard it at this time of the machine \[ns\]: for the recording |
//!
//! An answer is one line, `done TEXT`, `refused TEXT` or `pending TEXT`. So is a picture, `picture JSON`.

use core::fmt;
use std::io::{self, BufRead, ErrorKind};

use super::picture::Picture;
use mrroc_core::fault::Name;
use mrroc_core::link::Nanos;
use mrroc_core::operator::button::Button;

/// The name of the console server's socket in a session's folder.
pub(super) const SOCKET: &str = "operator";

/// The longest request, without its line end \[bytes\].
pub const MAX_REQUEST: usize = 450;

/// The longest line that a console reads, and how much unread text may wait for it \[bytes\].
pub(super) const MAX_ANSWER: usize = 1 << 19;

/// A request of a console.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// `status`: one picture.
    Status,
    /// `watch`: one picture now, and further ones from then on.
    Watch,
    /// `take`: the control token.
    Take,
    /// `release`: give the control token back.
    Release,
    /// A button is pressed.
    Press(Button),
}

/// The requests that are not buttons.
const WORDS: [&str; 4] = ["status", "watch", "take", "release"];

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// A line that says what is wrong and what to write.
    pub fn read(line: &[u8]) -> Result<Request, String> {
        let line = core::str::from_utf8(line).map_err(|_| "this is no text".to_owned())?.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match (word, rest) {
            ("status", "") => Ok(Request::Status),
            ("watch", "") => Ok(Request::Watch),
            ("take", "") => Ok(Request::Take),
            ("release", "") => Ok(Request::Release),
            _ if WORDS.contains(&word) => Err(format!("write {word} alone")),
            _ if Button::NAMES.contains(&word) => Button::read(word, rest)
                .map(Request::Press)
                .map_err(|error| error.to_string().replace("\n help: ", ": ")),
            _ => {
                let known: Vec<_> = WORDS.iter().chain(&Button::NAMES).collect();
                let help = mrroc_core::suggestion::suggestion(word, &known, "there are");
                Err(format!("`{}` is no request: {help}", word.escape_default()))
            }
        }
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Request::Status => f.write_str("status"),
            Request::Watch => f.write_str("watch"),
            Request::Take => f.write_str("take"),
            Request::Release => f.write_str("release"),
            Request::Press(button) => button.fmt(f),
        }
    }
}

/// For whom a console asks: a page of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnBehalf {
    /// The number of the page.
    pub page: u64,
    /// When the panel heard it, by the machine's monotonic clock \[ns\].
    pub heard: Nanos,
}

/// A request, the lower cell that it is for, or the uppermost one if none is named, and the page that made it, if one did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Addressed {
    pub by: Option<OnBehalf>,
    pub cell: Option<Name>,
    pub request: Request,
}

impl Addressed {
    /// Reads a request, which may name a page and a cell.
    ///
    /// # Errors
    /// As [`Request::read`].
    pub fn read(line: &[u8]) -> Result<Addressed, String> {
        let mut rest = line.trim_ascii_start();
        let by = match rest.strip_prefix(b"by ") {
            None => None,
            Some(behind) => {
                let (page, behind) = word(behind);
                let (heard, behind) = word(behind);
                let number = |word: &[u8]| core::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
                let by = number(page).zip(number(heard)).map(|(page, heard)| OnBehalf { page, heard });
                rest = behind;
                Some(by.ok_or("write the page and when it was heard: by 3 81726354 suspend")?)
            }
        };
        let Some(behind) = rest.trim_ascii_start().strip_prefix(b"of ") else {
            return Ok(Addressed { by, cell: None, request: Request::read(rest)? });
        };
        let (name, request) = word(behind);
        let name = Name::of_process(&String::from_utf8_lossy(name)).map_err(|error| error.to_string())?;
        Ok(Addressed { by, cell: Some(name), request: Request::read(request)? })
    }
}

/// The first word of a line, and what stands behind it.
fn word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii_start();
    line.split_at(line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len()))
}

impl fmt::Display for Addressed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(OnBehalf { page, heard }) = self.by {
            write!(f, "by {page} {heard} ")?;
        }
        match self.cell {
            Some(cell) => write!(f, "of {cell} {}", self.request),
            None => self.request.fmt(f),
        }
    }
}

/// The answer to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The request was carried out; with what happened, in which step.
    Done(String),
    /// The request was refused; with the reason.
    Refused(String),
    /// The request will be carried out when the next step begins; at present the program computes.
    Pending(String),
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reply::Done(text) => write!(f, "done {text}"),
            Reply::Refused(text) => write!(f, "refused {text}"),
            Reply::Pending(text) => write!(f, "pending {text}"),
        }
    }
}

/// What a console receives.
#[derive(Clone, Debug, PartialEq)]
pub enum ConsoleMessage {
    /// The answer to a request.
    Reply(Reply),
    /// A picture of the cell.
    Picture(Box<Picture>),
}

impl ConsoleMessage {
    /// Reads the next answer or picture; `None` when the console server is gone.
    ///
    /// # Errors
    /// What was read is neither an answer nor a picture, or reading failed.
    pub fn read(from: &mut impl BufRead) -> io::Result<Option<ConsoleMessage>> {
        let bad = |line: &str| {
            let text = format!("`{}` is no answer", line.escape_default());
            io::Error::new(ErrorKind::InvalidData, text)
        };
        let Some(line) = read_line(from)? else { return Ok(None) };
        let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
        let rest = rest.to_owned();
        match word {
            "done" => Ok(Some(ConsoleMessage::Reply(Reply::Done(rest)))),
            "refused" => Ok(Some(ConsoleMessage::Reply(Reply::Refused(rest)))),
            "pending" => Ok(Some(ConsoleMessage::Reply(Reply::Pending(rest)))),
            "picture" => match serde_json::from_str(&rest) {
                Ok(picture) => Ok(Some(ConsoleMessage::Picture(picture))),
                Err(error) => Err(io::Error::new(ErrorKind::InvalidData, error)),
            },
            _ => Err(bad(&line)),
        }
    }
}

/// Reads a line, without its line end; `None` at the end of the stream.
fn read_line(from: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut line = Vec::new();
    let whole = io::Read::take(&mut *from, MAX_ANSWER as u64).read_until(b'\n', &mut line)?;
    if whole == 0 || line.pop() != Some(b'\n') {
        let cut = whole == MAX_ANSWER;
        return if cut {
            Err(io::Error::new(ErrorKind::InvalidData, "a line without an end"))
        } else {
            Ok(None)
        };
    }
    String::from_utf8(line).map(Some).map_err(|error| io::Error::new(ErrorKind::InvalidData, error))
}

#[cfg(test)]
mod tests {
    use super::super::beside::{BodyPicture, CarriedPicture, ReadingPicture};
    use super::super::picture::{CellPicture, ProcessPicture, RobotPicture};
    use super::*;
    use crate::board::entry::BODIES;
    use crate::board::figures::{FIGURES_WORDS, Figures};
    use mrroc_core::link::places::MAX_PROCESSES;
    use mrroc_core::nalgebra::Vector3;
    use mrroc_core::operator::button::CellState;
    use mrroc_core::operator::jog::JogStop;
    use mrroc_core::operator::state::InstructionKind;
    use mrroc_core::payload::WORDS;
    use mrroc_core::pose::Pose;
    use mrroc_core::robot::{Load, MAX_JOINTS, Signals, Values};
    use proptest::prelude::*;

    #[test]
    fn requests_are_read_as_they_are_written_and_others_are_refused_with_the_one_that_was_meant() {
        let buttons = [Button::Stop, Button::Speed(0.3), Button::Reset].map(Request::Press);
        let plain = [Request::Status, Request::Watch, Request::Take, Request::Release];
        for request in plain.into_iter().chain(buttons) {
            assert_eq!(Request::read(request.to_string().as_bytes()), Ok(request));
        }
        for (line, told) in [
            (&b"staus"[..], "did you mean `status`?"),
            (b"suspend now", "write suspend alone"),
            (b"take 2", "write take alone"),
            (b"speed fast", "write 0% to 100%"),
            (b"", "there are: status"),
            (b"\xff\xfe", "no text"),
        ] {
            let refused = Request::read(line).expect_err("no request");
            assert!(refused.contains(told) && !refused.contains('\n'), "{refused}");
        }
    }

    #[test]
    fn a_request_may_name_the_page_that_made_it_and_the_cell_that_it_is_for() {
        let page = |page, heard| Some(OnBehalf { page, heard });
        for (line, by, cell, request) in [
            ("of press suspend", None, Some("press"), Request::Press(Button::Suspend)),
            (" of  line.press  status", None, Some("line.press"), Request::Status),
            ("watch", None, None, Request::Watch),
            ("by 3 81726354 let-go 7", page(3, 81_726_354), None, Request::Press(Button::LetGo(7))),
            (" by  1  2  of press stop", page(1, 2), Some("press"), Request::Press(Button::Stop)),
        ] {
            let cell = cell.map(|name| Name::of_process(name).expect("a name"));
            let read = Addressed::read(line.as_bytes()).expect("a request");
            assert_eq!(read, Addressed { by, cell, request });
            assert_eq!(Addressed::read(read.to_string().as_bytes()), Ok(read));
        }
        for (line, told) in [
            ("of", "no request"),
            ("of press", "no request"),
            ("of a:b stop", "is no name"),
            ("of x y", "no request"),
            ("by 3 stop", "by 3 81726354 suspend"),
            ("by -1 3 stop", "by 3 81726354 suspend"),
            ("by 1 3", "no request"),
        ] {
            let refused = Addressed::read(line.as_bytes()).expect_err("no request");
            assert!(refused.contains(told), "{refused}");
        }
        // With the longest names and numbers it is no longer than a request may be.
        let (by, cell) = (page(u64::MAX, u64::MAX), Name::of_process(&"x".repeat(24)).ok());
        let button = Button::read("hold", &format!("{} {}", u64::MAX >> 16, u16::MAX)).expect("a hold");
        assert!(Addressed { by, cell, request: Request::Press(button) }.to_string().len() <= MAX_REQUEST);
        let longest = format!(
            "{} {} {} to 12.123456789%{}",
            u64::MAX >> 16,
            u16::MAX,
            "x".repeat(24),
            " -1.2345678901234567e-300".repeat(8)
        );
        let button = Button::read("jog", &longest).expect("a jog");
        assert!(Addressed { by, cell, request: Request::Press(button) }.to_string().len() <= MAX_REQUEST);
    }

    fn name() -> impl Strategy<Value = String> {
        "[a-zA-Z0-9_-]{1,24}"
    }

    fn joints() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        let one = || proptest::num::f64::NORMAL | proptest::num::f64::ZERO;
        (1_usize..=8).prop_flat_map(move |n| {
            (proptest::collection::vec(one(), n), proptest::collection::vec(one(), n))
        })
    }

    /// What stands beside the robots.
    fn beside() -> impl Strategy<Value = (Vec<CarriedPicture>, Vec<ReadingPicture>, Vec<BodyPicture>)> {
        let pose = |x: f64| Pose::translation(x, -0.25, 1e-9) * Pose::rotation(Vector3::x());
        let carried = (name(), 0.0..2.0, any::<Option<u8>>(), any::<[u32; 2]>()).prop_map(
            move |(robot, x, mass, [inputs, outputs])| CarriedPicture {
                robot,
                tool: pose(x),
                load: mass.map(|mass| Load::point(f64::from(mass), Vector3::new(x, 0.0, -x))),
                signals: Signals {
                    inputs: Values::new(inputs, [x, 0.0, -1e-300, 1e9]),
                    outputs: Values::new(outputs, [-x, 1.0, 2.0, 3.0]),
                },
            },
        );
        let words = proptest::option::of(proptest::collection::vec(any::<u64>(), 0..=WORDS));
        let reading = (name(), any::<u64>(), words).prop_map(|(sensor, step, words)| ReadingPicture {
            sensor,
            step,
            words,
        });
        let body = (0..BODIES, 0.0..2.0).prop_map(move |(place, x)| BodyPicture { place, pose: pose(x) });
        (
            proptest::collection::vec(carried, 0..8),
            proptest::collection::vec(reading, 0..8),
            proptest::collection::vec(body, 0..=BODIES),
        )
    }

    fn picture() -> impl Strategy<Value = Picture> {
        let process =
            ("(ecp|edp|vsp) [a-z]{1,24}", any::<u32>(), any::<bool>(), any::<[u64; FIGURES_WORDS]>())
                .prop_map(|(name, pid, runs, words)| ProcessPicture {
                    name,
                    pid,
                    runs,
                    figures: Figures::get(&words),
                });
        let motion = (0..InstructionKind::ALL.len(), "([A-Za-z]{1,24}(, [A-Z]{1,9})?)?");
        let robot = (name(), 0.0..1e6, joints(), motion).prop_map(
            |(name, time, (demanded, measured), (doing, by))| RobotPicture {
                name,
                time,
                demanded,
                measured,
                tool: Pose::translation(time, -0.25, 1e-9) * Pose::rotation(Vector3::x()),
                doing: InstructionKind::ALL[doing],
                by,
                jogs: time > 0.0,
                stop: JogStop::Joint(doing as u8),
            },
        );
        let cell = (name(), 0..CellState::ALL.len(), any::<[u64; 2]>(), 0.0..=1.0, any::<Option<u8>>())
            .prop_map(|(name, state, [step, period], rate, fault)| CellPicture {
                name,
                state: CellState::ALL[state],
                step,
                period,
                rate,
                speed: 0.5 * rate,
                doing: InstructionKind::Wait,
                by: "Job".to_owned(),
                fault: fault.map(|step| format!("edp arm: drive fault at step {step}")),
            });
        (
            (0..CellState::ALL.len(), any::<[u64; 3]>(), 0.0..=1.0, 0.0..=1.0, any::<[bool; 2]>()),
            (0..InstructionKind::ALL.len(), "[A-Za-z]{0,24}", any::<Option<u32>>(), any::<[Option<u8>; 2]>()),
            proptest::collection::vec(cell, 0..8),
            proptest::collection::vec(process, 0..64),
            proptest::collection::vec(robot, 0..32),
            beside(),
        )
            .prop_map(
                |(
                    (state, n, rate, speed, [reduced, held]),
                    (doing, by, holder, [fault, persisting]),
                    cells,
                    processes,
                    robots,
                    (carried, readings, bodies),
                )| {
                    Picture {
                        state: CellState::ALL[state],
                        step: n[0],
                        period: n[1],
                        epoch: n[2] as u32,
                        instructions: n[2],
                        rate,
                        speed,
                        reduced,
                        held,
                        doing: InstructionKind::ALL[doing],
                        by,
                        holder,
                        help: fault.map(|_| "give the motion more time".to_owned()),
                        fault: fault.map(|step| format!("mp: protective stop: gone at step {step}")),
                        persisting: persisting.map(|step| format!("edp: drive fault at step {step}")),
                        cells,
                        processes,
                        robots,
                        carried,
                        readings,
                        bodies,
                    }
                },
            )
    }

    proptest! {
        #[test]
        fn a_picture_is_read_as_it_was_written(picture in picture()) {
            let text = picture.to_string();
            prop_assert_eq!(ConsoleMessage::read(&mut text.as_bytes()).expect("a picture"), Some(ConsoleMessage::Picture(Box::new(picture))));
        }

        #[test]
        fn a_picture_that_is_cut_anywhere_is_none(picture in picture(), cut in any::<prop::sample::Index>()) {
            let text = picture.to_string();
            let heard = ConsoleMessage::read(&mut &text.as_bytes()[..cut.index(text.len())]);
            prop_assert!(matches!(heard, Ok(None) | Err(_)), "{heard:?}");
        }

        #[test]
        fn garbage_is_refused_by_both_sides_in_lines_of_their_own(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            if let Err(refused) = Request::read(&bytes) {
                prop_assert!(!refused.contains('\n') && refused.len() < 2000, "{refused}");
            }
            let _ = ConsoleMessage::read(&mut bytes.as_slice());
        }

        #[test]
        fn a_damaged_picture_is_read_without_harm(picture in picture(), at in any::<prop::sample::Index>(), byte in any::<u8>()) {
            let mut bytes = picture.to_string().into_bytes();
            let at = at.index(bytes.len());
            bytes[at] = byte;
            let _ = ConsoleMessage::read(&mut bytes.as_slice());
        }
    }

    #[test]
    fn the_picture_of_the_largest_cell_is_read_as_it_was_written_and_waits_for_a_console_as_a_whole() {
        let longest = "n".repeat(24);
        let process = |_| ProcessPicture {
            name: format!("ecp {longest}"),
            pid: u32::MAX,
            runs: false,
            figures: Figures::get(&[u64::MAX; FIGURES_WORDS]),
        };
        let joints = || vec![-1.234_567_890_123_456_7e-300; MAX_JOINTS];
        let robot = |_| RobotPicture {
            name: longest.clone(),
            time: 1e9,
            demanded: joints(),
            measured: joints(),
            tool: Pose::translation(-1e-300 / 3.0, -1e-300 / 3.0, -1e-300 / 3.0),
            doing: InstructionKind::Nothing,
            by: "G".repeat(72),
            jogs: false,
            stop: JogStop::Joint(u8::MAX),
        };
        let least = -1.234_567_890_123_456_7e-300;
        let place = Pose::translation(least, least, least);
        let carried = |_| CarriedPicture {
            robot: longest.clone(),
            tool: place,
            load: Some(Load::point(1.0, Vector3::repeat(least))),
            signals: Signals {
                inputs: Values::new(u32::MAX, [least; 4]),
                outputs: Values::new(0, [least; 4]),
            },
        };
        // Each process that is not of a robot may be of a sensor.
        let reading = |_| ReadingPicture {
            sensor: longest.clone(),
            step: u64::MAX,
            words: Some(vec![u64::MAX; WORDS]),
        };
        let picture = Picture {
            carried: (0..MAX_PROCESSES / 2).map(carried).collect(),
            readings: (0..MAX_PROCESSES).map(reading).collect(),
            bodies: (0..BODIES).map(|place_of| BodyPicture { place: place_of, pose: place }).collect(),
            processes: (0..MAX_PROCESSES).map(process).collect(),
            robots: (0..MAX_PROCESSES / 2).map(robot).collect(),
            ..Picture::default()
        };
        let text = picture.to_string();
        assert!(text.len() <= MAX_ANSWER, "{}", text.len());
        assert_eq!(
            ConsoleMessage::read(&mut text.as_bytes()).expect("a picture"),
            Some(ConsoleMessage::Picture(Box::new(picture)))
        );
    }

    #[test]
    fn what_has_no_end_is_given_up() {
        let huge = vec![b'x'; 2 * MAX_ANSWER];
        assert!(ConsoleMessage::read(&mut huge.as_slice()).is_err());
        let deep = "picture ".to_owned() + &"[".repeat(MAX_ANSWER / 2) + "\n";
        assert!(ConsoleMessage::read(&mut deep.as_bytes()).is_err());
    }
}
