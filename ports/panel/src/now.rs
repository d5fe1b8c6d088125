//! What a page is shown of a cell: at this moment, or at a moment of a recording.
//!
//! In: a [`CellMoment`], and what the cell is made of. Out: JSON. Links are capsules in the world; kinematics are the robots' own.

use mrroc_core::nalgebra::Vector3;
use mrroc_core::observe::layout::{BodyLayout, Figure, Layout, RobotLayout};
use mrroc_core::observe::solid::ObstacleLayout;
use mrroc_core::pose::Pose;
use mrroc_core::robot::JointKind;
use serde_json::{Value, json};

use crate::beside::{self, Beside, CarriedLoad, ReadingNow};
use crate::meshes::Meshes;
use crate::standing;
use crate::values::{finite, is_pose, numbers, rounded};

/// The radius of bars between the frames of a robot without a shape, as a share of its longest link, and its bounds \[m\].
const BAR: f64 = 0.05;
const BARS: [f64; 2] = [0.005, 0.05];

/// The demanded place of a robot is shown where one of its links ends so far from where it is measured \[m\].
const APART: f64 = 2e-3;

/// A cell at a moment.
#[derive(Clone, Debug, Default)]
pub struct CellMoment {
    /// The cell's time \[s\].
    pub time: f64,
    /// The epoch and the step of the MP, and how long a step is \[ns\].
    pub epoch: u32,
    pub step: u64,
    pub period: u64,
    /// The word of its state.
    pub state: &'static str,
    /// The word of what is done, by which generator or condition, in which instruction.
    pub doing: &'static str,
    pub by: String,
    pub instruction: u64,
    /// The rate of path time and the speed that the operator wants, 0 to 1.
    pub rate: f64,
    pub speed: f64,
    /// Whether it is at reduced speed, and whether a person holds what lets it move then.
    pub reduced: bool,
    pub held: bool,
    /// The first cause of a stop, what to do about it, and what forbids a reset.
    pub fault: Option<String>,
    pub help: Option<String>,
    pub persisting: Option<String>,
    /// The process that has the control of the cell.
    pub holder: Option<u32>,
    /// Its robots, by name.
    pub robots: Vec<RobotNow>,
    /// Where its bodies are, in the order of the layout; `None`: nobody knows.
    pub bodies: Vec<Option<Pose>>,
    /// The newest readings of its sensors, in the order of the layout.
    pub readings: Vec<ReadingNow>,
    /// Its processes.
    pub processes: Vec<Value>,
}

/// A robot at a moment.
#[derive(Clone, Debug)]
pub struct RobotNow {
    pub name: String,
    /// When it was so, the cell's time \[s\].
    pub time: f64,
    /// Joint positions [rad or m].
    pub demanded: Vec<f64>,
    pub measured: Vec<f64>,
    /// The pose of its tool, `X_WE`; of a mounted robot, in the flange that carries it.
    pub tool: Pose,
    /// What its own program does.
    pub doing: String,
    /// Whether a program lets it be jogged now, and why it stands though it is.
    pub jogs: bool,
    pub stop: String,
    /// What it carries, and its inputs and outputs.
    pub carried: CarriedLoad,
}

/// What a cell looks like.
pub struct Appearance {
    robots: Vec<RobotLayout>,
    bodies: Vec<BodyLayout>,
    obstacles: Vec<ObstacleLayout>,
    beside: Beside,
    meshes: Meshes,
    step: f64,
}

impl Appearance {
    /// Of a cell of this layout.
    #[must_use]
    pub fn of(layout: &Layout) -> Appearance {
        Appearance {
            robots: layout.robots.clone(),
            bodies: layout.bodies.clone(),
            obstacles: layout.obstacles.clone(),
            beside: Beside::of(layout),
            meshes: Meshes::of(&layout.robots),
            step: layout.step.as_secs_f64(),
        }
    }

