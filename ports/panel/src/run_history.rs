//! The history of a run that is over: what the cell did, fifty times a second.
//!
//! In: what a run on the memory link shows, or a recording. Out: the cell at any moment of it.

use std::cell::RefCell;

use mrroc_core::fault::{Fault, FaultWords, ProcessId, Role};
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::{ReadingState, STATE_WORDS, StepEvent, StepObserver, StepRecord};
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::Wire;
use mrroc_core::pose::Pose;
use mrroc_core::robot::{MAX_JOINTS, Signals};

use crate::beside::{CarriedLoad, ReadingNow};
use crate::now::{Appearance, CellMoment, RobotNow};
use crate::readings::{OLD, of_words};

/// The time between two moments that are kept \[ns\], at first.
const EVERY: u64 = 20_000_000;

/// The most moments that are kept: where there are more, every second one is dropped.
const MOST: usize = 30_000;

/// How much of a run is plotted \[ns\], and at how many moments at most: as many as a plot has pixels.
const MINUTE: u64 = 60_000_000_000;
const PLOTTED: usize = 300;

/// A run that is over, or that is being looked at.
pub struct RunHistory {
    moments: Vec<(u64, CellMoment)>,
    now: CellMoment,
    /// When each of the newest readings was collected \[ns\].
    read: Vec<u64>,
    every: u64,
    due: u64,
    suspended: bool,
    aborting: bool,
    over: bool,
}

impl RunHistory {
    /// Of a cell of this layout, before its first step.
    #[must_use]
    pub fn of(layout: &Layout) -> RunHistory {
        let robots = layout.robots.iter().map(|robot| RobotNow {
            name: robot.name.clone(),
            time: 0.0,
            demanded: vec![f64::NAN; robot.joints.len()],
            measured: vec![f64::NAN; robot.joints.len()],
            tool: Pose::identity(),
            doing: String::new(),
            jogs: false,
            stop: String::new(),
            carried: CarriedLoad::default(),
        });
        let now = CellMoment {
            period: u64::try_from(layout.step.as_nanos()).unwrap_or(u64::MAX),
            state: "idle",
            doing: "nothing",
            speed: 1.0,
            robots: robots.collect(),
            bodies: vec![None; layout.bodies.len()],
            readings: vec![None; layout.sensors.len()],
            ..CellMoment::default()
        };
        RunHistory {
            moments: Vec::new(),
            now,
            read: vec![0; layout.sensors.len()],
            every: EVERY,
            due: 0,
            suspended: false,
            aborting: false,
            over: false,
        }
    }

    /// Whether what happens at a time of the cell \[ns\] is wanted of each robot: the moment after it is kept.
    #[must_use]
    pub const fn is_due(&self, time: u64) -> bool {
        // An EDP may begin its step before the MP or after it: the one before the moment is wanted, too.
        time.saturating_add(self.now.period) >= self.due
    }

    /// The MP begins a step: the moment before it is kept, if it is due.
    pub fn step(&mut self, time: u64, step: &StepRecord) {
        self.keep(time);
        let now = &mut self.now;
        now.step = step.step;
        now.rate = if step.duration > 0.0 { step.dt / step.duration } else { 0.0 };
        now.speed = step.speed;
        now.reduced = step.reduced;
        (self.suspended, self.aborting) = (step.suspended, step.aborting);
        if step.resetting {
            // Programs begin at their first line, and their instructions are counted from there.
            (now.fault, now.epoch, now.instruction) = (None, now.epoch + 1, 0);
        }
        self.tell();
    }

    /// Keeps the cell as it is at a time \[ns\], if it is due or the run is over.
    fn keep(&mut self, time: u64) {
        if time < self.due && !self.over
            || self.now.robots.iter().any(|robot| robot.measured.iter().any(|q| q.is_nan()))
        {
            return;
        }
        self.now.time = time as f64 * 1e-9;
        for (reading, read) in self.now.readings.iter_mut().zip(&self.read) {
            if time.saturating_sub(*read) > OLD {
                *reading = None;
            }
        }
        self.moments.push((time, self.now.clone()));
        if self.moments.len() >= MOST {
            let mut i = 0;
            self.moments.retain(|_| {
                i += 1;
                i % 2 == 1
            });
            self.every *= 2;
        }
        self.due = (time / self.every + 1) * self.every;
    }

