//! The driver against the simulated instrument, over wires that fail in every way.

use core::time::Duration;
use std::collections::VecDeque;
use std::os::unix::net::UnixStream;

use mrroc::prelude::*;

use super::*;

const AXES: [f64; 3] = [4e-5, -7e-5, 6e-5];
const DIRECTION: [f64; 2] = [0.7, -0.3];

fn instrument() -> Simulated<Targets> {
    Simulated::new(Targets { directions: vec![DIRECTION, [-2.0, 0.1]], axes: AXES })
}

/// A wire to an instrument: what it answers to each question, from 0, is what `spoil` makes of it. Time does not pass.
struct Spoilt<F> {
    instrument: Simulated<Targets>,
    spoil: F,
    asked: usize,
    lines: VecDeque<String>,
}

impl<F: FnMut(usize, String) -> Vec<String>> Spoilt<F> {
    fn new(spoil: F) -> Self {
        Self { instrument: instrument(), spoil, asked: 0, lines: VecDeque::new() }
    }
}

impl<F: FnMut(usize, String) -> Vec<String>> Wire for Spoilt<F> {
    fn send(&mut self, line: &str) -> Result<(), Trouble> {
        if let Some(answer) = self.instrument.answer(line) {
            self.lines.extend((self.spoil)(self.asked, answer));
        }
        self.asked += 1;
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<String>, Trouble> {
        // What is late has not come yet when stale lines are looked for.
        Ok(if patience.is_zero() { None } else { self.lines.pop_front() })
    }
}

fn sight<F: FnMut(usize, String) -> Vec<String>>(spoil: F) -> (Result<Measured, Trouble>, usize) {
    let mut wire = Spoilt::new(spoil);
    let read = Client::new(&mut wire, Patience::default()).sight([0.702, -0.301], Face::Two);
    (read, wire.asked)
}

impl<W: Wire> Wire for &mut W {
    fn send(&mut self, line: &str) -> Result<(), Trouble> {
        (**self).send(line)
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<String>, Trouble> {
        (**self).receive(patience)
    }
}

#[test]
fn the_mean_of_both_faces_is_free_of_the_errors_of_the_axes() {
    let mut wire = Spoilt::new(|_, answer| vec![answer]);
    let mut client = Client::new(&mut wire, Patience::default());
    client.greet().expect("an answer");
    let [one, two] = [Face::One, Face::Two].map(|face| {
        let measured = client.sight([0.702, -0.301], face).expect("a sight");
        assert_eq!(measured.face, face);
        measured.angles
    });
    let [c, i, v0] = AXES;
    let off = c / DIRECTION[1].cos() + i * DIRECTION[1].tan();
    assert!((one[0] - DIRECTION[0] - off).abs() < 1e-12 && (one[1] - DIRECTION[1] - v0).abs() < 1e-12);
    for axis in 0..2 {
        assert!((0.5 * (one[axis] + two[axis]) - DIRECTION[axis]).abs() < 1e-12);
    }
}

#[test]
fn fault_182_what_the_instrument_says_of_itself_is_no_reading_and_says_what_to_do() {
    let mut tilted = Spoilt::new(|_, answer| vec![answer]);
    tilted.instrument.is_level = false;
    let mut client = Client::new(&mut tilted, Patience::default());
    let told = |read: Result<Measured, Trouble>| read.expect_err("no reading").to_string();
    assert!(told(client.measure()).contains("level the instrument"));
    // Once, and not three times: it would say the same.
    assert_eq!(tilted.asked, 1);
    let mut empty = Spoilt::new(|_, answer| vec![answer]);
    let mut client = Client::new(&mut empty, Patience::default());
    let why = told(client.sight([2.0, 0.0], Face::One));
    assert!(why.contains("8710") && why.contains("is the line of sight free"), "{why}");
    // The next sight is one like any other.
    assert!(client.sight([0.7, -0.3], Face::One).is_ok());
}

#[test]
fn fault_183_silence_garbled_lines_and_a_busy_instrument_are_asked_again_three_times_in_all() {
    let (undisturbed, questions) = sight(|_, answer| vec![answer]);
    // The face, a turn over, the face again, a turn, a measurement.
    assert_eq!(questions, 5);
    let busy = |answer: &str| {
        let answer = Answer::parse(answer).expect("an answer");
        Answer { code: Code(1293), values: Vec::new(), ..answer }.to_string()
    };
    for question in 0..questions {
        // Twice in a row any question fails, in any way.
        for way in 0..4 {
            let spoilt = |asked: usize, answer: String| match way {
                _ if !(question..question + 2).contains(&asked) => vec![answer],
                0 => vec![],
                1 => vec![answer.replace("%R1P", "%R!P")],
                2 => vec![answer[..answer.len() / 2].to_owned()],
                _ => vec![busy(&answer)],
            };
            let (read, asked) = sight(spoilt);
            let (read, undisturbed) = (read.expect("a sight"), undisturbed.expect("a sight"));
            assert_eq!(read.face, undisturbed.face);
            assert!((read.angles[0] - undisturbed.angles[0]).abs() < 1e-12, "{question} {way}");
            // A turn over of which no answer came is asked for no more where the face says that it is done.
            assert!(
                asked == questions + 2 || question < 2 && asked == questions + 1,
                "{question} {way}: {asked}"
            );
        }
    }
    let always = |spoilt: &dyn Fn(&str) -> Vec<String>| sight(|_, answer| spoilt(&answer));
    assert_eq!(always(&|_| vec![]), (Err(Trouble::Silent), 3));
    assert_eq!(always(&|_| vec!["%R1P,0".to_owned()]), (Err(Trouble::Garbled), 3));
    assert_eq!(always(&|answer| vec![busy(answer)]), (Err(Trouble::Refused(Code(1293))), 3));
}

#[test]
fn fault_184_an_answer_to_an_earlier_question_is_never_taken() {
    // The answer to one question comes only with that to the next.
    for late in 0..4 {
        let mut kept = None;
        let (read, _) = sight(|asked, answer| {
            if asked == late {
                kept = Some(answer);
                return vec![];
            }
            kept.take().into_iter().chain([answer]).collect()
        });
        let (undisturbed, _) = sight(|_, answer| vec![answer]);
        assert_eq!(read, undisturbed, "{late}");
    }
}

/// An instrument at the other end of a socket, which answers so many lines and then hangs up.
fn serving(lines: usize) -> UnixStream {
    let (here, there) = UnixStream::pair().expect("a socket");
    std::thread::spawn(move || {
        let (mut line, mut instrument) = (Line::over(there), instrument());
        for _ in 0..lines {
            let Ok(Some(asked)) = line.receive(Duration::from_secs(60)) else { return };
            if let Some(answer) = instrument.answer(&asked) {
                let _ = line.send(&answer);
            }
        }
    });
    here
}

/// Orders a sight until there is something to say of it.
fn ordered(sensor: &mut Theodolite, sight: Sight) -> Result<Angles, Fault> {
    loop {
        let read = sensor.aggregate(&ReadingOrder { configuration: sight, robot: None, step: 0 })?;
        if read.settled {
            return Ok(read);
        }
        std::thread::yield_now();
    }
}

fn patient() -> Patience {
    Patience { answer: Duration::from_secs(60), turn: Duration::from_secs(60), times: 1 }
}

#[test]
fn a_virtual_sensor_reads_what_it_is_told_to_sight() {
    let mut sensor = Theodolite::over(Line::over(serving(1000)), patient()).expect("a sensor");
    for (index, direction, turned) in [(1, DIRECTION, false), (2, DIRECTION, true), (3, [-2.0, 0.1], false)] {
        let [hz, v] = direction;
        let read = ordered(&mut sensor, Sight { index, hz, v, turned }).expect("a reading");
        assert_eq!((read.index, read.turned), (index, turned));
        assert!((read.hz - hz).abs() < 2e-4 && (read.v - v).abs() < 2e-4, "{read:?}");
        assert!(read.hz != hz, "it has errors");
    }
    let why =
        ordered(&mut sensor, Sight { index: 4, hz: 1.0, v: 1.0, turned: false }).expect_err("no target");
    assert!(why.to_string().contains("no target"), "{why}");
    assert!(ordered(&mut sensor, Sight { index: 5, hz: 0.7, v: -0.3, turned: false }).is_ok());
}

#[test]
fn a_program_that_begins_anew_gets_no_reading_of_before() {
    let mut sensor = Theodolite::over(Line::over(serving(1000)), patient()).expect("a sensor");
    let first = Sight { index: 1, hz: -2.0, v: 0.1, turned: false };
    let before = ordered(&mut sensor, first).expect("a reading");
    assert!((before.hz + 2.0).abs() < 2e-4, "{before:?}");
    // The same number, of another target; then the same target, which nothing but an order of no sight makes a new one.
    let [hz, v] = DIRECTION;
    let other = ordered(&mut sensor, Sight { index: 1, hz, v, turned: false }).expect("a reading");
    assert!((other.hz - hz).abs() < 2e-4, "{other:?}");
    let nothing = ReadingOrder { configuration: Sight::default(), robot: None, step: 0 };
    assert!(!sensor.aggregate(&nothing).expect("nothing is wrong").settled);
    let again =
        ReadingOrder { configuration: Sight { index: 1, hz, v, turned: false }, robot: None, step: 0 };
    assert!(!sensor.aggregate(&again).expect("nothing is wrong").settled, "it is sighted anew");
    // What failed is tried again by whoever orders it again.
    let nowhere = Sight { index: 2, hz: 1.0, v: 1.0, turned: false };
    for _ in 0..2 {
        assert!(ordered(&mut sensor, nowhere).is_err_and(|why| why.to_string().contains("no target")));
    }
}

#[test]
fn fault_184_a_telescope_whose_turn_is_not_answered_is_not_turned_back() {
    // The second question turns it over.
    let (read, _) = sight(|asked, answer| if asked == 1 { vec![] } else { vec![answer] });
    assert_eq!(read.map(|read| read.face), Ok(Face::Two));
}

#[test]
fn fault_185_a_line_that_is_closed_is_a_fault_and_never_a_reading() {
    // In each of the five lines of a greeting and a sight.
    for lines in 1..5 {
        let mut sensor = Theodolite::over(Line::over(serving(lines)), patient()).expect("a sensor");
        let [hz, v] = DIRECTION;
        let why = ordered(&mut sensor, Sight { index: 1, hz, v, turned: true }).expect_err("closed");
        assert!(why.to_string().contains("closed"), "{why}");
    }
    assert!(matches!(Theodolite::over(Line::over(serving(0)), patient()), Err(Trouble::Closed)));
}
