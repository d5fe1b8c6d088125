//! The messages of a recording, made into a [`RecordedRun`].
//!
//! In: the metadata, then what messages say. Out: for each robot its images without a gap, for each process
//! the readings that it collected of each sensor, and the steps of the MP.

use std::collections::BTreeSet;
use std::rc::Rc;

use mcap::records::Metadata;
use serde_json::Value;

use super::samples::{RecordedMessage, RobotSample, Sample, StateSample};
use super::wrong::{CutOff, Wrong};
use mrroc_core::console::quoted;
use mrroc_core::fault::Name;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::StepRecord;
use mrroc_core::operator::jog::JogNow;
use mrroc_core::replay::readings::RecordedReading;
use mrroc_core::replay::script::{ScriptedJog, ScriptedStep};
use mrroc_core::replay::{
    LateRequest, RecordedImage, RecordedReadings, RecordedRobot, RecordedRun, RecordedValue, RecordedValues,
    Script,
};
use mrroc_core::robot::{MAX_JOINTS, Measured, Signals};

/// The messages read so far.
pub(super) struct Messages {
    robots: Vec<RecordedRobot>,
    sensors: Vec<Name>,
    readings: Vec<RecordedReadings>,
    steps: Vec<ScriptedStep>,
    /// What programs recorded, by their processes, and how many parts of the last value of each are not read yet.
    values: Vec<(ProcessId, RecordedValues, u32)>,
    jogs: Vec<ScriptedJog>,
    late: BTreeSet<u64>,
    aborts: BTreeSet<u64>,
    outside: Option<(u64, String)>,
    end: Option<Option<String>>,
}

/// The most steps that can lie between two that are recorded, or before the first one: a quarter of an hour of a program that computes, in the
/// shortest steps of 0.1 ms. A replay goes through every step: more than these would keep it at work for what no run has done.
const LONGEST_GAP: u64 = 10_000_000;

const OTHER_CELL: &str = "give the cell that was recorded, with all its robots and sensors";

impl Messages {
    /// Begins to read a recording with this metadata, which must be of the cell with this layout.
    pub fn of(metadata: &Metadata, layout: &Layout) -> Result<Messages, Wrong> {
        let text = |key: &str| metadata.metadata.get(key).map_or("", String::as_str);
        let list = |key: &str| serde_json::from_str::<Vec<Value>>(text(key)).unwrap_or_default();
        let of_cell = |name: &str| Name::new(name).map_err(|bad| Wrong::new(bad.to_string(), OTHER_CELL));
        if text("step_ns") != layout.step.as_nanos().to_string() {
            let what = format!(
                "was recorded with a step of {} ns, the cell's is {}",
                quoted(text("step_ns"), 30),
                layout.step.as_nanos()
            );
            return Err(Wrong::new(what, OTHER_CELL));
        }
        let mut robots = Vec::new();
        let recorded = list("robots");
        for robot in &layout.robots {
            let found = recorded.iter().find(|recorded| recorded["name"] == robot.name);
            let found =
                found.ok_or_else(|| Wrong::new(format!("has no robot `{}`", robot.name), OTHER_CELL))?;
            let (kind, joints) = (found["kind"].as_str(), found["joints"].as_array().map_or(0, Vec::len));
            if kind != Some(robot.kind) || joints != robot.joints.len() {
                let what = format!(
                    "has robot `{}` of the kind {} with {joints} joints, the cell's is of the kind {} with {}",
                    robot.name,
                    quoted(kind.unwrap_or("unknown"), 60),
                    robot.kind,
                    robot.joints.len()
                );
                return Err(Wrong::new(what, OTHER_CELL));
            }
            let name = of_cell(&robot.name)?;
            robots.push(RecordedRobot {
                name,
                joints,
                found: None,
                first: 0,
                images: Vec::new(),
                signals: Vec::new(),
                late: Vec::new(),
                put_off: BTreeSet::new(),
                values: RecordedValues::default(),
            });
        }
        let mut sensors = Vec::new();
        let recorded = list("sensors");
        for sensor in &layout.sensors {
            if !recorded.iter().any(|recorded| recorded["name"] == sensor.name) {
                return Err(Wrong::new(format!("has no sensor `{}`", sensor.name), OTHER_CELL));
            }
            sensors.push(of_cell(&sensor.name)?);
        }
        let (readings, steps, jogs) = (Vec::new(), Vec::new(), Vec::new());
        let (late, aborts) = (BTreeSet::new(), BTreeSet::new());
        Ok(Messages {
            robots,
            sensors,
            readings,
            steps,
            values: Vec::new(),
            jogs,
            late,
            aborts,
            outside: None,
            end: None,
        })
    }

