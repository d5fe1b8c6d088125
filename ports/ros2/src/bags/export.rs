//! A recording of a cell as a bag.
//!
//! In: the messages of a recording. Out: those that the bridge would have published while it ran, by the same functions, at the times of the cell.

use std::path::Path;

use mrroc_core::console::complain;
use mrroc_core::fault::ProcessId;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::{ReadingState, StepRecord};
use mrroc_core::operator::CellState;
use mrroc_core::operator::state::InstructionKind;
use mrroc_processes::Picture;
use mrroc_recording::{Completeness, RecordedMessage, Sample, each_message_of};

use super::file::Bag;
use crate::clock::CellClock;
use crate::diagnostics;
use crate::show::Topics;

/// The time between two diagnostics in which nothing new is told \[ns of the cell\].
const DIAGNOSED: u64 = diagnostics::EVERY.as_nanos() as u64;

/// What goes into a bag.
struct Export<'a> {
    layout: &'a Layout,
    bag: &'a Bag,
    topics: Topics<Bag>,
    /// What is known of the cell.
    picture: Picture,
    is_suspended: bool,
    stop: Stop,
    diagnosed: Option<(u64, CellState, Option<String>)>,
}

/// How far a stop of the cell has come: steps say of a stop or a reset alone that it was asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stop {
    /// None is at work.
    No,
    /// It was asked for.
    Stopping,
    /// The fault is latched.
    Latched,
    /// A reset was asked for, and no instruction has begun yet.
    Resetting,
}

/// Writes a recording of a cell, which has these robots with their URDFs, as a bag into a folder that is not there yet. `node` is the name of the
/// node whose topics they would be.
///
/// # Errors
/// What is wrong with the recording, or why the bag cannot be written.
pub fn export(
    recording: &Path,
    folder: &Path,
    node: &str,
    layout: &Layout,
    urdfs: &[(String, Option<String>)],
) -> Result<(), String> {
    let mut bag = Bag::create(folder, node)?;
    let written = write(recording, &mut bag, layout, urdfs).and_then(|has| Ok((has, bag.finish()?)));
    let (has, [messages, topics]) = written.inspect_err(|_| bag.discard())?;
    if has.cut_off {
        complain("warning: the recording was cut off: the bag has what there is");
    }
    if has.dropped > 0 {
        complain(&format!(
            "warning: {} records were dropped while the recording was written: the bag lacks them",
            has.dropped
        ));
    }
    complain(&format!("wrote {}: {messages} messages of {topics} topics", folder.display()));
    Ok(())
}

fn write(
    recording: &Path,
    bag: &mut Bag,
    layout: &Layout,
    urdfs: &[(String, Option<String>)],
) -> Result<Completeness, String> {
    let failed = |why: &str| format!("{}: {why}", recording.display());
    // The topics begin at the date of the first message.
    let mut bag = Some(bag);
    let mut exported: Result<Option<Export<'_>>, String> = Ok(None);
    let take = |message: RecordedMessage<'_>| {
        if let Some(bag) = bag.take() {
            exported = Export::open(bag, layout, urdfs, message.start).map(Some);
        }
        if let Ok(Some(export)) = &mut exported
            && export.take(&message).is_none()
        {
            let what = format!("a message in {} at {} ns does not fit", message.topic, message.time);
            exported = Err(failed(&what));
        }
    };
    let has = each_message_of(recording, layout, take).map_err(|wrong| wrong.to_string())?;
    match exported? {
        Some(_) => Ok(has),
        None => Err(failed("has no message\n help: record a run that moves something")),
    }
}

impl<'a> Export<'a> {
    /// The topics of a cell of this layout, at the date of its time 0 \[ns since 1970\].
    fn open(
        bag: &'a mut Bag,
        layout: &'a Layout,
        urdfs: &[(String, Option<String>)],
        start: u64,
    ) -> Result<Self, String> {
        bag.set_now(start);
        let topics = Topics::open(bag, layout, urdfs, CellClock::since(start))?;
        Ok(Export {
            layout,
            bag,
            topics,
            picture: Picture::default(),
            is_suspended: false,
            stop: Stop::No,
            diagnosed: None,
        })
    }

