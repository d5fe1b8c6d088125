//! What to do about a fault: a sentence for the person at the terminal.

use crate::fault::{Fault, FaultKind};

impl Fault {
    /// What to do about it, where its kind alone tells.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        use FaultKind as K;
        let demanded = match self.kind() {
            K::DemandOutOfRange => {
                "keep the motion within the joint's limits: a joint must always be able to stop before them"
            }
            K::DemandedVelocity => {
                "move slower: give the motion more time, or its profile a lower velocity; near a singularity joints turn \
                 fast for a slow tool"
            }
            K::DemandedAcceleration => {
                "accelerate less: begin and end at rest, give the motion more time, and let no demand jump"
            }
            K::DemandedJerk => {
                "change the acceleration more slowly: use a smoother profile, or give the motion more time"
            }
            K::NoInverseKinematics => {
                "demand a pose that the arm reaches: the picture shows how far it got, the message how far it reaches"
            }
            K::DemandNotFinite => {
                return Some(
                    "the step function returned NaN or infinity: look for a division by zero or a root of less than 0",
                );
            }
            K::DemandInvalidFrame => {
                return Some(
                    "build the rotation with UnitQuaternion::from_axis_angle, or mrroc::Zyz and mrroc::AngleAxis",
                );
            }
            K::PayloadMismatch => {
                return Some(
                    "let the generator that the MP moves by and the `obey` of the ECP name the same type of order",
                );
            }
            K::FinishedEarly => {
                return Some(
                    "a struct order is tight, and only the MP ends its motion: end it there, or make the order an enum",
                );
            }
            K::FollowingError => {
                return Some("the drives do not follow: move slower, or look for what holds the joint");
            }
            K::SensorStale | K::SensorFailed => {
                return Some(
                    "look at the virtual sensor: `aggregate` must answer, and in time for the motions that read it",
                );
            }
            K::TimedOut => {
                return Some("allow the Wait more steps, or handle the time-out: match on `Fault::kind`");
            }
            K::Config
            | K::Program
            | K::Aborted
            | K::InstructionEnded
            | K::PeerLost
            | K::StoppedByCell
            | K::StartPoseMismatch
            | K::DriveFault
            | K::GeneratorPanicked
            | K::CellClosed
            | K::Message => return None,
        };
        Some(if self.is_of_first_demand() {
            "begin where the robot is: write a first step, `#[generator(.., first = begin)]`, that takes `e: &State<..>` and \
             starts from `e.demanded()`"
        } else {
            demanded
        })
    }
}
