//! What another node asks for, as a goal of the cell.
//!
//! In: a request of `control_msgs/FollowJointTrajectory`, and what the cell is made of. Out: the robots that it names with all their joints, and
//! their trajectory; or by which error code it is refused, and why.

use mrroc_core::fault::{Excess, Name};
use mrroc_core::observe::layout::Layout;
use mrroc_core::robot::JointKind;
use mrroc_core::suggestion::suggestion;
use mrroc_external::goals::{Goal, GoalState, MOST_WORDS, refusal};
use mrroc_generators::trajectory::{
    JointBounds, JointState, JointTrajectory, Quantity, TimedPath, TrajectoryError, TrajectoryPoint,
};

use super::messages::{
    INVALID_GOAL, INVALID_JOINTS, OLD_HEADER_TIMESTAMP, Outcome, Point, Request, Tolerance,
};
use crate::node::topic_name;

/// Robots that can be asked for, and the names of their joints.
pub struct Offered {
    pub layout: Layout,
    /// Of each robot of the layout.
    pub joints: Vec<Vec<String>>,
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    pub goal: Goal,
    /// Robots of the layout, as in the goal.
    pub robots: Vec<usize>,
    /// The names of the joints as they were asked for, and the place of each in the goal.
    pub names: Vec<(String, usize)>,
    /// How far each joint of the goal may be from where it is to be, on the path and at its end.
    pub path: Vec<Bounds>,
    pub end: Vec<Bounds>,
    /// How long after the end of the trajectory the joints may take \[s\].
    pub time: f64,
}

/// Of one joint; infinite where nothing is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// [rad or m].
    pub position: f64,
    /// [rad/s or m/s].
    pub velocity: f64,
}

/// The time after the end of a trajectory where a request says none \[s\].
const GOAL_TIME: f64 = 10.0;

/// The longest trajectory \[s\].
const LONGEST: f64 = 600.0;

/// At how many instants limits that joints share are looked at, at most: in steps of the cell where the trajectory has fewer.
const INSTANTS: f64 = 5000.0;

fn refused(error_code: i32, why: impl Into<String>) -> Outcome {
    Outcome { error_code, error_string: why.into(), is_elsewhere: false }
}

impl Offered {
    /// Reads a request for one robot, or for any, that came at a time since 1970 \[ns\].
    ///
    /// # Errors
    /// Why it is refused.
    pub fn read(&self, request: &Request, only: Option<usize>, now: u64) -> Result<Asked, Outcome> {
        let trajectory = &request.trajectory;
        let of_components = [&request.component_path_tolerance, &request.component_goal_tolerance];
        let has_components = of_components.iter().any(|tolerances| !tolerances.is_empty());
        if !request.multi_dof_trajectory.joint_names.is_empty() || has_components {
            return Err(refused(INVALID_GOAL, "robots have joints of one degree of freedom only"));
        }
        if trajectory.points.iter().any(|point| !point.effort.is_empty()) {
            return Err(refused(INVALID_GOAL, "efforts cannot be asked for"));
        }
        let count: usize = trajectory.points.iter().map(Point::numbers).sum();
        if count > MOST_WORDS {
            let why =
                format!("the trajectory has {count} numbers, {MOST_WORDS} are possible: send fewer points");
            return Err(refused(INVALID_GOAL, why));
        }
        let (robots, places) = self.places(&trajectory.joint_names, only)?;
        let limits: Vec<JointBounds> = robots
            .iter()
            .flat_map(|&robot| self.layout.robots[robot].joints.iter().map(JointBounds::from))
            .collect();
        let points: Result<Vec<_>, String> = trajectory
            .points
            .iter()
            .enumerate()
            .map(|(place, point)| told(point, &places).map_err(|why| format!("point {}: {why}", place + 1)))
            .collect();
        let points = points.map_err(|why| refused(INVALID_GOAL, why))?;
        let made = JointTrajectory::new(limits, points);
        let made = made.map_err(|why| refused(INVALID_GOAL, self.name_joints(&why, &robots)))?;
        if made.duration() > LONGEST {
            let why = format!("the last point is at {} s: at most {LONGEST} s are possible", made.duration());
            return Err(refused(INVALID_GOAL, why));
        }
        let (delay, passed) = begins(&trajectory.header.stamp, now);
        if passed >= made.duration() {
            let why = format!("the last point is {:.3} s in the past", passed - made.duration());
            return Err(refused(OLD_HEADER_TIMESTAMP, why));
        }
        let names: Result<Vec<_>, _> =
            robots.iter().map(|&robot| Name::new(&self.layout.robots[robot].name)).collect();
        let names = names.map_err(|bad| refused(INVALID_JOINTS, bad.to_string()))?;
        let joints = places.len();
        let bounds =
            |tolerances: &[Tolerance]| self.bounds(tolerances, &trajectory.joint_names, &places, joints);
        let time = match request.goal_time_tolerance.seconds() {
            0.0 => GOAL_TIME,
            -1.0 => f64::INFINITY,
            time if time > 0.0 => time,
            _ => return Err(refused(INVALID_GOAL, "the goal's time tolerance is neither -1 nor at least 0")),
        };
        Ok(Asked {
            goal: Goal { robots: names, trajectory: made.passed(passed), delay },
            robots,
            names: trajectory.joint_names.iter().cloned().zip(places.iter().copied()).collect(),
            path: bounds(&request.path_tolerance)?,
            end: bounds(&request.goal_tolerance)?,
            time,
        })
    }

