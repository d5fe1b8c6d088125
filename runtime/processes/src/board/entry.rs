//! What processes write in their entries of the state board, and what consoles read there.
//!
//! In: the state of an MP or an ECP, a servo period of a robot and what it carries, a reading, where bodies are. Out: the words of an entry, and from these words the same
//! values again.

use super::state_board::ENTRY;
use mrroc_core::fault::{Fault, FaultWords};
use mrroc_core::generator::TypeName;
use mrroc_core::observe::Observation;
use mrroc_core::operator::CellState;
use mrroc_core::operator::button::{Button, Pressed};
use mrroc_core::operator::jog::{JogRefusal, JogStop};
use mrroc_core::operator::state::{EcpState, EdpState, InstructionKind, MpState, VspState};
use mrroc_core::payload::{WORDS, Wire};
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Load, MAX_JOINTS, Signals};

/// Where the answers begin in the entry of an MP; the fault, the name of the generator and what forbids a reset follow.
const ANSWERS: usize = 14;
const FAULT: usize = ANSWERS + 4 * Button::KINDS;
const NAME: usize = FAULT + 1 + FaultWords::LEN;

/// Bytes of a name.
const NAME_BYTES: usize = 72;

/// Where what forbids a reset stands, behind the name.
const PERSISTING: usize = NAME + 1 + NAME_BYTES / 8;

const _: () = assert!(PERSISTING + 1 + FaultWords::LEN <= ENTRY, "the state of an MP fits on a entry");
/// Where the pose of a robot's tool stands in its entry.
const TOOL: usize = 2 + 2 * MAX_JOINTS;

const _: () = assert!(TOOL + Pose::LEN <= ENTRY, "and so does a robot's");

/// The words of an MP's state.
pub(crate) fn of_mp(state: &MpState) -> [u64; ENTRY] {
    let mut words = [0; ENTRY];
    words[..ANSWERS].copy_from_slice(&[
        state.step,
        state.period,
        state.instructions,
        state.doing as u64,
        state.rate.to_bits(),
        state.speed.to_bits(),
        state.state as u64,
        u64::from(state.reduced),
        u64::from(state.held),
        u64::from(state.epoch),
        state.jogs[0],
        state.jogs[1],
        state.jogged.map_or(0, |(place, _)| u64::from(place) + 1),
        state.jogged.map_or(0, |(_, stop)| stop.to_word()),
    ]);
    for (answer, words) in state.answers.iter().zip(words[ANSWERS..FAULT].chunks_exact_mut(4)) {
        words.copy_from_slice(&[answer.number, answer.step, answer.state as u64, outcome(answer)]);
    }
    put_fault(&mut words[FAULT..NAME], state.fault.as_ref());
    put_name(&mut words[NAME..PERSISTING], state.by);
    put_fault(&mut words[PERSISTING..], state.persisting.as_ref());
    words
}

/// What became of a press, in a word: 1 if it was carried out, 0 if it was refused, and from 2 on why a jog was.
fn outcome(answer: &Pressed) -> u64 {
    answer.why.map_or(u64::from(answer.done), |why| why as u64 + 2)
}

/// Puts a fault behind a word that says whether there is one.
fn put_fault(words: &mut [u64], fault: Option<&FaultWords>) {
    if let Some(fault) = fault {
        words[0] = 1;
        fault.put(&mut words[1..]);
    }
}

fn fault(words: &[u64]) -> Option<Fault> {
    (words[0] == 1).then(|| FaultWords::get(&words[1..]).ok()).flatten().map(Fault::from)
}

/// The words of the state of an ECP's program.
pub(crate) fn of_ecp(state: &EcpState) -> [u64; ENTRY] {
    let mut words = [0; ENTRY];
    words[0] = state.doing as u64;
    put_name(&mut words[1..], state.by);
    words[STOP] = state.stop.to_word();
    words
}

/// Where an ECP says why its robot stands though it is jogged, behind the name.
const STOP: usize = 2 + NAME_BYTES / 8;

/// What the entry of an ECP says: what its program does, the generator or condition of its last instruction, and why its robot
/// stands though it is jogged.
pub(crate) fn ecp(words: &[u64; ENTRY]) -> (InstructionKind, String, JogStop) {
    (
        InstructionKind::from_word(words[0]).unwrap_or_default(),
        name(&words[1..STOP]),
        JogStop::from_word(words[STOP]),
    )
}