    /// Takes a message; `None`: it does not fit. What has no topic here is passed over, as are robots and sensors of lower cells.
    fn take(&mut self, message: &RecordedMessage<'_>) -> Option<()> {
        self.bag.set_now(message.start + message.time);
        match message.sample(self.layout)? {
            Sample::Image(image) => {
                let time = self.time_of(image.step, message.start)?;
                let states = [&image.measured, &image.demanded].map(|of| [&*of.joints, &*of.velocity]);
                self.topics.joint_states(image.robot, image.step, time, states);
            }
            Sample::Signals { robot, signals, .. } => {
                self.topics.signals(&self.layout.robots[robot].name, &signals);
            }
            Sample::Reading { sensor, step, taken, state: ReadingState::There, words, .. } => {
                let time = self.time_of(step, message.start)?;
                self.topics.reading(&self.layout.sensors[sensor].name, [step, taken], time, &words);
            }
            Sample::Step(record) => self.step(message, &record),
            Sample::Instruction { process: ProcessId::MP, doing, by } => self.instruction(doing, by),
            Sample::Event { process: ProcessId::MP, what, text, .. } if !text.is_empty() => {
                self.event(message, &what, text);
            }
            _ => {}
        }
        Some(())
    }

    /// The time of a step \[ns\]; `None` of one so far off that its date, or that of what follows, would overflow.
    fn time_of(&self, step: u64, start: u64) -> Option<u64> {
        let time = step.checked_mul(self.layout.step.as_nanos() as u64)?;
        start.checked_add(time)?.checked_add(DIAGNOSED)?;
        Some(time)
    }

    fn step(&mut self, message: &RecordedMessage<'_>, record: &StepRecord) {
        self.picture.step = record.step;
        self.picture.speed = record.speed;
        self.picture.reduced = record.reduced;
        self.picture.rate = if record.duration > 0.0 { record.dt / record.duration } else { 0.0 };
        self.is_suspended = record.suspended;
        self.stop = match self.stop {
            Stop::No if record.stopping => Stop::Stopping,
            Stop::Latched if record.resetting => Stop::Resetting,
            stop => stop,
        };
        self.picture.state = match self.stop {
            Stop::No if record.aborting => CellState::Aborting,
            Stop::No => self.at_work(),
            Stop::Stopping => CellState::Stopping,
            Stop::Latched => CellState::Latched,
            Stop::Resetting => CellState::Resetting,
        };
        self.tell(message);
    }

    /// What a cell that nothing has stopped does.
    fn at_work(&self) -> CellState {
        match (self.picture.doing, self.is_suspended) {
            (InstructionKind::Nothing, _) => CellState::Idle,
            (_, true) => CellState::Suspended,
            (_, false) => CellState::Running,
        }
    }

    /// An instruction of the MP that begins or ends.
    fn instruction(&mut self, doing: InstructionKind, by: String) {
        (self.picture.doing, self.picture.by) = (doing, by);
        if doing != InstructionKind::Nothing {
            self.stop = Stop::No;
            self.picture.instructions += 1;
        }
        self.topics.instruction(&self.picture);
    }

    /// Something that stops the MP, or ends it.
    fn event(&mut self, message: &RecordedMessage<'_>, what: &str, text: String) {
        match what {
            "fault" | "fault from outside" => {
                self.picture.fault = Some(text);
                self.picture.state = CellState::Latched;
                self.stop = Stop::Latched;
                self.tell(message);
            }
            // It may have ended in order, such as by an operator who aborted its program.
            "end" => {
                self.picture.fault.get_or_insert(text);
                self.tell(message);
            }
            _ => {}
        }
    }