    /// The robots whose joints have these names, and the place of each joint among those of all these robots.
    fn places(&self, names: &[String], only: Option<usize>) -> Result<(Vec<usize>, Vec<usize>), Outcome> {
        let mut found: Vec<(usize, usize)> = Vec::with_capacity(names.len());
        for name in names {
            let joint = self.joint(name, only).map_err(|why| refused(INVALID_JOINTS, why))?;
            if found.contains(&joint) {
                return Err(refused(INVALID_JOINTS, format!("joint `{name}` is named twice")));
            }
            found.push(joint);
        }
        let mut robots: Vec<usize> = found.iter().map(|&(robot, _)| robot).collect();
        robots.sort_unstable();
        robots.dedup();
        let mut before = 0;
        let mut places = vec![0; found.len()];
        for &robot in &robots {
            for joint in 0..self.joints[robot].len() {
                let Some(place) = found.iter().position(|&named| named == (robot, joint)) else {
                    let missing = &self.joints[robot][joint];
                    let of = &self.layout.robots[robot].name;
                    let why = format!(
                        "joint `{missing}` of robot `{of}` is missing: a goal is for all joints of a robot"
                    );
                    return Err(refused(INVALID_JOINTS, why));
                };
                places[place] = before + joint;
            }
            before += self.joints[robot].len();
        }
        Ok((robots, places))
    }

    /// The robot and the joint of a name: the joint's own, where one robot alone has it, or with the robot's before it.
    fn joint(&self, name: &str, only: Option<usize>) -> Result<(usize, usize), String> {
        let mut found = Vec::new();
        for (robot, joints) in self.joints.iter().enumerate() {
            if only.is_some_and(|only| only != robot) {
                continue;
            }
            let of = topic_name(&self.layout.robots[robot].name);
            let after = name.strip_prefix(&of).and_then(|rest| rest.strip_prefix(['/', '_']));
            let fits = |joint: &String| *joint == name || after.is_some_and(|after| *joint == after);
            found.extend(joints.iter().position(fits).map(|joint| (robot, joint)));
        }
        match found[..] {
            [one] => Ok(one),
            [] => Err(format!("no joint is called `{name}`: {}", self.meant(name, only))),
            [..] => {
                Err(format!("several robots have a joint `{name}`: put the robot's name and a `/` before it"))
            }
        }
    }

    /// Which joint a name that is none may mean.
    fn meant(&self, name: &str, only: Option<usize>) -> String {
        let asked = (0..self.joints.len()).filter(|robot| only.is_none_or(|only| only == *robot));
        let robots: Vec<usize> = asked.collect();
        let whole: Vec<String> = robots.iter().flat_map(|&robot| self.whole_names(robot)).collect();
        match robots[..] {
            // The robot is known, or there is one alone.
            [robot] if !name.contains('/') => suggestion(name, &self.joints[robot], "there are"),
            _ => suggestion(name, &whole, "there are"),
        }
    }

    /// The names of a robot's joints, with its own before them.
    fn whole_names(&self, robot: usize) -> impl Iterator<Item = String> {
        let of = topic_name(&self.layout.robots[robot].name);
        self.joints[robot].iter().map(move |joint| format!("{of}/{joint}"))
    }

    /// A tolerance of each joint.
    fn bounds(
        &self,
        tolerances: &[Tolerance],
        names: &[String],
        places: &[usize],
        joints: usize,
    ) -> Result<Vec<Bounds>, Outcome> {
        let none = Bounds { position: f64::INFINITY, velocity: f64::INFINITY };
        let mut bounds = vec![none; joints];
        for tolerance in tolerances {
            let place = names.iter().position(|name| *name == tolerance.name).ok_or_else(|| {
                refused(
                    INVALID_JOINTS,
                    format!("a tolerance is of joint `{}`, which the trajectory has not", tolerance.name),
                )
            })?;
            // 0 is nothing said, -1 is no bound.
            let of = |value: f64| if value > 0.0 { value } else { f64::INFINITY };
            let bad = [tolerance.position, tolerance.velocity, tolerance.acceleration];
            if bad.iter().any(|value| value.is_nan() || (*value < 0.0 && *value != -1.0)) {
                let why = format!("the tolerance of joint `{}` is neither -1 nor at least 0", tolerance.name);
                return Err(refused(INVALID_GOAL, why));
            }
            if tolerance.acceleration > 0.0 {
                return Err(refused(
                    INVALID_GOAL,
                    "accelerations are not measured: they can have no tolerance",
                ));
            }
            bounds[places[place]] =
                Bounds { position: of(tolerance.position), velocity: of(tolerance.velocity) };
        }
        Ok(bounds)
    }

