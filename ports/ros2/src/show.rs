//! What the cell shows, as topics.
//!
//! In: images of robots, readings of sensors, and pictures of the cell. Out: messages, to other nodes or into a bag. The bridge waits for no subscriber.

use mrroc_core::console::complain;
use mrroc_core::observe::layout::{Layout, SensorLayout};
use mrroc_core::pose::Pose;
use mrroc_core::robot::Signals;
use mrroc_external::{Image, ReadingShown};
use mrroc_processes::Picture;
use mrroc_recording::json_of;

use crate::clock::CellClock;
use crate::description::{Description, WORLD, joint_names};
use crate::diagnostics;
use crate::messages::{DiagnosticArray, Header, JointState, Stamp, Text, TransformStamped, Transforms};
use crate::moveit;
use crate::node::{same_topic, topic_name};
use crate::outlet::{Durability, Outlet, Put};
use crate::readings::ReadingTopics;
use crate::signals::SignalTopics;

/// Time between two messages of `/tf`, and of `/joint_states`, for a robot \[ns of the cell\].
const EVERY: u64 = 20_000_000;

/// A robot, and its topics.
struct Robot<O: Outlet> {
    description: Option<Description>,
    joints: Vec<String>,
    /// The names of the same joints among those of all robots.
    names: Vec<String>,
    /// Measured, and demanded.
    states: [O::Topic<JointState>; 2],
    /// When its links, and its joints among those of all robots, are shown next \[ns of the cell\].
    due: u64,
}

/// A sensor, and the topics of its readings.
struct SensorShown<O: Outlet> {
    layout: SensorLayout,
    topics: ReadingTopics<O>,
    /// Whether it was told that readings of another type come.
    is_refused: bool,
}

/// The topics of a cell.
pub struct Topics<O: Outlet> {
    robots: Vec<Robot<O>>,
    /// The joints of all robots, one robot in a message.
    all: O::Topic<JointState>,
    transforms: O::Topic<Transforms>,
    state: O::Topic<Text>,
    instruction: O::Topic<Text>,
    diagnostics: O::Topic<DiagnosticArray>,
    signals: SignalTopics<O>,
    sensors: Vec<SensorShown<O>>,
    node: String,
    clock: CellClock,
    /// Length of a step \[ns\].
    step: u64,
    /// What was published last.
    said: String,
    said_instruction: (u64, String),
    /// They keep for others what was published once.
    _kept: (Vec<O::Topic<Text>>, O::Topic<Transforms>),
}

impl<O: Outlet> Topics<O> {
    /// Those of a cell of this layout, which has these robots with their URDFs, as far as they write any.
    ///
    /// # Errors
    /// Why a topic cannot be published, or which robots would have the same ones.
    pub fn open(
        node: &mut O,
        layout: &Layout,
        urdfs: &[(String, Option<String>)],
        clock: CellClock,
    ) -> Result<Self, String> {
        let (mut robots, mut descriptions) = (Vec::new(), Vec::new());
        let stamp = Stamp::of(node.now());
        let frames = layout.frames.iter();
        let mut fixed: Vec<_> =
            frames.map(|(name, pose)| TransformStamped::of(stamp, WORLD, name, pose)).collect();
        let robots_below = same_topic(layout.robots.iter().map(|robot| robot.name.as_str()));
        let sensors_below = same_topic(layout.sensors.iter().map(|sensor| sensor.name.as_str()));
        for (what, folder, same) in [("robots", "", robots_below), ("sensors", "sensors/", sensors_below)] {
            if let Some([one, other]) = same {
                return Err(format!(
                    "{what} `{one}` and `{other}` would have the same topics /{folder}{}/..\n help: rename one of them",
                    topic_name(one)
                ));
            }
        }
        for (name, urdf) in urdfs {
            let Some(robot) = layout.robots.iter().find(|robot| robot.name == *name) else { continue };
            let name = topic_name(&robot.name);
            let read = |urdf: &String| Description::read(urdf.clone(), &name, robot.joints.len());
            let description = match urdf.as_ref().map(read) {
                Some(Ok(description)) => Some(description),
                Some(Err(why)) => {
                    node.warn(&format!(
                        "warning: robot `{}` has no robot_description and no transforms: {why}",
                        robot.name
                    ));
                    None
                }
                None => None,
            };
            let mut states = |topic: &str| node.topic(&format!("/{name}/{topic}"), Durability::Volatile);
            let states = [states("joint_states")?, states("demanded_joint_states")?];
            if let Some(description) = &description {
                let stands_in = match &robot.mounted_on {
                    Some(carrier) => format!("{}/flange", topic_name(carrier)),
                    None => WORLD.to_owned(),
                };
                let place =
                    TransformStamped::of(stamp, &stands_in, &format!("{name}/{WORLD}"), &Pose::identity());
                fixed.push(place);
                let topic = format!("/{name}/robot_description");
                let kept: O::Topic<Text> = node.topic(&topic, Durability::TransientLocal)?;
                kept.put(Text { data: description.urdf.clone() });
                descriptions.push(kept);
                fixed.extend(description.fixed().map(|one| one.stamped(stamp)));
            }
            let joints = joint_names(description.as_ref(), robot.joints.len());
            robots.push(Robot { description, joints, names: Vec::new(), states, due: 0 });
        }
        let joints: Vec<_> = robots.iter().map(|robot: &Robot<O>| robot.joints.clone()).collect();
        for (robot, names) in robots.iter_mut().zip(moveit::names(layout, &joints)) {
            robot.names = names;
        }
        let sensors = layout.sensors.iter().map(|sensor| {
            let frame = sensor.of.as_ref().map_or_else(String::new, |of| format!("{}/tool", topic_name(of)));
            let name = format!("/sensors/{}", topic_name(&sensor.name));
            let topics = ReadingTopics::open(node, &name, sensor.reading, &frame)?;
            Ok(SensorShown { layout: sensor.clone(), topics, is_refused: false })
        });
        let sensors = sensors.collect::<Result<_, String>>()?;
        let standing: O::Topic<Transforms> = node.topic("/tf_static", Durability::TransientLocal)?;
        standing.put(Transforms { transforms: fixed });
        Ok(Topics {
            robots,
            all: node.topic("/joint_states", Durability::Volatile)?,
            transforms: node.topic("/tf", Durability::Volatile)?,
            state: node.topic(&node.own("state"), Durability::TransientLocal)?,
            instruction: node.topic(&node.own("instruction"), Durability::TransientLocal)?,
            diagnostics: node.topic("/diagnostics", Durability::Volatile)?,
            signals: SignalTopics::open(node, layout)?,
            sensors,
            node: node.node().to_owned(),
            clock,
            step: layout.step.as_nanos() as u64,
            said: String::new(),
            said_instruction: Default::default(),
            _kept: (descriptions, standing),
        })
    }

