//! What interpolation in the task space adds to the joint spline, servo period by servo period.
//!
//! In: the spline's joints, and the joints of the pose between the demands. Out: the joints for the drives,
//! `q + s(share) (q_pose - q)`. The difference is of second order in the displacement of a step, so the sum keeps what the spline
//! keeps but for little. Where demands are not of poses, or a pose between them has no joints, the share goes to 0 within
//! [`FADING`], not at once: no jump.

use crate::model::joints::JointVector;

/// Time within which the difference comes in or goes while the robot moves \[s\].
const FADING: f64 = 0.05;

/// The difference, and how much of it counts.
pub(crate) struct TaskSpace<J> {
    difference: J,
    share: f64,
    /// Whether the demands are of poses.
    in_poses: bool,
    /// Whether a pose was met that has no joints: from then on the interpolation is in joints.
    failed: bool,
}

impl<J: JointVector> TaskSpace<J> {
    pub fn new() -> Self {
        TaskSpace { difference: J::zeros(), share: 0.0, in_poses: false, failed: false }
    }

    /// A demand of a pose or of joints was accepted. Where nothing moves yet there is no difference that could jump.
    pub fn accept(&mut self, of_pose: bool, stands: bool) {
        self.in_poses = of_pose;
        if stands {
            self.share = self.wanted();
        }
    }

    fn wanted(&self) -> f64 {
        if self.in_poses && !self.failed { 1.0 } else { 0.0 }
    }

    /// Another servo period of `duration` \[s\]; whether the difference counts and is to be computed.
    pub fn advance(&mut self, duration: f64) -> bool {
        let change = duration / FADING;
        self.share += (self.wanted() - self.share).clamp(-change, change);
        self.share > 0.0 && !self.failed
    }

    /// The pose between the demands has these joints beside those of the spline.
    pub fn set_difference(&mut self, difference: J) {
        self.difference = difference;
    }

    /// It has none: what there was fades.
    pub fn fail(&mut self) {
        self.failed = true;
    }

    /// What is added to the spline's joints.
    pub fn correction(&self) -> J {
        self.difference * (self.share * self.share * (3.0 - 2.0 * self.share))
    }
}