/// Puts the length of a name, and its first bytes, without allocation.
fn put_name(words: &mut [u64], name: TypeName) {
    let (bytes, length) = name.bytes::<NAME_BYTES>();
    words[0] = length as u64;
    for (word, chunk) in words[1..].iter_mut().zip(bytes.as_chunks::<8>().0) {
        *word = u64::from_le_bytes(*chunk);
    }
}

fn name(words: &[u64]) -> String {
    let bytes: Vec<_> = words[1..].iter().flat_map(|word| word.to_le_bytes()).collect();
    let length = usize::try_from(words[0]).unwrap_or(0).min(NAME_BYTES);
    String::from_utf8_lossy(&bytes[..length]).into_owned()
}

/// What the entry of an MP contains.
#[derive(Clone, Debug, Default)]
pub(crate) struct MpPanel {
    pub step: u64,
    pub period: u64,
    pub epoch: u32,
    pub instructions: u64,
    pub doing: InstructionKind,
    pub by: String,
    pub rate: f64,
    pub speed: f64,
    pub reduced: bool,
    pub held: bool,
    pub state: CellState,
    /// Which robots may be jogged now, by their places, and why one stands.
    pub jogs: [u64; 2],
    pub jogged: Option<(usize, JogStop)>,
    pub answers: [Pressed; Button::KINDS],
    pub fault: Option<Fault>,
    pub persisting: Option<Fault>,
}

impl MpPanel {
    /// Reads an entry. Words that have no valid meaning are read as absent.
    pub fn read(words: &[u64; ENTRY]) -> MpPanel {
        let state = |word| CellState::from_word(word).unwrap_or_default();
        let mut answers = [Pressed::default(); Button::KINDS];
        for (answer, words) in answers.iter_mut().zip(words[ANSWERS..FAULT].chunks_exact(4)) {
            let why = usize::try_from(words[3]).ok().and_then(|word| word.checked_sub(2));
            let why = why.and_then(|place| JogRefusal::ALL.get(place)).copied();
            let (number, step, state, done) = (words[0], words[1], state(words[2]), words[3] == 1);
            *answer = Pressed { number, step, state, done, why };
        }
        MpPanel {
            step: words[0],
            period: words[1],
            epoch: words[9] as u32,
            instructions: words[2],
            doing: InstructionKind::from_word(words[3]).unwrap_or_default(),
            by: name(&words[NAME..PERSISTING]),
            rate: f64::from_bits(words[4]),
            speed: f64::from_bits(words[5]),
            state: state(words[6]),
            reduced: words[7] == 1,
            held: words[8] == 1,
            jogs: [words[10], words[11]],
            jogged: usize::try_from(words[12])
                .ok()
                .and_then(|place| Some((place.checked_sub(1)?, JogStop::from_word(words[13])))),
            answers,
            fault: fault(&words[FAULT..NAME]),
            persisting: fault(&words[PERSISTING..]),
        }
    }
}

/// The words of a robot's servo period: its time, its joints as demanded and as measured, and the pose of its tool.
pub(crate) fn of_robot(seen: &Observation<'_>) -> [u64; CARRIED] {
    let mut words = [0; CARRIED];
    let joints = seen.demanded.len().min(MAX_JOINTS);
    (words[0], words[1]) = (seen.time.to_bits(), joints as u64);
    for (word, q) in words[2..].iter_mut().zip(seen.demanded.iter().chain(seen.measured)) {
        *word = q.to_bits();
    }
    seen.tool.put(&mut words[TOOL..]);
    words
}

/// Where what a robot carries stands in the entry of its EDP, and its inputs and outputs behind that.
pub(crate) const CARRIED: usize = TOOL + Pose::LEN;
/// In it: 1 once it is written, the tool, 1 if there is a load, the load, inputs and outputs.
const LOAD: usize = 1 + Pose::LEN;
const SIGNALS: usize = LOAD + 1 + Load::LEN;
const CARRIED_WORDS: usize = SIGNALS + Signals::LEN;

const _: () = assert!(CARRIED + CARRIED_WORDS <= ENTRY, "and what it carries");

/// The words of what a robot carries, and of its inputs and outputs.
pub(crate) fn of_edp(state: &EdpState<'_>) -> [u64; CARRIED_WORDS] {
    let mut words = [0; CARRIED_WORDS];
    words[0] = 1;
    state.tool.put(&mut words[1..]);
    if let Some(load) = state.load {
        words[LOAD] = 1;
        load.put(&mut words[LOAD + 1..]);
    }
    state.signals.put(&mut words[SIGNALS..]);
    words
}