    /// What stays as it is. A recording lasts for some time \[s\].
    #[must_use]
    pub fn layout(&self, lasts: Option<f64>) -> Value {
        let joint = |kind| match kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
        };
        let robots = self.robots.iter().enumerate().map(|(place, robot)| {
            let joints = robot.joints.iter().map(
                |of| json!({"kind": joint(of.kind), "lower": finite(of.lower), "upper": finite(of.upper)}),
            );
            json!({
                "name": robot.name,
                "kind": robot.kind,
                "on": robot.mounted_on,
                "joints": joints.collect::<Value>(),
                "signals": beside::signals(robot),
                "meshes": self.meshes.of_robot(place),
            })
        });
        let bodies = self.bodies.iter().map(|body| json!({"name": body.name, "edges": body.edges}));
        let mut layout = json!({
            "kind": "layout",
            "lasts": lasts,
            "step": self.step,
            "robots": robots.collect::<Value>(),
            "bodies": bodies.collect::<Value>(),
            "obstacles": standing::obstacles(&self.obstacles),
        });
        self.beside.layout(&mut layout);
        layout
    }

    /// What changes.
    #[must_use]
    pub fn state(&self, now: &CellMoment) -> Value {
        let robots = now.robots.iter().filter_map(|robot| self.robot(robot, now));
        let bodies = now.bodies.iter().map(|pose| pose.as_ref().filter(|pose| is_pose(pose)).map(numbers));
        json!({
            "kind": "state",
            "time": now.time,
            "epoch": now.epoch,
            "step": now.step,
            "period": now.period,
            "state": now.state,
            "doing": now.doing,
            "by": now.by,
            "instruction": now.instruction,
            "rate": finite(now.rate),
            "speed": finite(now.speed),
            "reduced": now.reduced,
            "held": now.held,
            "fault": now.fault,
            "help": now.help,
            "persisting": now.persisting,
            "holder": now.holder,
            "robots": robots.collect::<Value>(),
            "bodies": bodies.collect::<Value>(),
            "readings": self.beside.readings(&now.readings),
            "processes": now.processes,
        })
    }

    /// What plots show of a moment.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn plotted(&self, now: &CellMoment) -> Value {
        let robots = now.robots.iter().filter_map(|robot| {
            let (_, X_WS, is_measured) = self.placed(robot, now)?;
            Some(json!({
                "name": robot.name,
                "time": robot.time,
                "demanded": round(&robot.demanded),
                "measured": round(&robot.measured),
                "tool": is_measured.then(|| numbers(&(X_WS * robot.tool))),
            }))
        });
        json!({
            "time": now.time,
            "robots": robots.collect::<Value>(),
            "readings": self.beside.readings(&now.readings),
        })
    }

    /// A robot whose place is known: its links as capsules, its frames and its tool, in the world; and as a ghost the links where they
    /// are demanded, if that is elsewhere.
    #[allow(non_snake_case)]
    fn robot(&self, robot: &RobotNow, now: &CellMoment) -> Option<Value> {
        let (layout, X_WS, is_measured) = self.placed(robot, now)?;
        let (mut links, mut ghost, mut frames) = (Vec::new(), Vec::new(), Vec::new());
        if is_measured {
            links = capsules(&*layout.figure, &robot.measured);
            if robot.demanded.iter().all(|q| q.is_finite()) {
                ghost = capsules(&*layout.figure, &robot.demanded);
                let apart = |(one, other): (&Capsule, &Capsule)| {
                    one.0.iter().zip(&other.0).any(|(a, b)| (a - b).norm() > APART)
                };
                if !links.iter().zip(&ghost).any(apart) {
                    ghost.clear();
                }
            }
            layout.figure.frames(&robot.measured, &mut |frame| frames.push(numbers(&(X_WS * frame))));
        }
        let place = |at: &Vector3<f64>| X_WS * mrroc_core::nalgebra::Point3::from(*at);
        let placed = |links: &[Capsule]| -> Vec<[f64; 7]> {
            let link = |(ends, radius): &Capsule| {
                let [a, b] = [place(&ends[0]), place(&ends[1])];
                [a.x, a.y, a.z, b.x, b.y, b.z, *radius].map(rounded)
            };
            links.iter().map(link).collect()
        };
        Some(json!({
            "name": robot.name,
            "time": robot.time,
            "demanded": round(&robot.demanded),
            "measured": round(&robot.measured),
            "doing": robot.doing,
            "jogs": robot.jogs,
            "stop": robot.stop,
            "links": placed(&links),
            "ghost": placed(&ghost),
            "frames": frames,
            "tool": is_measured.then(|| numbers(&(X_WS * robot.tool))),
            "carried": self.beside.carried(&robot.carried),
            "signals": beside::values(layout, robot.carried.signals.as_ref()),
        }))
    }

    /// What it has beside its robots' links.
    pub const fn beside(&self) -> &Beside {
        &self.beside
    }

    /// The meshes of its robots.
    pub const fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// How many bodies it has.
    pub const fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// The names of its robots.
    pub fn robots(&self) -> impl Iterator<Item = &str> {
        self.robots.iter().map(|robot| robot.name.as_str())
    }

    /// The path of a robot's tool in the world, straight in joint space from where it is demanded to be to other joints [rad or m]:
    /// so many places \[m\].
    ///
    /// # Errors
    /// The robot is not known, its joints are others, or one of them would be beyond its limits.
    #[allow(non_snake_case)]
    pub fn tool_path(
        &self,
        robots: &[RobotNow],
        name: &str,
        to: &[f64],
        places: usize,
    ) -> Result<Vec<[f64; 3]>, String> {
        let unknown = || format!("there is no robot `{name}`");
        let layout = self.robots.iter().find(|known| known.name == name).ok_or_else(unknown)?;
        let robot = robots.iter().find(|known| known.name == name).ok_or_else(unknown)?;
        if to.len() != layout.joints.len() || robot.demanded.len() != to.len() {
            return Err(format!("the pose has {} joints, `{name}` has {}", to.len(), layout.joints.len()));
        }
        let beyond =
            layout.joints.iter().zip(to).position(|(joint, q)| !(joint.lower..=joint.upper).contains(q));
        if let Some(joint) = beyond {
            return Err(format!("joint {} of the pose is beyond its limits", joint + 1));
        }
        let flange = |joints: &[f64]| {
            let mut last = None;
            layout.figure.frames(joints, &mut |frame| last = Some(*frame));
            last
        };
        let now = CellMoment { robots: robots.to_vec(), ..CellMoment::default() };
        let X_WS = self.stands(layout, &now, self.robots.len()).ok_or_else(unknown)?;
        let X_FE = flange(&robot.measured).ok_or_else(unknown)?.inv_mul(&robot.tool);
        let at = |i: usize| {
            let share = i as f64 / (places - 1).max(1) as f64;
            let joints: Vec<f64> =
                robot.demanded.iter().zip(to).map(|(from, to)| from + share * (to - from)).collect();
            let at = (X_WS * flange(&joints)? * X_FE).translation.vector;
            Some([at.x, at.y, at.z].map(rounded))
        };
        (0..places).map(at).collect::<Option<_>>().ok_or_else(unknown)
    }

    /// What a robot is made of, where the frame is that it stands in, and whether its joints and its tool are measured.
    #[allow(non_snake_case)]
    fn placed(&self, robot: &RobotNow, now: &CellMoment) -> Option<(&RobotLayout, Pose, bool)> {
        let layout = self.robots.iter().find(|known| known.name == robot.name)?;
        let X_WS = self.stands(layout, now, self.robots.len())?;
        let is_measured = robot.measured.iter().all(|q| q.is_finite()) && is_pose(&robot.tool);
        Some((layout, X_WS, is_measured))
    }

    /// Where the frame is that a robot stands in, after at most so many robots that carry each other.
    #[allow(non_snake_case)]
    fn stands(&self, robot: &RobotLayout, now: &CellMoment, most: usize) -> Option<Pose> {
        let Some(carrier) = &robot.mounted_on else { return Some(Pose::identity()) };
        let layout = self.robots.iter().find(|known| known.name == *carrier).filter(|_| most > 0)?;
        let measured = &now.robots.iter().find(|known| known.name == *carrier)?.measured;
        let X_WS = self.stands(layout, now, most - 1)?;
        let mut flange = None;
        layout.figure.frames(measured, &mut |frame| flange = Some(*frame));
        flange.map(|X_SF| X_WS * X_SF).filter(is_pose)
    }
}

/// A link: the middles of its ends, and its radius \[m\].
type Capsule = ([Vector3<f64>; 2], f64);

/// The links of a robot; of one that gives no shape, bars between its frames.
fn capsules(figure: &dyn Figure, joints: &[f64]) -> Vec<Capsule> {
    let mut links = Vec::new();
    figure.capsules(joints, &mut |ends, radius| links.push((ends, radius)));
    if links.is_empty() {
        let mut at = Vec::new();
        figure.frames(joints, &mut |frame| at.push(frame.translation.vector));
        let longest = at.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        let radius = (BAR * longest).clamp(BARS[0], BARS[1]);
        links.extend(at.windows(2).map(|pair| ([pair[0], pair[1]], radius)));
        if let [only] = at[..] {
            links.push(([only; 2], radius));
        }
    }
    links
}

fn round(joints: &[f64]) -> Vec<Option<f64>> {
    joints.iter().map(|q| finite(rounded(*q))).collect()
}