    /// Publishes what is known of the cell: its state when that changes, its diagnostics as often as the bridge does.
    fn tell(&mut self, message: &RecordedMessage<'_>) {
        self.topics.state(self.picture.state.word());
        let is_due = self.diagnosed.as_ref().is_none_or(|(last, state, fault)| {
            message.time.saturating_sub(*last) >= DIAGNOSED
                || *state != self.picture.state
                || *fault != self.picture.fault
        });
        if is_due {
            self.diagnosed = Some((message.time, self.picture.state, self.picture.fault.clone()));
            self.topics.diagnose(&self.picture, message.start + message.time);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mrroc_core::observe::layout::{HardwareLayout, SensorLayout};
    use mrroc_core::payload::Shape;
    use mrroc_core::sensor::VspMode;
    use mrroc_launch::cell_file::CellFile;
    use mrroc_recording::each_mcap_message;
    use mrroc_robots::simulated;

    use super::*;

    const CELL: &str = r#"
step_ms = 2
robots.arm = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }
"#;

    /// Its topics, opened below a folder, and the states of `/cell/state` that it has after these messages.
    fn states(messages: &[(&str, &str)]) -> Vec<String> {
        let file = CellFile::parse("cell.toml", CELL).expect("nothing is wrong with it");
        let layout = file.cell(&simulated()).expect("nor with this").layout();
        let folder = std::env::temp_dir().join(format!("mrroc-ros2-states-{}", std::process::id()));
        let mut bag = Bag::create(&folder, "cell").expect("a folder");
        let mut export = Export::open(&mut bag, &layout, &[("arm".to_owned(), None)], 5).expect("topics");
        for (time, (topic, json)) in messages.iter().enumerate() {
            let message = RecordedMessage { topic, start: 5, time: time as u64, json: json.as_bytes() };
            export.take(&message).expect("it fits");
        }
        let _counts = bag.finish().expect("written");
        let name = format!("{}_0.mcap", folder.file_name().expect("a name").to_string_lossy());
        let mut states = Vec::new();
        let take = |message: mrroc_recording::McapMessage<'_>| {
            if message.topic == "/cell/state" {
                // Behind the head and the length, and without the zero at the end.
                let text = &message.data[8..message.data.len() - 1];
                states.push(String::from_utf8_lossy(text).into_owned());
            }
            Ok(())
        };
        each_mcap_message(&folder.join(name), take).expect("an MCAP file");
        bag.discard();
        states
    }

    #[test]
    fn sensors_whose_readings_would_have_the_same_topics_are_refused_by_name() {
        let file = CellFile::parse("cell.toml", CELL).expect("nothing is wrong with it");
        let mut layout = file.cell(&simulated()).expect("nor with this").layout();
        layout.sensors.extend(["a-b", "a_b"].map(|name| SensorLayout {
            name: name.to_owned(),
            kind: "number",
            of: None,
            readers: Vec::new(),
            every: 1,
            stale_after: Duration::ZERO,
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
            reading: &Shape::Float,
            reading_layout: 0,
            hardware: HardwareLayout::Nothing,
        }));
        let folder = std::env::temp_dir().join(format!("mrroc-ros2-same-{}", std::process::id()));
        let mut bag = Bag::create(&folder, "cell").expect("a folder");
        let why = Export::open(&mut bag, &layout, &[], 5).err().expect("the same topics");
        bag.discard();
        assert!(
            why.starts_with("sensors `a-b` and `a_b` would have the same topics /sensors/a_b/.."),
            "{why}"
        );
    }

    #[test]
    fn a_stop_lasts_until_the_fault_and_a_reset_until_the_next_instruction() {
        let step = |flag: &str| {
            let of = |name: &str| format!("\"{name}\":{}", name == flag);
            let flags = ["suspended", "reduced", "aborting", "stopping", "resetting"].map(of);
            format!("{{\"step\":1,\"dt\":0.002,\"duration\":0.002,\"speed\":1.0,{}}}", flags.join(","))
        };
        let (plain, suspended) = (step(""), step("suspended"));
        let (stopping, aborting, resetting) = (step("stopping"), step("aborting"), step("resetting"));
        let begins = r#"{"process":"mp","doing":"move","by":"Line"}"#;
        let ends = r#"{"process":"mp","doing":"nothing","by":"Line"}"#;
        let fault = r#"{"process":"mp","step":1,"what":"fault","text":"mp: protective stop"}"#;
        let outside = r#"{"process":"mp","step":1,"what":"fault from outside","text":"edp arm: the drive of joint 2 has failed"}"#;
        let end = r#"{"process":"mp","step":1,"what":"end","text":"mp: aborted"}"#;
        let found = states(&[
            ("/steps", &plain),
            ("/instructions", begins),
            ("/steps", &plain),
            ("/steps", &suspended),
            ("/steps", &plain),
            ("/steps", &stopping),
            // What robots do until they rest.
            ("/steps", &plain),
            ("/events", fault),
            ("/instructions", ends),
            ("/steps", &plain),
            ("/steps", &resetting),
            ("/steps", &plain),
            ("/instructions", begins),
            ("/steps", &plain),
            ("/steps", &stopping),
            ("/events", outside),
            ("/steps", &resetting),
            ("/instructions", begins),
            ("/steps", &aborting),
            ("/events", end),
        ]);
        let expected = [
            "idle",
            "running",
            "suspended",
            "running",
            "stopping",
            "latched",
            "resetting",
            "running",
            "stopping",
            "latched",
            "resetting",
            "aborting",
        ];
        assert_eq!(found, expected);
    }
}
