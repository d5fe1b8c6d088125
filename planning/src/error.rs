//! Why there is no plan.

use mrroc::fault::{Fault, Name};
use mrroc_generators::timing::TimingError;
use mrroc_robots::clearance::{CheckError, ClearanceError, Nearest};
use thiserror::Error;

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlanError {
    /// A planner plans for one to four robots.
    #[error("a planner takes 1 to 4 robots, here are {0}")]
    Robots(usize),
    /// The reaction time is no time.
    #[error("a reaction time of {0} s: it must be finite and at least 0")]
    Reaction(f64),
    /// A list of positions is longer or shorter than the robots have joints, or a robot has another number of joints than it is told to have.
    #[error(
        "{expected} joint positions are needed, {actual} were given: those of all robots, one behind the other"
    )]
    Joints {
        /// Joints of all robots, or of the one.
        expected: usize,
        /// Positions given, or joints of the kinematics that were told.
        actual: usize,
    },
    /// A joint of the start or of a goal is no number, or beyond its limits; or one of arms that carry a body may be on its path.
    #[error(
        "{robot} joint {joint}: position {position} of the {place} is not within its limits {lower} to {upper}"
    )]
    Limit {
        /// `start`, `goal` or `path`.
        place: &'static str,
        /// The robot.
        robot: String,
        /// The joint, counted from 1.
        joint: usize,
        /// Its position [rad or m].
        position: f64,
        /// Its lower limit [rad or m].
        lower: f64,
        /// Its upper limit [rad or m].
        upper: f64,
    },
    /// An arm that holds a body cannot hold it at the goal, on the branch of its inverse kinematics that it has at the start.
    #[error(
        "{robot} cannot hold the body at the goal: no joint positions within the limits on the branch of the start"
    )]
    OffBranch {
        /// The robot.
        robot: String,
    },
    /// On a path of a body an arm comes to a singular posture or to a limit, behind so much of the path.
    #[error("the arms cannot follow the body beyond {at:.0} % of its path: a singular posture or a limit")]
    Singular {
        /// Behind so much of the path [%].
        at: f64,
    },
    /// The motion of the arms along a path of a body is not proven clear by the margin, behind so much of the path.
    #[error(
        "the arms are not proven clear by the margin behind {at:.0} % of the body's path: help: another seed, or a smaller margin"
    )]
    CarryNotClear {
        /// Behind so much of the path [%].
        at: f64,
    },
    /// No arm is told to hold the body.
    #[error("no robot holds the body: help: tell `Holders::and` those that do")]
    NoHolder,
    /// The kinematics of a robot that holds a body are not those of the clearance.
    #[error(
        "{robot}: its flange is {apart:.2e} m from where the clearance has it at the start, at most {limit:.0e} m are allowed: help: tell `Holders::and` the kinematics with the base that the clearance has"
    )]
    OtherFlange {
        /// The robot.
        robot: String,
        /// From one flange to the other \[m\].
        apart: f64,
        /// The most that is allowed \[m\].
        limit: f64,
    },
    /// In the clearance no holder has grasped the body, so nothing would keep it clear.
    #[error(
        "none of the robots that hold the body ({robots}) has grasped it in the clearance, so it would not be checked: help: call `Clearance::grasp` for one of them, and make the planner of that clearance"
    )]
    NotGrasped {
        /// The robots that hold it.
        robots: String,
    },
    /// A new plan is asked for arms that carry a body by a plan.
    #[error(
        "no new plan of joints for robots that carry a body together: they would pull at it: help: let them come to rest, then ask `Planner::carry`"
    )]
    CarriesBody,
    /// Joints of the start or of a goal share a limit that they do not keep, or have no posture there.
    #[error("{robot}: the joints of the {place} do not go together: a limit that they share is not kept")]
    Coupled {
        /// `start`, `goal`, `stop` or `standing position`.
        place: &'static str,
        /// The robot.
        robot: String,
    },
    /// An axis that is to be kept upright is not, at the start or at all goals; of several goals it is the first.
    #[error(
        "{robot}: the axis that is kept upright is tilted by {tilt:.4} rad at the {place}, {tolerance:.4} rad are allowed"
    )]
    NotUpright {
        /// `start` or `goal`.
        place: &'static str,
        /// The robot.
        robot: String,
        /// Its angle from the vertical \[rad\].
        tilt: f64,
        /// The largest that is allowed \[rad\].
        tolerance: f64,
    },
    /// An axis or its tolerance are no direction and angle.
    #[error(
        "{robot}: an axis that is kept upright is finite and not zero, its tolerance above 0 and below pi rad"
    )]
    BadUpright {
        /// The robot.
        robot: String,
    },
    /// The robots are too near to something at the start.
    #[error("the start is not clear by the margin: {0}")]
    StartNotClear(Box<Nearest>),
    /// They are at all goals; told is the first.
    #[error("the goal is not clear by the margin: {0}")]
    GoalNotClear(Box<Nearest>),
    /// There is no goal.
    #[error("no goal: the pose has no solution within the limits of the joints")]
    NoGoal,
    /// The effort was spent.
    #[error(
        "no path found in {checks} checks: the nearest that was reached is {apart:.3} rad or m from a goal, where {nearest}: help: allow more effort, or see what is in between"
    )]
    NotFound {
        /// Checks of eight postures.
        checks: u64,
        /// From there to a goal: the root of the sum of squares over all joints [rad or m].
        apart: f64,
        /// What is nearest there.
        nearest: Box<Nearest>,
    },
    /// A motion through positions is given no list of them.
    #[error("no list of goals: a motion through positions needs at least one list, that of its end")]
    NoStage,
    /// A motion through several lists of positions fails at one of them.
    #[error("no motion to list {stage} of {stages}: {why}")]
    Stage {
        /// The list, counted from 1.
        stage: usize,
        /// How many lists there are.
        stages: usize,
        /// Why.
        why: Box<PlanError>,
    },
    /// Even at a thousandth of the speed the stops are not proven clear at one place.
    #[error(
        "no speed is slow enough for the stops at {at:.0} % of the path: help: a smaller margin, or a shorter reaction time"
    )]
    StopsNotClear {
        /// Share of the path [%].
        at: f64,
    },
    /// The path has no motion within the limits.
    #[error("the path has no motion within the limits")]
    Timing(#[from] TimingError),
    /// A new plan is asked for robots that follow a plan of others.
    #[error("the plan is of the robots {plan}, the planner plans for {planner}")]
    OtherRobots {
        /// The robots of the plan.
        plan: String,
        /// Those of the planner.
        planner: String,
    },
    /// There is no time for planning before robots are handed over.
    #[error("a lead of {lead} s of path time: planning needs at least {least} s")]
    Lead {
        /// What was given \[s\].
        lead: f64,
        /// The least \[s\].
        least: f64,
    },
    /// A new plan is asked from before the old one begins.
    #[error("no new plan from {at} s of path time: the plan begins at {begins:.3} s")]
    PathTime {
        /// The path time that was asked for \[s\].
        at: f64,
        /// That at which the plan begins \[s\].
        begins: f64,
    },
    /// Robots that move cannot leave their path for another one.
    #[error(
        "no motion leads from {at:.3} s of the plan to another path: within the limits there is none, or what is common to both is not clear in a changed world: help: a later path time"
    )]
    HandOver {
        /// The path time \[s\].
        at: f64,
    },
    /// A new plan comes after the robots have passed the instant from which it was asked for.
    #[error(
        "the new plan leaves the old one at {at:.3} s, the robots are at {time:.3} s and follow the old one: help: more time for planning"
    )]
    TooLate {
        /// Where the robots are \[s\].
        time: f64,
        /// The instant \[s\].
        at: f64,
    },
    /// Robots are to be handed over to a plan that was not made from the one that they follow.
    #[error("the new plan is not made from the one that the robots follow")]
    OtherPlan,
    /// A new plan is needed that is still being looked for.
    #[error(
        "there is no new plan yet, the robots follow the old one: help: more time for planning, or less effort"
    )]
    NotYet,
    /// There is no thread that plans.
    #[error("no thread for planning: {0}")]
    Thread(String),
    /// A posture cannot be checked.
    #[error("a posture cannot be checked: {0}")]
    Check(Box<CheckError>),
    /// The clearance of a guard makes fault stops, which leave the path.
    #[error(
        "the guard's clearance brakes off the path, but a guard stops robots on it: help: build it with Stopping::of_guard"
    )]
    GuardBrakes,
    /// Another robot is asked about.
    #[error("no robot is called {name} here: the robots are {known}")]
    NoRobot {
        /// The name.
        name: String,
        /// The robots of the plan, or of the planner.
        known: String,
    },
    /// A clearance that others plan with cannot be made.
    #[error("no clearance for the other robots: {0}")]
    Clearance(Box<ClearanceError>),
}

impl PlanError {
    /// Another robot than the `known` ones is asked about.
    pub(crate) fn no_robot(name: &str, known: impl Iterator<Item = Name>) -> Self {
        let known = known.map(|name| name.to_string()).collect::<Vec<_>>().join(", ");
        PlanError::NoRobot { name: name.to_owned(), known }
    }
}

impl From<CheckError> for PlanError {
    fn from(error: CheckError) -> Self {
        PlanError::Check(Box::new(error))
    }
}

impl From<PlanError> for Fault {
    /// The fault of a program that needs the plan.
    fn from(error: PlanError) -> Self {
        match error {
            // The text of a fault is short: what blocks the robots comes first.
            PlanError::NotFound { nearest, .. } => {
                Fault::thrown(&format!("no path found: {nearest} where the search came nearest"))
            }
            PlanError::Stage { stage, why, .. } => match *why {
                PlanError::NotFound { nearest, .. } => Fault::thrown(&format!(
                    "no path to list {stage}: {nearest} where the search came nearest"
                )),
                why => Fault::thrown(&format!("list {stage}: {why}")),
            },
            other => Fault::thrown(&other.to_string()),
        }
    }
}