    /// Checks what is asked of robots that rest at these joint positions, one robot behind the other: all limits, also those that joints share.
    ///
    /// # Errors
    /// The first one that would be exceeded.
    pub fn check(&self, asked: &Asked, at: &[f64]) -> Result<(), Outcome> {
        let states: Vec<_> = at.iter().copied().map(JointState::resting).collect();
        self.check_from(asked, &asked.goal.trajectory, &states)
    }

    /// The same from its first point on, wherever the robots come from.
    ///
    /// # Errors
    /// The first limit that would certainly be exceeded. Bare positions are passed on a spline whose shape depends on where the robots come from: of these the points themselves are
    /// looked at, and the mean velocity between two of them, which no path falls below.
    pub fn check_onwards(&self, asked: &Asked) -> Result<(), Outcome> {
        let trajectory = &asked.goal.trajectory;
        let wrong = |why: &TrajectoryError| refused(INVALID_GOAL, self.name_joints(why, &asked.robots));
        let points = trajectory.points();
        if !points[0].velocities.is_empty() {
            let begins = points[0].time;
            let states = (0..trajectory.limits().len()).map(|joint| JointState {
                position: points[0].positions[joint],
                velocity: points[0].velocities[joint],
                acceleration: points[0].accelerations.get(joint).copied().unwrap_or_default(),
            });
            let states: Vec<_> = states.collect();
            let mut points = points.to_vec();
            points.iter_mut().for_each(|point| point.time -= begins);
            let onwards = JointTrajectory::new(trajectory.limits().to_vec(), points);
            return self.check_from(asked, &onwards.map_err(|why| wrong(&why))?, &states);
        }
        for (joint, limits) in trajectory.limits().iter().enumerate() {
            let exceeds = |quantity, point: usize, value, limit| {
                Err(wrong(&TrajectoryError::Limit {
                    quantity,
                    joint: joint + 1,
                    point: point + 1,
                    value,
                    limit,
                }))
            };
            for (place, point) in points.iter().enumerate() {
                let value = point.positions[joint];
                if value < limits.lower || value > limits.upper {
                    let limit = if value < limits.lower { limits.lower } else { limits.upper };
                    return exceeds(Quantity::Position, place, value, limit);
                }
            }
            for (place, two) in points.windows(2).enumerate() {
                let value = (two[1].positions[joint] - two[0].positions[joint]) / (two[1].time - two[0].time);
                if value.abs() > limits.velocity {
                    return exceeds(Quantity::Velocity, place + 1, value, limits.velocity.copysign(value));
                }
            }
        }
        Ok(())
    }

    fn check_from(
        &self,
        asked: &Asked,
        trajectory: &JointTrajectory,
        states: &[JointState],
    ) -> Result<(), Outcome> {
        let path = TimedPath::from(trajectory, states).map_err(|why| {
            let is_elsewhere = matches!(why, TrajectoryError::Start { .. });
            Outcome { is_elsewhere, ..refused(INVALID_GOAL, self.name_joints(&why, &asked.robots)) }
        })?;
        let step = self.layout.step.as_secs_f64().max(path.duration() / INSTANTS);
        let steps = (path.duration() / step).ceil() as usize;
        let mut first = 0;
        for &robot in &asked.robots {
            let of = &self.layout.robots[robot];
            let joints = first..first + of.joints.len();
            first = joints.end;
            if of.coupled_limits.is_empty() {
                continue;
            }
            let positions =
                |k: usize| joints.clone().map(|joint| path.at(k as f64 * step, joint)[0]).collect::<Vec<_>>();
            let mut from = positions(0);
            for k in 1..=steps {
                let to = positions(k);
                if let Err(limit) = of.figure.check_coupled(&from, &to, step) {
                    let (at, Excess { actual, limit: most, unit }) = (k as f64 * step, limit.excess);
                    let why = format!(
                        "robot `{}`, {at:.3} s: {} {actual:.4} {unit}, at most {most:.4}",
                        of.name, limit.what
                    );
                    return Err(refused(INVALID_GOAL, why));
                }
                from = to;
            }
        }
        Ok(())
    }