    /// The last step of the MP read so far.
    pub fn last_step(&self) -> u64 {
        self.steps.last().map_or(0, |scripted| scripted.step)
    }

    /// Takes a message. Messages that a replay does not need are skipped.
    pub fn take(&mut self, message: &RecordedMessage<'_>, layout: &Layout) -> Result<(), Wrong> {
        let RecordedMessage { topic, time, json, .. } = *message;
        let is_needed = topic != "/instructions" && !topic.starts_with("/bodies/");
        let taken = !is_needed || message.sample(layout).and_then(|said| self.sample(said, time)).is_some();
        taken.then_some(()).ok_or_else(|| {
            let text = quoted(&String::from_utf8_lossy(json), 80);
            let topic = quoted(topic, 60);
            Wrong::foreign(format!("has a message in {topic} at {time} ns that does not fit: {text}"))
        })
    }

    fn sample(&mut self, said: Sample, time: Nanos) -> Option<()> {
        match said {
            Sample::Step(record) => self.step(&record),
            Sample::Event { process, step, what, text } => self.event(process, step, (&what, &text), time),
            Sample::Image(image) => self.image(&image),
            Sample::Signals { robot, step, signals } => self.signals(robot, step, signals),
            Sample::Reading { sensor, by, step, taken, state, words } => {
                self.reading(sensor, by, RecordedReading { step, taken, state, words })
            }
            Sample::Unknown => None,
            Sample::Instruction { .. } | Sample::Body { .. } | Sample::Other => Some(()),
        }
    }

    fn step(&mut self, record: &StepRecord) -> Option<()> {
        let &StepRecord { step, speed, suspended, reduced, aborting, stopping, resetting, .. } = record;
        let (aborts, late) = (false, false);
        let scripted =
            ScriptedStep { step, speed, suspended, reduced, aborting, stopping, resetting, aborts, late };
        let last = self.steps.last().map(|last| last.step);
        let follows = (0.0..=1.0).contains(&speed)
            && last.is_none_or(|last| last < step)
            && step - last.unwrap_or(0) <= LONGEST_GAP;
        self.steps.extend(follows.then_some(scripted));
        follows.then_some(())
    }

    fn event(&mut self, by: ProcessId, step: u64, (what, text): (&str, &str), time: Nanos) -> Option<()> {
        match what {
            "fault from outside" => self.end_before(step, text.to_owned()),
            "late" => match self.robots.iter_mut().find(|robot| Some(robot.name) == by.name) {
                Some(robot) => drop(robot.put_off.insert(step)),
                None => drop(self.late.insert(step)),
            },
            "late request" => {
                let (nth, due) = text.strip_prefix("request ")?.split_once(" in step ")?;
                let late = LateRequest { step, nth: nth.parse().ok()?, due: due.parse().ok()? };
                if late.due.saturating_sub(late.step) > LONGEST_GAP {
                    return None;
                }
                let robot = self.robots.iter_mut().find(|robot| Some(robot.name) == by.name)?;
                robot.late.push(late);
            }
            "jog" => {
                let (robot, now) = text.split_once(' ')?;
                let (robot, now) = (Name::of_process(robot).ok()?, JogNow::read(now)?);
                let follows = self.jogs.last().is_none_or(|last| last.step < step);
                self.jogs.extend(follows.then_some(ScriptedJog { step, robot, now }));
            }
            "value" => self.value(by, text)?,
            "abort" => drop(self.aborts.insert(step)),
            "end" => self.end = Some((!text.is_empty()).then(|| text.to_owned())),
            "found" => {
                let robot = self.robots.iter_mut().find(|robot| Some(robot.name) == by.name)?;
                robot.found = Some(time);
            }
            _ => {}
        }
        Some(())
    }

