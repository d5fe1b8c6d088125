//! What a servo period did: of a robot whose kind is known, and of a robot of any kind.

use crate::model::driver::Measured;
use crate::model::pose::Pose;
use crate::model::robot::{JointKind, Robot};
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;

/// What a servo period did, for recording and for pictures.
pub struct ServoRecord<R: Robot> {
    /// Time since the cell started, at the period's end \[s\].
    pub time: f64,
    /// Joint positions that the drives got [rad or m].
    pub demanded: R::Joints,
    /// What the encoders read at the period's end.
    pub measured: Measured<R::Joints>,
    /// The tool in force, `X_FE`.
    pub tool: Pose,
}

/// What an observer of servo periods is.
pub type Observer<R> = Box<dyn FnMut(&ServoRecord<R>)>;

/// A robot of any kind at the end of a servo period, as a recorder sees it.
pub struct Observation<'a> {
    /// The robot's name.
    pub robot: &'a str,
    /// Its kind.
    pub kind: &'static str,
    /// Time since the cell started \[s\].
    pub time: f64,
    /// Joint positions that the drives got [rad or m].
    pub demanded: &'a [f64],
    /// Joint positions that the encoders read [rad or m].
    pub measured: &'a [f64],
    /// What kind each joint is.
    pub joints: &'a [JointKind],
    /// The robot on whose flange it is mounted: its frames and its tool then stand in that flange, not in the world.
    pub mounted_on: Option<&'a str>,
    /// Shows a visitor the frames of its links; see [`frames`](Observation::frames).
    pub frames: &'a Frames<'a>,
    /// The pose of its tool at the measured joints, `X_WE`.
    pub tool: Pose,
    /// What the MP's program does; see [`mp`](Observation::mp).
    pub mp: &'a Shown<Activity>,
    /// What the program of its ECP does; see [`ecp`](Observation::ecp).
    pub ecp: &'a Shown<Activity>,
}

/// Shows a visitor the frames of a robot's links.
pub type Frames<'a> = dyn Fn(&mut dyn FnMut(&Pose)) + 'a;

impl Observation<'_> {
    /// Visits the frames of the links at the measured joints, `X_WL`, from the base to the flange, and the tool's, `X_WE`,
    /// last.
    pub fn frames(&self, visit: &mut dyn FnMut(&Pose)) {
        (self.frames)(visit);
        visit(&self.tool);
    }

    /// What the MP's program does, as far as this process knows: where cells run as processes, the plant does.
    #[must_use]
    pub fn mp(&self) -> Activity {
        self.mp.get()
    }

    /// What the program of the robot's ECP does; that of a transparent ECP does nothing.
    #[must_use]
    pub fn ecp(&self) -> Activity {
        self.ecp.get()
    }
}