    /// A robot's joints, the pose of its tool, `X_WE`, and the tool in force, `X_FE`, when it begins a step.
    pub fn robot(
        &mut self,
        time: u64,
        name: &str,
        [demanded, measured]: [&[f64]; 2],
        [tool, in_force]: [Pose; 2],
    ) {
        let robot = self.now.robots.iter_mut().find(|robot| robot.name == name);
        if let Some(robot) = robot {
            robot.time = time as f64 * 1e-9;
            robot.carried.tool = Some(in_force);
            robot.demanded.iter_mut().zip(demanded).for_each(|(q, of)| *q = *of);
            robot.measured.iter_mut().zip(measured).for_each(|(q, of)| *q = *of);
            robot.tool = tool;
        }
    }

    /// The inputs and outputs of a robot.
    pub fn signals(&mut self, name: &str, signals: Signals) {
        let robot = self.now.robots.iter_mut().find(|robot| robot.name == name);
        if let Some(robot) = robot {
            robot.carried.signals = Some(signals);
        }
    }

    /// A reading of the sensor at a place in the layout was collected at a time \[ns\].
    pub fn reading(&mut self, time: u64, place: usize, reading: ReadingNow) {
        if let (Some(newest), Some(read)) = (self.now.readings.get_mut(place), self.read.get_mut(place)) {
            (*newest, *read) = (reading, time);
        }
    }

    /// A body is at a place, `X_WB`.
    pub fn body(&mut self, place: usize, pose: Pose) {
        if let Some(body) = self.now.bodies.get_mut(place) {
            *body = Some(pose);
        }
    }

    /// A program begins an instruction, or has ended it.
    pub fn instruction(&mut self, process: &str, doing: InstructionKind, by: &str) {
        if process == "mp" {
            let begins = !matches!(doing, InstructionKind::Nothing | InstructionKind::Homing);
            self.now.instruction += u64::from(begins);
            self.now.doing = doing.word();
            if doing != InstructionKind::Nothing {
                self.now.by = if by.is_empty() { "of each robot by its own program" } else { by }.to_owned();
            }
        } else if let Some(name) = process.strip_prefix("ecp ")
            && let Some(robot) = self.now.robots.iter_mut().find(|robot| robot.name == name)
        {
            robot.doing = if doing == InstructionKind::Nothing {
                String::new()
            } else {
                format!("{} {by}", doing.word())
            };
        }
        self.tell();
    }

    /// A process stops for a fault: the first one is kept.
    pub fn fault(&mut self, text: String, help: Option<&str>) {
        if self.now.fault.is_none() {
            (self.now.fault, self.now.help) = (Some(text), help.map(str::to_owned));
        }
        self.tell();
    }

    /// The program of the MP is over.
    pub fn end(&mut self, time: u64, fault: Option<(String, Option<&str>)>) {
        if let Some((text, help)) = fault {
            self.fault(text, help);
        }
        (self.over, self.now.doing) = (true, "nothing");
        self.tell();
        self.keep(time);
    }

    fn tell(&mut self) {
        self.now.state = match () {
            () if self.now.fault.is_some() => "latched",
            () if self.aborting => "aborting",
            () if self.suspended => "suspended",
            () if self.now.doing == "nothing" => "idle",
            () => "running",
        };
    }

    /// How long it lasts \[s\].
    #[must_use]
    pub fn lasts(&self) -> f64 {
        self.moments.last().map_or(0.0, |(_, now)| now.time)
    }

    /// The cell at a time \[s\]; `None` if nothing was seen.
    #[must_use]
    pub fn at(&self, time: f64) -> Option<&CellMoment> {
        let until = nanos(time);
        let next = self.moments.partition_point(|(at, _)| *at <= until);
        self.moments.get(next.saturating_sub(1)).map(|(_, now)| now)
    }

