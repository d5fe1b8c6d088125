//! A program in Rust that subscribes to what a cell shows.
//!
//! In: the port at which a cell is [shown](super::Subscribers), and the names of its robots. Out: what each robot, and the coordinator, does in each
//! step, and what sensors read, as long as the program keeps pace.

use std::path::Path;

use iceoryx2::port::subscriber::Subscriber as Reader;
use iceoryx2::prelude::{ZeroCopySend, ipc};
use mrroc::fault::Name;
use mrroc::link::Nanos;
use mrroc::observe::step_observer::{Mode, STATE_WORDS};
use mrroc::payload::Wire;
use mrroc::pose::Pose;
use mrroc::robot::MAX_JOINTS;

use super::message::{
    ABORTING, CellMessage, OVER, REDUCED, ReadingMessage, RobotMessage, STOPPING, SUSPENDED, VERSION,
};
use super::{KEPT, Show};
use crate::port::{Ends, channel, folder};

/// Sees what a cell shows, and changes nothing: in Rust what the module of `external` is in Python. It may begin before the cell, and
/// see several runs of it.
///
/// ```no_run
/// let mut subscriber = mrroc_external::Subscriber::at("welding", &["left", "right"])?;
/// while let Some(image) = subscriber.image() {
///     println!("robot {}, step {}: {:?}", image.robot, image.step, image.measured.joints);
/// }
/// # Ok::<(), String>(())
/// ```
pub struct Subscriber {
    robots: Vec<Reader<ipc::Service, RobotMessage, ()>>,
    steps: Reader<ipc::Service, CellMessage, ()>,
    /// What the MP has collected, then what the ECP of each robot has.
    readings: Vec<Reader<ipc::Service, ReadingMessage, ()>>,
    /// The end of images, and that of readings, whose messages are taken first the next time.
    next: [usize; 2],
    /// What the ends belong to: it goes last.
    _ends: Ends,
}

/// A state of a robot.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct State {
    /// Joint positions [rad or m].
    pub joints: Vec<f64>,
    /// Joint velocities [rad/s or m/s].
    pub velocity: Vec<f64>,
    /// `X_WE`, the pose of its tool in the world \[m\].
    pub X_WE: Pose,
}

/// What a robot does when a step begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Which robot, among the names that the subscriber was given.
    pub robot: usize,
    /// The step.
    pub step: u64,
    /// Its time on the cell's clock \[ns\].
    pub time: Nanos,
    /// When it was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: Nanos,
    /// What the robot does.
    pub mode: Mode,
    /// The state that it was told to attain last.
    pub demanded: State,
    /// The state that its encoders gave last.
    pub measured: State,
}

/// What the coordinator does when a step begins.
#[derive(Clone, Debug, PartialEq)]
pub struct StepShown {
    /// The step.
    pub step: u64,
    /// Its time on the cell's clock \[ns\].
    pub time: Nanos,
    /// When it was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: Nanos,
    /// Path time of the step \[s\]: 0 while it is suspended.
    pub path_time: f64,
    /// The speed that the operator wants, 0 to 1.
    pub speed: f64,
    /// Whether it is suspended, or on its way there.
    pub suspended: bool,
    /// Whether reduced speed is in force.
    pub reduced: bool,
    /// Whether its instruction is being aborted.
    pub aborting: bool,
    /// Whether its robots are being stopped.
    pub stopping: bool,
    /// Whether its program is over.
    pub over: bool,
    /// The first fault that stopped it since the last reset.
    pub fault: Option<String>,
}

/// A reading of a virtual sensor that a process has collected: one for each step in which it has, new or not.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingShown {
    /// The sensor.
    pub sensor: Name,
    /// The robot whose ECP has collected it, among the names that the subscriber was given; `None`: the MP has.
    pub robot: Option<usize>,
    /// The step in which it was collected.
    pub step: u64,
    /// Its time on the cell's clock \[ns\].
    pub time: Nanos,
    /// When it was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: Nanos,
    /// The step in which it was taken: it is older by as many steps as there are in between.
    pub taken: u64,
    /// The layout of its type: [`Wire::LAYOUT`].
    pub layout: u64,
    /// Its words. What they say, [`SensorLayout::reading`](mrroc::observe::layout::SensorLayout::reading) tells; of words that are missing at the end, 0.
    pub words: Vec<u64>,
}

impl ReadingShown {
    /// How old it was when it was collected \[steps\].
    #[must_use]
    pub const fn age(&self) -> u64 {
        self.step.saturating_sub(self.taken)
    }

    /// The reading itself; `None` if it is of another type.
    #[must_use]
    pub fn reading<T: Wire>(&self) -> Option<T> {
        (self.layout == T::LAYOUT).then(|| T::get(&self.words).ok()).flatten()
    }
}

impl Subscriber {
    /// At the port of this name, of a cell that has these robots.
    ///
    /// # Errors
    /// Why nothing can be read there, and what to do.
    pub fn at(port: &str, robots: &[&str]) -> Result<Subscriber, String> {
        Subscriber::below(&folder(), port, robots)
    }