    /// The names of the joints of each robot.
    pub fn joints(&self) -> Vec<Vec<String>> {
        self.robots.iter().map(|robot| robot.joints.clone()).collect()
    }

    /// Publishes what a robot does in a step, and tells its stamp.
    pub fn image(&mut self, image: &Image) -> Stamp {
        let states = [&image.measured, &image.demanded].map(|state| [&*state.joints, &*state.velocity]);
        self.joint_states(image.robot, image.step, image.sent, states)
    }

    /// Publishes where the joints of a robot are measured to be when a step begins, and how fast they are, and the same as demanded; it was told at `sent` by
    /// the machine's monotonic clock \[ns\]. Tells the stamp of the step.
    pub fn joint_states(&mut self, robot: usize, step: u64, sent: u64, states: [[&[f64]; 2]; 2]) -> Stamp {
        let [measured, _] = states;
        let time = step * self.step;
        let stamp = Stamp::of(self.clock.date(time, sent));
        let Some(robot) = self.robots.get_mut(robot) else { return stamp };
        // Another run of the cell begins at zero again.
        if robot.due > time + EVERY {
            robot.due = 0;
        }
        if time >= robot.due {
            // The same instants for all robots: joint states of one stamp are told together.
            robot.due = (time / EVERY + 1) * EVERY;
            self.all.put(JointState::of(stamp, &robot.names, measured));
            if let Some(description) = &robot.description {
                let transforms = description.moving(measured[0]).map(|one| one.stamped(stamp)).collect();
                self.transforms.put(Transforms { transforms });
            }
        }
        for (topic, state) in robot.states.iter().zip(states) {
            topic.put(JointState::of(stamp, &robot.joints, state));
        }
        stamp
    }

    /// Publishes a reading, where it is of the type that this program's cell has.
    pub fn reading_shown(&mut self, reading: &ReadingShown) {
        let name = reading.sensor.as_str();
        let Some(known) = self.sensors.iter_mut().find(|known| known.layout.name == name) else { return };
        if known.layout.reading_layout != reading.layout {
            if !core::mem::replace(&mut known.is_refused, true) {
                complain(&format!(
                    "warning: the readings of sensor `{name}` have other fields in the cell that runs: build the bridge anew"
                ));
            }
            return;
        }
        self.reading(name, [reading.step, reading.taken], reading.sent, &reading.words);
    }

    /// Publishes the words of a reading of a sensor that was collected in a step and taken in another one; it was told at `sent` by the machine's monotonic
    /// clock \[ns\].
    pub fn reading(&mut self, sensor: &str, [step, taken]: [u64; 2], sent: u64, words: &[u64]) {
        let Some(known) = self.sensors.iter().find(|known| known.layout.name == sensor) else { return };
        let age = step.saturating_sub(taken) * self.step;
        let date = self.clock.date(step * self.step, sent).saturating_sub(age);
        known.topics.put(Stamp::of(date), &json_of(known.layout.reading, words));
    }

    /// Publishes what has changed in a picture.
    pub fn picture(&mut self, picture: &Picture) {
        self.state(picture.state.word());
        self.instruction(picture);
        for carried in &picture.carried {
            self.signals(&carried.robot, &carried.signals);
        }
    }

    /// Publishes which inputs and outputs of a robot have changed.
    pub fn signals(&mut self, robot: &str, signals: &Signals) {
        self.signals.put(robot, signals);
    }

    /// Publishes what the cell does, if that has changed.
    pub fn state(&mut self, said: &str) {
        if self.said != said {
            said.clone_into(&mut self.said);
            self.state.put(Text { data: said.to_owned() });
        }
    }

    /// Publishes the present instruction, if it is another one.
    pub fn instruction(&mut self, picture: &Picture) {
        self.tell_instruction((picture.instructions, diagnostics::instruction(picture)));
    }

    /// Publishes that no cell answers.
    pub fn not_reachable(&mut self) {
        self.state("not reachable");
        self.tell_instruction((0, "nothing".to_owned()));
    }

    fn tell_instruction(&mut self, instruction: (u64, String)) {
        if self.said_instruction != instruction {
            self.instruction.put(Text { data: instruction.1.clone() });
            self.said_instruction = instruction;
        }
    }

    /// Publishes a picture as diagnostics of a date \[ns since 1970\].
    pub fn diagnose(&mut self, picture: &Picture, date: u64) {
        let header = Header { stamp: Stamp::of(date), frame_id: String::new() };
        let status = diagnostics::of(picture, &self.node);
        self.diagnostics.put(DiagnosticArray { header, status });
    }
}