    /// An error with the name and the units of its joint.
    fn name_joints(&self, why: &TrajectoryError, robots: &[usize]) -> String {
        match *why {
            TrajectoryError::Limit { quantity, joint, point, value, limit } => {
                self.joint_of(joint, robots).beyond(quantity, value, point, limit)
            }
            TrajectoryError::Start { joint, position, start } => {
                self.joint_of(joint, robots).elsewhere(position, start)
            }
            TrajectoryError::MovingEnd { joint, velocity } => {
                let Joint { name, kind } = self.joint_of(joint, robots);
                let unit = kind.unit(1);
                format!(
                    "joint `{name}` has a velocity of {velocity:.6} {unit} at the last point: the robots must be at rest there"
                )
            }
            TrajectoryError::NotFinite { joint, point } => {
                let name = self.joint_of(joint, robots).name;
                format!("point {point} has a value that is no finite number, for joint `{name}`")
            }
            _ => why.to_string(),
        }
    }

    /// A joint, counted from 1, of these robots.
    fn joint_of(&self, joint: usize, robots: &[usize]) -> Joint {
        let kinds = |robot: usize| self.layout.robots[robot].joints.iter().map(|joint| joint.kind);
        let mut joints = robots.iter().flat_map(|&robot| self.whole_names(robot).zip(kinds(robot)));
        let found = joints.nth(joint.wrapping_sub(1));
        let (name, kind) = found.unwrap_or_else(|| (joint.to_string(), JointKind::Revolute));
        Joint { name, kind }
    }

    /// Why the cell did not begin a goal, for these robots.
    pub fn refusal(&self, state: &GoalState, robots: &[usize]) -> String {
        let [joint, point, value, limit] = state.about;
        let joint = self.joint_of(joint as usize, robots);
        let beyond = |quantity| joint.beyond(quantity, value, point as usize, limit);
        match state.refusal {
            refusal::NOT_OFFERED => "the cell's program does not offer all these robots now".to_owned(),
            refusal::SHARED => {
                "a robot moves by a goal of other robots, too: cancel that one first".to_owned()
            }
            refusal::START => joint.elsewhere(value, limit),
            refusal::POSITION => beyond(Quantity::Position),
            refusal::VELOCITY => beyond(Quantity::Velocity),
            refusal::ACCELERATION => beyond(Quantity::Acceleration),
            refusal::JERK => beyond(Quantity::Jerk),
            refusal::UNREADABLE => "the cell cannot read it: is the bridge of another version?".to_owned(),
            refusal::OLD => "the cell's program has begun anew".to_owned(),
            _ => "the cell finds its points wrong".to_owned(),
        }
    }
}

/// A joint as a refusal names it.
struct Joint {
    name: String,
    kind: JointKind,
}

impl Joint {
    /// It would exceed a limit on the way to a point.
    fn beyond(&self, quantity: Quantity, value: f64, point: usize, limit: f64) -> String {
        let unit = self.kind.unit(match quantity {
            Quantity::Position => 0,
            Quantity::Velocity => 1,
            Quantity::Acceleration | Quantity::StepOfAcceleration => 2,
            Quantity::Jerk => 3,
        });
        let Joint { name, .. } = self;
        format!(
            "joint `{name}`: {quantity} {value:.4} {unit} on the way to point {point}, at most {limit:.4} {unit}"
        )
    }

    /// It is not where the trajectory begins.
    fn elsewhere(&self, position: f64, start: f64) -> String {
        let (Joint { name, .. }, unit) = (self, self.kind.unit(0));
        format!(
            "joint `{name}` is at {position:.4} {unit}, the trajectory begins at {start:.4} {unit}: plan from where the robot is"
        )
    }
}

/// A point, in the order of the robots' joints.
fn told(point: &Point, places: &[usize]) -> Result<TrajectoryPoint, String> {
    let sorted = |what: &str, values: &[f64], may_miss: bool| {
        if values.is_empty() && may_miss {
            return Ok(Vec::new());
        }
        if values.len() != places.len() {
            return Err(format!("{} {what} for {} joints", values.len(), places.len()));
        }
        let mut sorted = vec![0.0; places.len()];
        for (&place, &value) in places.iter().zip(values) {
            sorted[place] = value;
        }
        Ok(sorted)
    };
    Ok(TrajectoryPoint {
        time: point.time_from_start.seconds(),
        positions: sorted("positions", &point.positions, false)?,
        velocities: sorted("velocities", &point.velocities, true)?,
        accelerations: sorted("accelerations", &point.accelerations, true)?,
    })
}

/// How long until a stamp, and how long since it \[s\]; a stamp of 0 is now.
fn begins(stamp: &crate::messages::Stamp, now: u64) -> (f64, f64) {
    let at = i128::from(stamp.sec) * 1_000_000_000 + i128::from(stamp.nanosec);
    if at == 0 {
        return (0.0, 0.0);
    }
    let ahead = (at - i128::from(now)) as f64 * 1e-9;
    (ahead.max(0.0), (-ahead).max(0.0))
}
