//! What 3D viewers show of a recording: the frames of the robots' links and tools, and their bodies.
//!
//! In: the messages of robots and bodies, as they are recorded. Out: for some of them a `foxglove.FrameTransforms` and a
//! `foxglove.SceneUpdate`, at the measured joint positions. They are made where the file is written, never in a step.
//!
//! The frames are a tree: `world`, then for each robot `NAME/base`, `NAME/link1`, .., `NAME/flange`, `NAME/tool`, each in the
//! one before it. The base of a robot that is mounted on another one stands in that robot's flange. Bodies are blocks and
//! have the frame `NAME`. Obstacles never move: there is one picture of all of them.

use std::sync::Arc;

use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::{Figure, Layout, RobotLayout};
use mrroc_core::observe::solid::ObstacleLayout;
use mrroc_core::pose::Pose;
use serde_json::{Value, json};

use super::entity::{Entity, seconds, shown, update};
use super::json::{as_number, pose};
use super::obstacles;

/// The time between two pictures of a robot \[ns\]: 50 a second. Viewers draw at most 60 a second, and a picture takes some
/// times the bytes of a step's joints.
const EVERY: Nanos = 20_000_000;

/// The frame of what stands on nothing else.
const WORLD: &str = "world";

/// The radius of bars between the frames of a robot without a shape, as a share of its longest link, and its bounds \[m\].
const BAR: f64 = 0.05;
const BARS: [f64; 2] = [0.005, 0.05];

/// The radius of the bar from a flange to its tool \[m\].
const TOOL: f64 = 0.01;

/// A tool nearer to its flange than this has no bar \[m\].
const NO_TOOL: f64 = 0.001;

/// The colours of robots, in their order: red, green, blue, as shares. They are told apart by colour-blind people, too.
const COLOURS: [[f64; 3]; 6] = [
    [0.0, 0.45, 0.70],
    [0.90, 0.62, 0.0],
    [0.0, 0.62, 0.45],
    [0.80, 0.47, 0.65],
    [0.34, 0.71, 0.91],
    [0.84, 0.37, 0.0],
];
const BODY_COLOUR: [f64; 3] = [0.6, 0.6, 0.6];

/// What is drawn of a recording.
pub(super) struct Scene {
    actors: Vec<Actor>,
    obstacles: Vec<ObstacleLayout>,
}

/// A robot or a body.
struct Actor {
    topic: String,
    /// The number of its channel, once it has one.
    channel: Option<u16>,
    name: String,
    colour: [f64; 3],
    looks: Looks,
    /// When it is drawn next, in the cell's time.
    due: Nanos,
}

enum Looks {
    /// A robot, and the frame that it stands in.
    Robot(Arc<dyn Figure>, String),
    /// A block of these edges \[m\].
    Block([f64; 3]),
}

/// The two messages of one picture.
pub(super) struct Update {
    pub frames: Value,
    pub bodies: Value,
}

impl Scene {
    pub fn of(layout: &Layout) -> Scene {
        let robot = |(i, robot): (usize, &RobotLayout)| {
            let recorded = |name: &&String| layout.robots.iter().any(|robot| robot.name == **name);
            let stands_in = match robot.mounted_on.as_ref().filter(recorded) {
                Some(carrier) => format!("{carrier}/flange"),
                None => WORLD.to_owned(),
            };
            Actor {
                topic: format!("/robots/{}", robot.name),
                channel: None,
                name: robot.name.clone(),
                colour: COLOURS[i % COLOURS.len()],
                looks: Looks::Robot(Arc::clone(&robot.figure), stands_in),
                due: 0,
            }
        };
        let robots = layout.robots.iter().enumerate().map(robot);
        let bodies = layout.bodies.iter().map(|body| Actor {
            topic: format!("/bodies/{}", body.name),
            channel: None,
            name: body.name.clone(),
            colour: BODY_COLOUR,
            looks: Looks::Block(body.edges),
            due: 0,
        });
        let obstacles = layout.obstacles.iter().filter(|one| obstacles::is_drawn(one)).cloned().collect();
        Scene { actors: robots.chain(bodies).collect(), obstacles }
    }

