//! What the cell shows, as topics.
//!
//! In: images of robots, and pictures of the cell. Out: messages, to other nodes or into a bag. The bridge waits for no subscriber.

use mrroc_core::console::complain;
use mrroc_core::observe::layout::Layout;
use mrroc_core::pose::Pose;
use mrroc_core::robot::Signals;
use mrroc_external::Image;
use mrroc_processes::Picture;

use crate::clock::CellClock;
use crate::description::{Description, WORLD, joint_names};
use crate::diagnostics;
use crate::messages::{DiagnosticArray, Header, JointState, Stamp, Text, TransformStamped, Transforms};
use crate::moveit;
use crate::node::{same_topic, topic_name};
use crate::outlet::{Durability, Outlet, Put};
use crate::signals::SignalTopics;

/// Time between two messages of `/tf`, and of `/joint_states`, for a robot \[ns of the cell\].
const EVERY: u64 = 20_000_000;

/// A robot, and its topics.
struct Robot<O: Outlet> {
    description: Option<Description>,
    joints: Vec<String>,
    /// The names of the same joints among those of all robots.
    names: Vec<String>,
    states: O::Topic<JointState>,
    /// When its links, and its joints among those of all robots, are shown next \[ns of the cell\].
    due: u64,
}

/// The topics of a cell.
pub struct Topics<O: Outlet> {
    robots: Vec<Robot<O>>,
    /// The joints of all robots, one robot in a message.
    all: O::Topic<JointState>,
    transforms: O::Topic<Transforms>,
    state: O::Topic<Text>,
    diagnostics: O::Topic<DiagnosticArray>,
    signals: SignalTopics<O>,
    node: String,
    clock: CellClock,
    /// Length of a step \[ns\].
    step: u64,
    /// What was published last.
    said: String,
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
        if let Some([one, other]) = same_topic(layout.robots.iter().map(|robot| robot.name.as_str())) {
            return Err(format!(
                "robots `{one}` and `{other}` would have the same topics /{}/..\n help: rename one of them",
                topic_name(one)
            ));
        }
        for (name, urdf) in urdfs {
            let Some(robot) = layout.robots.iter().find(|robot| robot.name == *name) else { continue };
            let name = topic_name(&robot.name);
            let read = |urdf: &String| Description::read(urdf.clone(), &name, robot.joints.len());
            let description = match urdf.as_ref().map(read) {
                Some(Ok(description)) => Some(description),
                Some(Err(why)) => {
                    complain(&format!(
                        "warning: robot `{}` has no robot_description and no transforms: {why}",
                        robot.name
                    ));
                    None
                }
                None => None,
            };
            let states = node.topic(&format!("/{name}/joint_states"), Durability::Volatile)?;
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
        let standing: O::Topic<Transforms> = node.topic("/tf_static", Durability::TransientLocal)?;
        standing.put(Transforms { transforms: fixed });
        Ok(Topics {
            robots,
            all: node.topic("/joint_states", Durability::Volatile)?,
            transforms: node.topic("/tf", Durability::Volatile)?,
            state: node.topic(&node.own("state"), Durability::TransientLocal)?,
            diagnostics: node.topic("/diagnostics", Durability::Volatile)?,
            signals: SignalTopics::open(node, layout)?,
            node: node.node().to_owned(),
            clock,
            step: layout.step.as_nanos() as u64,
            said: String::new(),
            _kept: (descriptions, standing),
        })
    }

    /// The names of the joints of each robot.
    pub fn joints(&self) -> Vec<Vec<String>> {
        self.robots.iter().map(|robot| robot.joints.clone()).collect()
    }

    /// Publishes what a robot does in a step, and tells its stamp.
    pub fn image(&mut self, image: &Image) -> Stamp {
        let measured = [&*image.measured.joints, &*image.measured.velocity];
        self.measured(image.robot, image.step, image.sent, measured)
    }

    /// Publishes where the joints of a robot are measured to be when a step begins, and how fast they are; it was told at `sent` by the machine's
    /// monotonic clock \[ns\]. Tells the stamp of the step.
    pub fn measured(&mut self, robot: usize, step: u64, sent: u64, measured: [&[f64]; 2]) -> Stamp {
        let time = step * self.step;
        let stamp = self.clock.stamp(time, sent);
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
        robot.states.put(JointState::of(stamp, &robot.joints, measured));
        stamp
    }

    /// Publishes what has changed in a picture.
    pub fn picture(&mut self, picture: &Picture) {
        self.state(picture.state.word());
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

    /// Publishes a picture as diagnostics of a date \[ns since 1970\].
    pub fn diagnose(&mut self, picture: &Picture, date: u64) {
        let header = Header { stamp: Stamp::of(date), frame_id: String::new() };
        let status = diagnostics::of(picture, &self.node);
        self.diagnostics.put(DiagnosticArray { header, status });
    }
}