/// What the entry of an EDP says of what its robot carries, and of its inputs and outputs; `None` before its first step.
pub(crate) fn carried(words: &[u64; ENTRY]) -> Option<(Pose, Option<Load>, Signals)> {
    let words = &words[CARRIED..CARRIED + CARRIED_WORDS];
    if words[0] != 1 {
        return None;
    }
    let load = (words[LOAD] == 1).then(|| Load::get(&words[LOAD + 1..]).ok()).flatten();
    Some((Pose::get(&words[1..]).ok()?, load, Signals::get(&words[SIGNALS..]).ok()?))
}

/// The words of a reading: the step in which it was taken, how many words it has, and 1; or 0 for a fault, and 2.
pub(crate) fn of_vsp(state: &VspState<'_>) -> [u64; READING + WORDS] {
    let mut words = [0; READING + WORDS];
    let shown = state.words.unwrap_or_default();
    let len = shown.len().min(WORDS);
    let kind = if state.words.is_some() { 1 } else { 2 };
    words[..READING].copy_from_slice(&[kind, state.step, len as u64]);
    words[READING..READING + len].copy_from_slice(&shown[..len]);
    words
}

/// Where the words of a reading begin in the entry of a VSP.
const READING: usize = 3;

const _: () = assert!(READING + WORDS <= ENTRY, "and a reading");

/// The newest reading in the entry of a VSP: the step in which it was taken, and its words, or `None` where there was a fault
/// instead. `None` before the first one.
pub(crate) fn reading(words: &[u64; ENTRY]) -> Option<(u64, Option<Vec<u64>>)> {
    let len = usize::try_from(words[2]).ok().filter(|len| *len <= WORDS)?;
    match words[0] {
        1 => Some((words[1], Some(words[READING..READING + len].to_vec()))),
        2 => Some((words[1], None)),
        _ => None,
    }
}

/// The most bodies that the plant shows in its entry.
pub(crate) const BODIES: usize = ENTRY / (1 + Pose::LEN);

/// Where the words of a body begin in the entry of the plant; the first of them is 1.
pub(crate) const fn body(place: usize) -> usize {
    place * (1 + Pose::LEN)
}

/// Where the body at a place is, by the entry of the plant, `X_WB`; `None`: nobody has said so.
pub(crate) fn body_at(words: &[u64; ENTRY], place: usize) -> Option<Pose> {
    let words = words.get(body(place)..body(place) + 1 + Pose::LEN)?;
    (words[0] == 1).then(|| Pose::get(&words[1..]).ok()).flatten()
}

/// What the entry of an EDP says.
pub(crate) struct RobotEntry {
    /// The time \[s\].
    pub time: f64,
    /// Demanded and measured joint positions [rad or m].
    pub demanded: Vec<f64>,
    pub measured: Vec<f64>,
    /// The pose of its tool at the measured joints, `X_WE`.
    pub tool: Pose,
}