    /// Moments of the minute before a time \[s\], some hundreds at most.
    pub fn minute(&self, time: f64) -> impl Iterator<Item = &CellMoment> {
        let until = nanos(time);
        let [begin, end] = [until.saturating_sub(MINUTE), until]
            .map(|before| self.moments.partition_point(|(at, _)| *at < before));
        let every = (end - begin).div_ceil(PLOTTED).max(1);
        self.moments[begin..end].iter().step_by(every).map(|(_, now)| now)
    }
}

/// A time \[s\] in nanoseconds.
fn nanos(time: f64) -> u64 {
    (time.clamp(0.0, 1e9) * 1e9) as u64
}

/// Looks on at a run on the memory link.
pub struct OnMemory {
    layout: Layout,
    history: RefCell<RunHistory>,
}

impl OnMemory {
    /// Of a cell of this layout.
    #[must_use]
    pub fn of(layout: Layout) -> OnMemory {
        OnMemory { history: RefCell::new(RunHistory::of(&layout)), layout }
    }

    /// What the cell is made of, and its history so far, which begins anew.
    pub fn take(&self) -> (Appearance, RunHistory) {
        let history = std::mem::replace(&mut *self.history.borrow_mut(), RunHistory::of(&self.layout));
        (Appearance::of(&self.layout), history)
    }
}

impl StepObserver for OnMemory {
    fn see(&self, time: u64, by: ProcessId, what: &StepEvent, words: &[u64]) {
        let mut history = self.history.borrow_mut();
        match *what {
            StepEvent::Step(step) => history.step(time, &step),
            StepEvent::Image { .. } if history.is_due(time) && words.len() >= 2 * STATE_WORDS => {
                let Some(name) = by.name else { return };
                let (demanded, measured) = words.split_at(STATE_WORDS);
                let Ok(tool) = Pose::get(&measured[2 * MAX_JOINTS..]) else { return };
                let in_force = words.get(2 * STATE_WORDS..).and_then(|words| Pose::get(words).ok());
                let Some(in_force) = in_force else { return };
                let numbers = |words: &[u64]| {
                    <[u64; MAX_JOINTS]>::try_from(&words[..MAX_JOINTS])
                        .unwrap_or_default()
                        .map(f64::from_bits)
                };
                let (demanded, measured) = (numbers(demanded), numbers(measured));
                history.robot(time, name.as_str(), [&demanded, &measured], [tool, in_force]);
            }
            StepEvent::Instruction { doing, by: generator, .. } => {
                history.instruction(&by.to_string(), doing, &generator.to_string());
            }
            StepEvent::Signals { .. } => {
                if let (Some(name), Ok(signals)) = (by.name, Signals::get(words)) {
                    history.signals(name.as_str(), signals);
                }
            }
            StepEvent::Reading { sensor, state, shape, .. } => {
                let place = self.layout.sensors.iter().position(|known| known.name == sensor.as_str());
                match (place, state) {
                    (Some(place), ReadingState::There) => {
                        history.reading(time, place, Some(of_words(shape, words)))
                    }
                    (Some(place), ReadingState::Fault) => history.reading(time, place, None),
                    _ => {}
                }
            }
            StepEvent::Body { body, .. } => {
                let place = self.layout.bodies.iter().position(|known| known.name == body.as_str());
                if let (Some(place), Ok(pose)) = (place, Pose::get(words)) {
                    history.body(place, pose);
                }
            }
            StepEvent::Fault { .. } if by.role == Role::Mp => {
                if let Ok(fault) = FaultWords::get(words).map(Fault::from) {
                    history.fault(fault.to_string(), fault.help());
                }
            }
            StepEvent::End { .. } => {
                let fault = FaultWords::get(words).ok().map(Fault::from);
                history.end(time, fault.as_ref().map(|fault| (fault.to_string(), fault.help())));
            }
            _ => {}
        }
    }
}