    /// What stands in the cell, as a `foxglove.SceneUpdate`; `None` if nothing does.
    pub fn obstacles(&self, date: Nanos) -> Option<Value> {
        (!self.obstacles.is_empty()).then(|| obstacles::update(&self.obstacles, date, WORLD))
    }

    /// Learns the number of a topic's channel.
    pub fn knows(&mut self, topic: &str, channel: u16) {
        if let Some(actor) = self.actors.iter_mut().find(|actor| actor.topic == topic) {
            actor.channel = Some(channel);
        }
    }

    /// Whether a message of this channel, at a time of the cell, is to be drawn: the first of each part of [`EVERY`].
    pub fn wants(&mut self, channel: u16, time: Nanos) -> bool {
        let actor = self.actors.iter_mut().find(|actor| actor.channel == Some(channel));
        let Some(actor) = actor.filter(|actor| actor.due <= time) else { return false };
        actor.due = (time / EVERY + 1) * EVERY;
        true
    }

    /// The picture of a message, with the date of it; `None` if nobody knows where it is.
    pub fn update(&self, channel: u16, date: Nanos, json: &str) -> Option<Update> {
        let actor = self.actors.iter().find(|actor| actor.channel == Some(channel))?;
        let message: Value = serde_json::from_str(json).ok()?;
        let mut picture = Picture::at(date, actor);
        match &actor.looks {
            Looks::Robot(figure, stands_in) => {
                let joints = &message["measured"]["joints"];
                let joints: Option<Vec<f64>> = joints.as_array()?.iter().map(as_number).collect();
                let joints = joints.filter(|joints| joints.iter().all(|q| q.is_finite()))?;
                picture.robot(&**figure, stands_in, &joints, &pose(&message["tool"])?);
                Some(picture.update(stands_in))
            }
            Looks::Block(edges) => {
                picture.block(&pose(&message["pose"])?, *edges);
                Some(picture.update(WORLD))
            }
        }
    }
}

/// A picture of one robot or body that is being made.
struct Picture<'a> {
    date: Nanos,
    actor: &'a Actor,
    transforms: Vec<Value>,
    entity: Entity,
}

impl<'a> Picture<'a> {
    fn at(date: Nanos, actor: &'a Actor) -> Self {
        Picture { date, actor, transforms: Vec::new(), entity: Entity::of_colour(actor.colour) }
    }

    /// The links of a robot, where it stands, and its tool, `X_FE`.
    #[allow(non_snake_case)]
    fn robot(&mut self, figure: &dyn Figure, stands_in: &str, joints: &[f64], X_FE: &Pose) {
        let name = &self.actor.name;
        let mut frames = Vec::with_capacity(10);
        figure.frames(joints, &mut |frame| frames.push(*frame));
        let Some(flange) = frames.last().copied() else { return };
        let mut parent = (stands_in.to_owned(), Pose::identity());
        for (i, frame) in frames.iter().enumerate() {
            let child = match i {
                _ if i + 1 == frames.len() => format!("{name}/flange"),
                0 => format!("{name}/base"),
                _ => format!("{name}/link{i}"),
            };
            self.transform(&parent.0, &child, &(parent.1.inverse() * frame));
            parent = (child, *frame);
        }
        self.transform(&parent.0, &format!("{name}/tool"), X_FE);

        let mut capsules = Vec::new();
        figure.capsules(joints, &mut |ends, radius| capsules.push((ends, radius)));
        let at = |frame: &Pose| frame.translation.vector;
        if capsules.is_empty() {
            let links = || frames.windows(2).map(|pair| [at(&pair[0]), at(&pair[1])]);
            let longest = links().map(|[a, b]| (b - a).norm()).fold(0.0, f64::max);
            let radius = (BAR * longest).clamp(BARS[0], BARS[1]);
            capsules.extend(links().map(|ends| (ends, radius)));
            if frames.len() == 1 {
                capsules.push(([at(&flange); 2], radius));
            }
        }
        let tool = at(&(flange * X_FE));
        if (tool - at(&flange)).norm() > NO_TOOL {
            capsules.push(([at(&flange), tool], TOOL));
        }
        for (ends, radius) in capsules {
            self.entity.capsule(ends, radius);
        }
    }