    /// A part of a value that a program recorded: its name, how many parts follow, its words.
    fn value(&mut self, by: ProcessId, text: &str) -> Option<()> {
        let mut fields = text.split(' ');
        let (name, left, hex) = (fields.next()?, fields.next()?.parse::<u32>().ok()?, fields.next()?);
        let name = Name::new(name).ok()?;
        let digits = hex.as_bytes().chunks(16).map(|digits| core::str::from_utf8(digits).ok());
        let words = digits.map(|digits| u64::from_str_radix(digits.filter(|d| d.len() == 16)?, 16).ok());
        let words: Vec<u64> = words.collect::<Option<_>>()?;
        let place = self.values.iter().position(|(process, ..)| *process == by).unwrap_or_else(|| {
            self.values.push((by, RecordedValues::default(), 0));
            self.values.len() - 1
        });
        let (_, of_process, due) = &mut self.values[place];
        match of_process.values.last_mut() {
            Some(last) if *due > 0 => {
                if last.name != name || left.checked_add(1) != Some(*due) {
                    return None;
                }
                last.words.extend(words);
            }
            Some(_) | None => of_process.values.push(RecordedValue { name, words }),
        }
        *due = left;
        Some(())
    }

    /// Ends the part that can be replayed before this step, in which `what` came from outside.
    fn end_before(&mut self, step: u64, what: String) {
        let earlier = self.outside.as_ref().is_none_or(|(first, _)| step < *first);
        if earlier {
            self.outside = Some((step, what));
        }
    }

    fn image(&mut self, image: &RobotSample) -> Option<()> {
        let robot = self.robots.get_mut(image.robot)?;
        let numbers = |list: &[f64]| {
            let mut numbers = [0.0; MAX_JOINTS];
            numbers.iter_mut().zip(list).for_each(|(number, x)| *number = *x);
            numbers
        };
        let StateSample { joints, velocity, .. } = &image.measured;
        let step = image.step;
        let image = RecordedImage {
            demanded: numbers(&image.demanded.joints),
            measured: Measured { position: numbers(joints), velocity: numbers(velocity) },
        };
        if robot.images.is_empty() {
            robot.first = step;
            let last = self.steps.last().map_or(0, |last| last.step);
            if step.saturating_sub(last) > LONGEST_GAP {
                return None;
            }
        }
        let follows = step == robot.first + robot.images.len() as u64;
        robot.images.extend(follows.then_some(image));
        follows.then_some(())
    }

    /// What a robot's inputs read and its outputs are: kept where it differs from the step before.
    fn signals(&mut self, robot: usize, step: u64, signals: Signals) -> Option<()> {
        let before = &mut self.robots.get_mut(robot)?.signals;
        match before.last() {
            Some((last, _)) if *last >= step => return None,
            Some((_, known)) if *known == signals => {}
            Some(_) | None => before.push((step, signals)),
        }
        Some(())
    }

    fn reading(&mut self, sensor: usize, by: ProcessId, reading: RecordedReading) -> Option<()> {
        let sensor = *self.sensors.get(sensor)?;
        let known = self.readings.iter().position(|recorded| recorded.sensor == sensor && recorded.by == by);
        let place = known.unwrap_or_else(|| {
            self.readings.push(RecordedReadings::new(sensor, by));
            self.readings.len() - 1
        });
        self.readings[place].readings.push(reading);
        Some(())
    }

    /// Completes the run from all messages.
    pub fn finish(mut self, cut_off: CutOff) -> Result<RecordedRun, Wrong> {
        for scripted in &mut self.steps {
            scripted.late = self.late.contains(&scripted.step);
            scripted.aborts = self.aborts.contains(&scripted.step);
        }
        if self.steps.is_empty() {
            return Err(Wrong::new("has no step: nothing ran", "record a run that moves something"));
        }
        for robot in &mut self.robots {
            robot.late.sort_by_key(|late| (late.step, late.nth));
        }
        let empty = self.robots.iter().find(|robot| robot.images.is_empty());
        if let Some(robot) = empty.filter(|_| cut_off == CutOff::Refused) {
            return Err(Wrong::new(format!("has no step of robot `{}`", robot.name), OTHER_CELL));
        }
        let mut of_mp = RecordedValues::default();
        for (by, mut values, left) in self.values {
            // Of a recording that was cut off the last one may lack parts.
            if left > 0 {
                values.values.pop();
            }
            match (by.role, self.robots.iter_mut().find(|robot| Some(robot.name) == by.name)) {
                (Role::Mp, _) => of_mp = values,
                (Role::Ecp, Some(robot)) => robot.values = values,
                (Role::Ecp | Role::Edp | Role::Vsp | Role::Plant | Role::Node, _) => {}
            }
        }
        Ok(RecordedRun {
            robots: self.robots.into_iter().map(Rc::new).collect(),
            readings: self.readings.into_iter().map(Rc::new).collect(),
            script: Rc::new(Script { steps: self.steps, jogs: self.jogs, values: of_mp }),
            outside: self.outside,
            end: self.end,
        })
    }
}
