//! What a console and the console server of a cell write to each other: lines of text.
//!
//! In: one [request](mrroc_core::operator::request) a line; a console reads the answer before it sends the next one. Out: an answer in one
//! line, `done TEXT`, `refused TEXT` or `pending TEXT`; or a picture in one line, `picture JSON`.

use std::io::{self, BufRead, ErrorKind};

use super::picture::Picture;
use mrroc_core::operator::Answer;

/// The name of the console server's socket in a session's folder.
pub(super) const SOCKET: &str = "operator";

/// The longest request, without its line end \[bytes\].
pub(super) const MAX_REQUEST: usize = 450;

/// The longest line that a console reads, and how much unread text may wait for it \[bytes\].
pub(super) const MAX_ANSWER: usize = 1 << 19;

/// What a console receives.
#[derive(Clone, Debug, PartialEq)]
pub enum ConsoleMessage {
    /// The answer to a request.
    Answer(Answer),
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
        let Some(picture) = line.strip_prefix("picture ") else {
            return Answer::read(&line).map(ConsoleMessage::Answer).map(Some).ok_or_else(|| bad(&line));
        };
        let picture = serde_json::from_str(picture);
        picture
            .map(ConsoleMessage::Picture)
            .map(Some)
            .map_err(|error| io::Error::new(ErrorKind::InvalidData, error))
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
    use mrroc_core::fault::Name;
    use mrroc_core::link::places::MAX_PROCESSES;
    use mrroc_core::nalgebra::Vector3;
    use mrroc_core::operator::jog::JogStop;
    use mrroc_core::operator::request::Addressed;
    use mrroc_core::operator::state::InstructionKind;
    use mrroc_core::operator::{CellState, OnBehalf, Request};
    use mrroc_core::payload::WORDS;
    use mrroc_core::pose::Pose;
    use mrroc_core::robot::{Load, MAX_JOINTS, Signals, Values};
    use proptest::prelude::*;

    #[test]
    fn the_longest_request_is_no_longer_than_one_may_be() {
        let (by, cell) =
            (OnBehalf { page: u64::MAX, heard: u64::MAX }, Name::of_process(&"x".repeat(24)).ok());
        let order = format!("to 12.123456789%{}", " -1.2345678901234567e-300".repeat(MAX_JOINTS));
        let jog = format!("jog {} {} {} {order}", u64::MAX >> 16, u16::MAX, "x".repeat(24));
        let request = Request::read(&jog).expect("a jog");
        assert!(Addressed { by: Some(by), cell, request }.to_string().len() <= MAX_REQUEST);
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
            if let Err(refused) = Addressed::read(&String::from_utf8_lossy(&bytes)).map_err(|refused| refused.in_a_line()) {
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