    /// A block at `X_WB`.
    #[allow(non_snake_case)]
    fn block(&mut self, X_WB: &Pose, edges: [f64; 3]) {
        self.transform(WORLD, &self.actor.name.clone(), X_WB);
        self.entity.cube(X_WB, edges);
    }

    fn transform(&mut self, parent: &str, child: &str, pose: &Pose) {
        let shown = shown(pose);
        self.transforms.push(json!({
            "timestamp": seconds(self.date),
            "parent_frame_id": parent,
            "child_frame_id": child,
            "translation": shown["position"],
            "rotation": shown["orientation"],
        }));
    }

    fn update(self, frame: &str) -> Update {
        Update {
            frames: json!({"transforms": self.transforms}),
            bodies: update(&[self.entity.json(self.date, frame, &self.actor.name)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use core::time::Duration;
    use mrroc::prelude::*;
    use mrroc_core::nalgebra::Vector3;
    use mrroc_robots::{Gripper, Irp6, One, Simulated, SimulatedIrp6, Six};

    const START: Six = Six::new(0.4, -1.57, 0.16, -0.16, 4.71, 0.0);

    /// A gripper on an arm, and a brick.
    fn layout() -> Layout {
        let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &START));
        let hand = RobotSetup::new("hand", Gripper::new(), Simulated::new(Gripper::new(), &One::new(0.05)));
        Cell::new(Duration::from_millis(2))
            .robot(arm)
            .robot(hand.mounted_on("arm"))
            .shows_body("brick", [0.1, 0.2, 0.3], Pose::identity)
            .layout()
    }

    fn scene() -> Scene {
        let mut scene = Scene::of(&layout());
        for (topic, channel) in
            [("/robots/arm", 1), ("/robots/arm/orders", 2), ("/robots/hand", 3), ("/bodies/brick", 4)]
        {
            scene.knows(topic, channel);
        }
        scene
    }

    fn image(joints: &[f64], tool: &Pose) -> String {
        json!({"measured": {"joints": joints}, "tool": shown(tool)}).to_string()
    }

    /// The transforms of an update: parent, child, pose.
    fn transforms(update: &Update) -> Vec<(String, String, Pose)> {
        let list = update.frames["transforms"].as_array().expect("a list");
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        let of = |one: &Value| {
            let placed = pose(&json!({"position": one["translation"], "orientation": one["rotation"]}));
            (text(&one["parent_frame_id"]), text(&one["child_frame_id"]), placed.expect("a pose"))
        };
        list.iter().map(of).collect()
    }

    #[test]
    fn the_frames_of_an_arm_are_a_chain_from_the_world_to_its_tool() {
        let tool = Pose::translation(0.0, 0.1, 0.25);
        let update =
            scene().update(1, 1_700_000_000_123_456_789, &image(START.as_slice(), &tool)).expect("drawn");
        let chain = transforms(&update);
        let names: Vec<_> =
            chain.iter().map(|(parent, child, _)| (parent.as_str(), child.as_str())).collect();
        assert_eq!(names[0], ("world", "arm/base"));
        assert_eq!(names[names.len() - 2..], [("arm/link4", "arm/flange"), ("arm/flange", "arm/tool")]);
        assert!(names.windows(2).all(|pair| pair[0].1 == pair[1].0), "{names:?}");
        // Together they are the kinematics' own pose of the tool.
        let at = chain.iter().fold(Pose::identity(), |at, (.., pose)| at * pose);
        let expected = Irp6::nominal().forward(&START) * tool;
        assert!((at.inverse() * expected).translation.vector.norm() < 2e-5, "{at} {expected}");
        assert!(at.rotation.angle_to(&expected.rotation) < 2e-5);
        let time = json!({"sec": 1_700_000_000, "nsec": 123_456_789});
        assert_eq!(
            (&update.frames["transforms"][0]["timestamp"], &update.bodies["entities"][0]["timestamp"]),
            (&time, &time)
        );
    }

    #[test]
    fn a_hand_stands_in_the_flange_that_carries_it_and_has_bars_for_want_of_a_shape() {
        let update = scene().update(3, 0, &image(&[0.05], &Pose::identity())).expect("drawn");
        assert_eq!(transforms(&update)[0].0, "arm/flange");
        let entity = &update.bodies["entities"][0];
        assert_eq!((&entity["frame_id"], &entity["id"]), (&json!("arm/flange"), &json!("hand")));
        // From the base to one finger, and from that to the other one; no tool.
        assert_eq!(entity["cylinders"].as_array().map(Vec::len), Some(2));
    }

    #[test]
    fn the_ends_of_a_capsule_are_where_they_were_whatever_direction_it_points_in() {
        let scene = scene();
        for along in [Vector3::z(), -Vector3::z(), Vector3::x(), Vector3::new(-0.3, 0.2, -0.9)] {
            let mut picture = Picture::at(0, &scene.actors[0]);
            let a = Vector3::new(0.1, 0.2, 0.3);
            picture.entity.capsule([a, a + along], 0.04);
            let cylinder = &picture.entity.cylinders[0];
            let (placed, length) = (pose(&cylinder["pose"]).expect("a pose"), cylinder["size"]["z"].as_f64());
            assert!((length.expect("a length") - along.norm()).abs() < 1e-6);
            let end = placed * mrroc_core::nalgebra::Point3::new(0.0, 0.0, 0.5 * along.norm());
            assert!((end.coords - (a + along)).norm() < 3e-6, "{along}");
            assert_eq!(picture.entity.spheres.len(), 2);
        }
        // Of one point there is one ball.
        let mut picture = Picture::at(0, &scene.actors[0]);
        picture.entity.capsule([Vector3::x(); 2], 0.04);
        assert_eq!((picture.entity.cylinders.len(), picture.entity.spheres.len()), (0, 1));
    }

    #[test]
    fn a_body_is_a_block_where_it_is() {
        let at = Pose::translation(1.0, 2.0, 3.0) * Pose::rotation(Vector3::z() * FRAC_PI_2);
        let update =
            scene().update(4, 0, &json!({"step": 1, "pose": shown(&at)}).to_string()).expect("drawn");
        let entity = &update.bodies["entities"][0];
        assert_eq!(entity["cubes"][0]["size"], json!({"x": 0.1, "y": 0.2, "z": 0.3}));
        let placed = pose(&entity["cubes"][0]["pose"]).expect("a pose");
        assert!((placed.inverse() * at).translation.vector.norm() < 2e-6);
        assert_eq!(transforms(&update)[0].1, "brick");
    }

    #[test]
    fn a_robot_that_has_not_been_measured_is_not_drawn() {
        let unknown =
            json!({"measured": {"joints": vec!["NaN"; 6]}, "tool": shown(&Pose::identity())}).to_string();
        assert!(scene().update(1, 0, &unknown).is_none());
        assert!(scene().update(1, 0, "{}").is_none() && scene().update(2, 0, "{}").is_none());
    }

    #[test]
    fn the_first_message_of_each_fiftieth_of_a_second_is_drawn() {
        let mut scene = scene();
        let drawn = (0..1000_u64).filter(|ms| scene.wants(1, ms * 1_000_000)).collect::<Vec<_>>();
        assert_eq!(drawn, (0..50).map(|i| 20 * i).collect::<Vec<_>>());
        // A period that does not divide it, and a robot without a channel.
        let late = (0..100_u64).filter(|i| scene.wants(3, i * 7_000_000)).count();
        assert_eq!(late, 35);
        assert!(!scene.wants(9, 0));
    }
}
