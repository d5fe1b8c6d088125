//! Results of a clearance check, and errors in what a clearance is built from.

use std::sync::Arc;

use mrroc::cell::CellError;
use mrroc::fault::{BadName, Fault, Name};
use nalgebra::Vector3;

use super::placement::MOTIONS;

/// One side of a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The robot; `None` for an obstacle.
    pub robot: Option<Name>,
    /// The link, tool or body of the robot, or the obstacle.
    pub link: Arc<str>,
    /// The nearest point on it, in the world \[m\].
    pub point: Vector3<f64>,
}

impl core::fmt::Display for Nearest {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [a, b] = &self.sides;
        let distance = 1e3 * self.distance;
        if distance < 0.0 {
            write!(f, "{a} and {b} overlap by {:.1} mm", -distance)
        } else {
            write!(f, "{a} and {b} are {distance:.1} mm apart")
        }
    }
}

impl core::fmt::Display for Side {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.robot {
            Some(robot) => write!(f, "{robot} {}", self.link),
            None => f.write_str(&self.link),
        }
    }
}

/// The two bodies that are nearest to one another, or nearest to their margin.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Distance of their surfaces \[m\]; below 0, how deep they overlap.
    pub distance: f64,
    /// How much nearer they can still come, at most, when the robots are stopped now \[m\], >= 0; 0 when not computed.
    pub travel: f64,
    /// The distance that must be left then, the margin \[m\]; 0 when not computed.
    pub margin: f64,
    /// Both bodies.
    pub sides: [Side; 2],
}

impl Nearest {
    /// The distance that is left beyond the margin when the robots are stopped now \[m\]; below 0, what is missing of it.
    #[must_use]
    pub fn slack(&self) -> f64 {
        self.distance - self.travel - self.margin
    }
}

/// Two bodies would come too close.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "too close: {}, {:.1} mm to stop, {:.1} mm to be left",
    .0, 1e3 * .0.travel, 1e3 * .0.margin
)]
pub struct TooClose(pub Nearest);

/// Why a check did not pass.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CheckError {
    /// Two bodies would come too close.
    #[error(transparent)]
    TooClose(#[from] TooClose),
    /// A robot of the clearance is not among the states.
    #[error("no state of {robot}, which the clearance was built with: pass the states of all robots")]
    Missing {
        /// The robot.
        robot: Name,
    },
    /// There is no pair to check: all are ignored, or were released.
    #[error("the clearance has no two bodies to check: add a robot or an obstacle, or ignore less")]
    NothingToCheck,
    /// Joint positions that give no posture: they are not finite, or the linkages cannot be closed.
    #[error("{robot}: its joint positions are not finite, or its linkages cannot be closed")]
    NoPosture {
        /// The robot.
        robot: Name,
    },
}

impl From<CheckError> for Fault {
    /// The fault that a guard returns: its text has the names of the bodies, their distance and the distance needed.
    fn from(error: CheckError) -> Self {
        Fault::thrown(&error.to_string())
    }
}

/// Why no clearance can be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClearanceError {
    /// A robot's name that is not a valid name.
    #[error(transparent)]
    Name(#[from] BadName),
    /// An obstacle of a cell file.
    #[error(transparent)]
    File(#[from] CellError),
    /// Two robots of one name.
    #[error("a second robot {robot}: give each its own name")]
    SecondRobot {
        /// The name.
        robot: Name,
    },
    /// A number of a body is not finite, or a radius or an edge is not above 0.
    #[error("{body}: ends must be finite, radii and edges above 0, a normal of length 1")]
    BadBody {
        /// The link, tool, body or obstacle.
        body: Arc<str>,
    },
    /// An outline says of more or fewer capsules than it has links what they are fixed to.
    #[error("{robot}: its outline has {links} links, and must have as many rigid capsules or none")]
    BadOutline {
        /// The robot.
        robot: Name,
        /// How many links it has.
        links: usize,
    },
    /// An outline has more motions than stops are bounded with.
    #[error(
        "{robot}: its outline has {motions} motions, and may have {limit}\n help: in an outline of bars a slide counts as two; give the links capsules",
        limit = MOTIONS
    )]
    TooManyMotions {
        /// The robot.
        robot: Name,
        /// How many motions it has.
        motions: usize,
    },
    /// A margin below 0 or not finite.
    #[error("a margin of {margin} m: it must be finite and at least 0")]
    BadMargin {
        /// The margin \[m\].
        margin: f64,
    },
    /// A reaction time below 0, or a rate that never changes.
    #[error("stopping: the reaction time must be at least 0, the step and the change of the rate above 0")]
    BadStopping,
    /// No robot has this name.
    #[error("no robot `{robot}` in this clearance")]
    NoRobot {
        /// The name asked for.
        robot: Arc<str>,
    },
    /// No body has this name.
    #[error("`{owner}` has no `{link}`; it has {known}")]
    NoLink {
        /// The robot, or the cell for obstacles.
        owner: Arc<str>,
        /// The name asked for.
        link: Arc<str>,
        /// The names that there are.
        known: String,
    },
}