impl RobotEntry {
    /// Reads an entry. A pose that is none is read as that of the origin. `None` before the first servo period.
    pub fn read(words: &[u64; ENTRY]) -> Option<RobotEntry> {
        if words[0] == 0 {
            return None;
        }
        let joints = usize::try_from(words[1]).unwrap_or(0).min(MAX_JOINTS);
        let numbers =
            |from: usize| words[from..from + joints].iter().map(|word| f64::from_bits(*word)).collect();
        Some(RobotEntry {
            time: f64::from_bits(words[0]),
            demanded: numbers(2),
            measured: numbers(2 + joints),
            tool: Pose::get(&words[TOOL..]).unwrap_or_else(|_| Pose::identity()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::fault::{FaultKind, ProcessId};
    use mrroc_core::nalgebra::Vector3;
    use mrroc_core::robot::Values;

    struct Dwell<T>(T);
    struct AConditionWithANameThatHasMoreThanSeventyTwoBytesAsNobodyWouldEverWriteOneInEarnest;

    #[test]
    fn the_state_of_an_ecp_is_read_as_it_was_written_and_a_name_that_is_too_long_as_far_as_it_fits() {
        let by = TypeName::of::<Dwell<u8>>();
        let stop = JogStop::Joint(3);
        let read = ecp(&of_ecp(&EcpState { doing: InstructionKind::Wait, by, stop }));
        assert_eq!(read, (InstructionKind::Wait, "Dwell".to_owned(), stop));
        let by = TypeName::of::<
            AConditionWithANameThatHasMoreThanSeventyTwoBytesAsNobodyWouldEverWriteOneInEarnest,
        >();
        let (_, read, _) =
            ecp(&of_ecp(&EcpState { doing: InstructionKind::Wait, by, ..EcpState::default() }));
        assert!(read.len() == NAME_BYTES && by.to_string().starts_with(&read), "{read}");
        assert_eq!(ecp(&[u64::MAX; ENTRY]).0, InstructionKind::Nothing);
    }

    #[test]
    fn the_state_of_an_mp_is_read_as_it_was_written() {
        let fault = Fault::new(FaultKind::PeerLost).in_process(ProcessId::MP).at_step(7).text("gone");
        let persisting = Fault::new(FaultKind::DriveFault).in_process(ProcessId::PLANT).text("brake");
        let answer = Pressed { number: 3, step: 9, state: CellState::Stopping, done: true, why: None };
        let mut state = MpState {
            step: 1,
            period: 2,
            epoch: 4,
            instructions: 6,
            doing: InstructionKind::Wait,
            by: TypeName::of::<Dwell<u8>>(),
            rate: 0.25,
            speed: 0.5,
            state: CellState::Suspended,
            fault: Some(FaultWords::from(&fault)),
            persisting: Some(FaultWords::from(&persisting)),
            ..MpState::default()
        };
        state.answers[Button::Speed(0.0).kind()] = answer;
        state.answers[10] = Pressed { done: false, why: Some(JogRefusal::OthersMove), ..answer };
        (state.jogs, state.jogged) = ([5, 1 << 63], Some((2, JogStop::Kinematics)));
        let read = MpPanel::read(&of_mp(&state));
        assert_eq!((read.step, read.period, read.epoch), (1, 2, 4));
        assert_eq!((read.instructions, read.doing, read.by.as_str()), (6, InstructionKind::Wait, "Dwell"));
        assert_eq!((read.rate, read.speed, read.state), (0.25, 0.5, CellState::Suspended));
        assert_eq!(read.answers, state.answers);
        assert_eq!((read.jogs, read.jogged), ([5, 1 << 63], Some((2, JogStop::Kinematics))));
        assert_eq!((read.fault, read.persisting), (Some(fault), Some(persisting)));
    }

    #[test]
    fn words_that_spell_nothing_are_read_without_harm() {
        let read = MpPanel::read(&[u64::MAX; ENTRY]);
        assert_eq!((read.doing, read.state, read.fault), (InstructionKind::Nothing, CellState::Idle, None));
        assert!(read.answers.iter().all(|answer| !answer.done));
        assert_eq!(RobotEntry::read(&[u64::MAX; ENTRY]).expect("words").demanded.len(), MAX_JOINTS);
        assert!(carried(&[u64::MAX; ENTRY]).is_none() && reading(&[u64::MAX; ENTRY]).is_none());
        assert!((0..=BODIES).all(|place| body_at(&[u64::MAX; ENTRY], place).is_none()));
        assert!(RobotEntry::read(&[0; ENTRY]).is_none() && carried(&[0; ENTRY]).is_none());
        assert!(reading(&[0; ENTRY]).is_none() && body_at(&[0; ENTRY], 0).is_none());
    }

    #[test]
    fn what_a_robot_carries_a_reading_and_bodies_are_read_as_they_were_written() {
        let mut words = [0; ENTRY];
        let tool = Pose::translation(0.0, 0.1, 0.2);
        let load = Load::point(1.5, Vector3::new(0.0, 0.0, 0.05));
        let signals = Signals { inputs: Values::new(5, [0.5; 4]), outputs: Values::new(1 << 31, [-1.0; 4]) };
        let state = EdpState { tool: &tool, load: Some(&load), signals: &signals };
        words[CARRIED..CARRIED + CARRIED_WORDS].copy_from_slice(&of_edp(&state));
        assert_eq!(carried(&words), Some((tool, Some(load), signals)));
        words[CARRIED..CARRIED + CARRIED_WORDS].copy_from_slice(&of_edp(&EdpState { load: None, ..state }));
        assert_eq!(carried(&words), Some((tool, None, signals)));

        let shown = |state: &VspState<'_>| {
            let mut words = [0; ENTRY];
            words[..READING + WORDS].copy_from_slice(&of_vsp(state));
            reading(&words)
        };
        assert_eq!(shown(&VspState { step: 7, words: Some(&[1, 2]) }), Some((7, Some(vec![1, 2]))));
        assert_eq!(shown(&VspState { step: 8, words: None }), Some((8, None)));

        let mut words = [0; ENTRY];
        words[body(BODIES - 1)] = 1;
        tool.put(&mut words[body(BODIES - 1) + 1..]);
        assert_eq!((body_at(&words, BODIES - 1), body_at(&words, 0)), (Some(tool), None));
    }
}
