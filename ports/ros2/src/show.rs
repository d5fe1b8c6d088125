//! What the cell shows, as topics.
//!
//! In: images of robots, and pictures of the cell. Out: messages. The bridge waits for no subscriber.

use mrroc_core::console::complain;
use mrroc_core::observe::layout::Layout;
use mrroc_core::pose::Pose;
use mrroc_external::Image;
use mrroc_processes::Picture;
use ros2_client::Publisher;

use crate::clock::{CellClock, now};
use crate::description::{Description, WORLD, joint_names};
use crate::diagnostics;
use crate::messages::{DiagnosticArray, Header, JointState, Stamp, Text, TransformStamped, Transforms};
use crate::moveit;
use crate::node::{RosNode, kept, now_only, same_topic, topic_name};
use crate::signals::SignalTopics;

/// Time between two messages of `/tf`, and of `/joint_states`, for a robot \[ns of the cell\].
const EVERY: u64 = 20_000_000;

/// A robot, and its topics.
struct Robot {
    description: Option<Description>,
    joints: Vec<String>,
    /// The names of the same joints among those of all robots.
    names: Vec<String>,
    states: Publisher<JointState>,
    /// When its links, and its joints among those of all robots, are shown next \[ns of the cell\].
    due: u64,
}

/// The topics of a cell.
pub struct Topics {
    robots: Vec<Robot>,
    /// The joints of all robots, one robot in a message.
    all: Publisher<JointState>,
    transforms: Publisher<Transforms>,
    state: Publisher<Text>,
    diagnostics: Publisher<DiagnosticArray>,
    signals: SignalTopics,
    node: String,
    clock: CellClock,
    /// Length of a step \[ns\].
    step: u64,
    /// What was published last.
    said: String,
    /// They keep for others what was published once.
    _kept: (Vec<Publisher<Text>>, Publisher<Transforms>),
}

impl Topics {
    /// Those of a cell of this layout, which has these robots with their URDFs, as far as they write any.
    ///
    /// # Errors
    /// Why a topic cannot be published, or which robots would have the same ones.
    pub fn open(
        node: &mut RosNode,
        layout: &Layout,
        urdfs: &[(String, Option<String>)],
    ) -> Result<Topics, String> {
        let (mut robots, mut descriptions) = (Vec::new(), Vec::new());
        let stamp = Stamp::of(now());
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
            let states =
                node.publisher(&format!("/{name}/joint_states"), ("sensor_msgs", "JointState"), now_only())?;
            if let Some(description) = &description {
                let stands_in = match &robot.mounted_on {
                    Some(carrier) => format!("{}/flange", topic_name(carrier)),
                    None => WORLD.to_owned(),
                };
                let place =
                    TransformStamped::of(stamp, &stands_in, &format!("{name}/{WORLD}"), &Pose::identity());
                fixed.push(place);
                let topic = format!("/{name}/robot_description");
                let publisher = node.publisher(&topic, ("std_msgs", "String"), kept())?;
                drop(publisher.publish(Text { data: description.urdf.clone() }));
                descriptions.push(publisher);
                fixed.extend(description.fixed().map(|one| one.stamped(stamp)));
            }
            let joints = joint_names(description.as_ref(), robot.joints.len());
            robots.push(Robot { description, joints, names: Vec::new(), states, due: 0 });
        }
        let joints: Vec<_> = robots.iter().map(|robot: &Robot| robot.joints.clone()).collect();
        for (robot, names) in robots.iter_mut().zip(moveit::names(layout, &joints)) {
            robot.names = names;
        }
        let tf = ("tf2_msgs", "TFMessage");
        let standing = node.publisher("/tf_static", tf, kept())?;
        drop(standing.publish(Transforms { transforms: fixed }));
        Ok(Topics {
            robots,
            all: node.publisher("/joint_states", ("sensor_msgs", "JointState"), now_only())?,
            transforms: node.publisher("/tf", tf, now_only())?,
            state: node.publisher(&node.own("state"), ("std_msgs", "String"), kept())?,
            diagnostics: node.publisher(
                "/diagnostics",
                ("diagnostic_msgs", "DiagnosticArray"),
                now_only(),
            )?,
            signals: SignalTopics::open(node, layout)?,
            node: node.name().to_owned(),
            clock: CellClock::default(),
            step: layout.step.as_nanos() as u64,
            said: String::new(),
            _kept: (descriptions, standing),
        })
    }

    /// The names of the joints of each robot.
    pub fn joints(&self) -> Vec<Vec<String>> {
        self.robots.iter().map(|robot| robot.joints.clone()).collect()
    }

    /// Publishes what a robot does in a step, and tells its stamp. What nobody takes is dropped.
    pub fn image(&mut self, image: &Image) -> Stamp {
        let time = image.step * self.step;
        let stamp = self.clock.stamp(time, image.sent);
        let Some(robot) = self.robots.get_mut(image.robot) else { return stamp };
        let joints = &image.measured.joints;
        // Another run of the cell begins at zero again.
        if robot.due > time + EVERY {
            robot.due = 0;
        }
        let state = |names: &[String]| JointState {
            header: Header { stamp, frame_id: String::new() },
            name: names.to_vec(),
            position: joints.clone(),
            velocity: image.measured.velocity.clone(),
            effort: Vec::new(),
        };
        if time >= robot.due {
            robot.due = time + EVERY;
            drop(self.all.publish(state(&robot.names)));
            if let Some(description) = &robot.description {
                let transforms = description.moving(joints).map(|one| one.stamped(stamp)).collect();
                drop(self.transforms.publish(Transforms { transforms }));
            }
        }
        drop(robot.states.publish(state(&robot.joints)));
        stamp
    }

    /// Publishes what has changed in a picture.
    pub fn picture(&mut self, picture: &Picture) {
        self.state(picture.state.word());
        self.signals.picture(picture);
    }

    /// Publishes what the cell does, if that has changed.
    pub fn state(&mut self, said: &str) {
        if self.said != said {
            said.clone_into(&mut self.said);
            drop(self.state.publish(Text { data: said.to_owned() }));
        }
    }

    /// Publishes a picture as diagnostics.
    pub fn diagnose(&mut self, picture: &Picture) {
        let header = Header { stamp: Stamp::of(now()), frame_id: String::new() };
        let status = diagnostics::of(picture, &self.node);
        drop(self.diagnostics.publish(DiagnosticArray { header, status }));
    }
}