    /// The same below a folder of ports.
    pub(super) fn below(folder: &Path, port: &str, robots: &[&str]) -> Result<Subscriber, String> {
        let ends = Ends::open(folder)?;
        let failed = |error: &dyn core::fmt::Display| format!("port `{port}`: {error}");
        let images = robots.iter().map(|name| {
            let images = channel(&ends.node, &Show::images(port, name), KEPT)?;
            images.subscriber_builder().create().map_err(|error| failed(&error))
        });
        let images = images.collect::<Result<_, String>>()?;
        let collectors =
            core::iter::once(None).chain(robots.iter().map(|name| Some(name as &dyn core::fmt::Display)));
        let readings = collectors.map(|robot| {
            let readings = channel(&ends.node, &Show::readings(port, robot), KEPT)?;
            readings.subscriber_builder().create().map_err(|error| failed(&error))
        });
        let readings = readings.collect::<Result<_, String>>()?;
        let steps = channel(&ends.node, &Show::steps(port), KEPT)?;
        let steps = steps.subscriber_builder().create().map_err(|error| failed(&error))?;
        Ok(Subscriber { robots: images, steps, readings, next: [0; 2], _ends: ends })
    }

    /// The next image of a robot that has come, those of each robot in their order; a step that is missing was lost.
    pub fn image(&mut self) -> Option<Image> {
        next_of(&self.robots, &mut self.next[0], Image::of)
    }

    /// The next reading that has come, those of each process in their order.
    pub fn reading(&mut self) -> Option<ReadingShown> {
        next_of(&self.readings, &mut self.next[1], ReadingShown::of)
    }

    /// The next step of the coordinator that has come.
    pub fn step(&mut self) -> Option<StepShown> {
        let message = self.steps.receive().ok().flatten()?;
        (message.version == VERSION).then(|| StepShown::of(&message))
    }
}

/// The next message that has come to one of these ends, `next` first.
fn next_of<M: ZeroCopySend + core::fmt::Debug, T>(
    ends: &[Reader<ipc::Service, M, ()>],
    next: &mut usize,
    read: impl Fn(usize, &M) -> Option<T>,
) -> Option<T> {
    let count = ends.len();
    for place in (0..count).map(|offset| (*next + offset) % count) {
        let received = ends[place].receive().ok().flatten();
        if let Some(message) = received.and_then(|message| read(place, &message)) {
            // One to which much comes does not hide the others.
            *next = place + 1;
            return Some(message);
        }
    }
    None
}

impl ReadingShown {
    /// `None`: of another version.
    fn of(end: usize, message: &ReadingMessage) -> Option<ReadingShown> {
        let &ReadingMessage { version, step, time, sent, taken, layout, .. } = message;
        let sensor = Name::get(&message.sensor).ok().filter(|_| version == VERSION)?;
        let words = message.words.get(..message.len as usize)?.to_vec();
        Some(ReadingShown { sensor, robot: end.checked_sub(1), step, time, sent, taken, layout, words })
    }
}

impl Image {
    /// `None`: of another version.
    fn of(robot: usize, message: &RobotMessage) -> Option<Image> {
        let mode = match message.mode {
            0 => Mode::Holding,
            1 => Mode::Moving,
            2 => Mode::Bridging,
            3 => Mode::Braking,
            4 => Mode::Off,
            _ => return None,
        };
        let joints = (message.joints as usize).min(MAX_JOINTS);
        let (demanded, measured) = message.words.split_at(STATE_WORDS);
        let (demanded, measured) = (State::of(demanded, joints)?, State::of(measured, joints)?);
        let &RobotMessage { step, time, sent, version, .. } = message;
        (version == VERSION).then_some(Image { robot, step, time, sent, mode, demanded, measured })
    }
}

impl State {
    #[allow(non_snake_case)]
    fn of(words: &[u64], joints: usize) -> Option<State> {
        let numbers = |from: usize| {
            words.get(from..from + joints).map(|words| words.iter().copied().map(f64::from_bits))
        };
        let X_WE = Pose::get(words.get(2 * MAX_JOINTS..)?).ok()?;
        Some(State { joints: numbers(0)?.collect(), velocity: numbers(MAX_JOINTS)?.collect(), X_WE })
    }
}

impl StepShown {
    fn of(message: &CellMessage) -> StepShown {
        let is_set = |bit| message.flags & bit != 0;
        let text = message.fault.split(|&byte| byte == 0).next().unwrap_or_default();
        StepShown {
            step: message.step,
            time: message.time,
            sent: message.sent,
            path_time: message.path_time,
            speed: message.speed,
            suspended: is_set(SUSPENDED),
            reduced: is_set(REDUCED),
            aborting: is_set(ABORTING),
            stopping: is_set(STOPPING),
            over: is_set(OVER),
            fault: (!text.is_empty()).then(|| String::from_utf8_lossy(text).into_owned()),
        }
    }
}
