//! What to do about a fault: a sentence for the person at the terminal.

use crate::model::excess::Excess;
use crate::model::fault::{BY_OPERATOR, Fault, FaultKind, Role, UNSUPERVISED};
use crate::model::robot_stop::Stopped;
use crate::safety::limits::{AT_REDUCED_SPEED, DISAGREEMENT, GOAL, NOT_ATTAINABLE, NOT_FOUND, NOT_REDUNDANT};

impl Fault {
    /// What to do about it, where its kind alone tells.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        use FaultKind as K;
        let demanded = match self.kind() {
            K::DemandOutOfRange if self.says(GOAL) => {
                return Some("give the motion a goal within the joint's limits; nothing has moved for it");
            }
            K::NoInverseKinematics if self.says(GOAL) => {
                return Some(
                    "give the motion a goal that the arm reaches; if it is to end before its goal, as on contact, one that is nearer; \
                     nothing has moved for it",
                );
            }
            K::DemandOutOfRange if self.message().contains("singularity") => return Some(BESIDE_SINGULARITY),
            K::DemandOutOfRange => {
                "keep the motion within the joint's limits: a joint must always be able to stop before them"
            }
            K::DemandedVelocity if self.says(AT_REDUCED_SPEED) => {
                return Some("set a lower speed before the next try: speed 10%");
            }
            K::DemandedVelocity | K::DemandedAcceleration | K::DemandedJerk | K::StartPoseMismatch
                if self.message().contains("singularity") =>
            {
                return Some(BESIDE_SINGULARITY);
            }
            K::DemandedVelocity => {
                "move slower: give the motion more time, or its profile a lower velocity; near a singularity joints turn \
                 fast even if the tool moves slowly"
            }
            K::DemandedAcceleration | K::DemandedJerk if self.is_of_first_demand() => {
                return Some(
                    "begin exactly where the robot is, at `e.demanded()`, which a first step, `#[generator(.., first = begin)]`, is \
                     given as `e: &State<..>`, and without an offset; then speed up slowly",
                );
            }
            K::DemandedAcceleration => {
                "accelerate less: begin and end at rest, give the motion more time, and let no demand jump"
            }
            K::DemandedJerk => {
                "change the acceleration more slowly: use a smoother profile, or give the motion more time"
            }
            K::NoInverseKinematics if self.is_far_away() => return Some(UNITS),
            K::NoInverseKinematics if self.says(DISAGREEMENT) => {
                return Some(
                    "mend the robot's model: `inverse(forward(q), q)` must give `q`; test it for some positions in the limits",
                );
            }
            K::NoInverseKinematics if self.says(NOT_ATTAINABLE) => {
                "demand a pose that the joints can give: the message names the direction in which the robot does not move"
            }
            K::NoInverseKinematics if self.says(NOT_REDUNDANT) => {
                return Some(
                    "leave `with_redundancy` out: the kind of robot has as many joints as a pose asks for",
                );
            }
            K::NoInverseKinematics if self.says(NOT_FOUND) => {
                "demand poses close to each other: the search begins at the joints demanded last and keeps their limits; for \
                 a far goal, demand joints"
            }
            K::NoInverseKinematics if self.excess().is_none() => {
                "demand a pose that the robot can take: go round the singularity, or demand joints there"
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
                    "build the rotation with UnitQuaternion::from_axis_angle, or one of Rpy, Zyz and AngleAxis of mrroc::pose",
                );
            }
            K::PayloadMismatch => {
                return Some(
                    "use the same type of order in the generator of the MP and in the `serve` of the ECP",
                );
            }
            K::FinishedEarly => {
                return Some(
                    "a struct order is tight, and only the MP ends its motion: end it there, or make the order an enum",
                );
            }
            K::FollowingError if self.excess().is_some_and(|excess| !excess.actual.is_finite()) => {
                return Some(
                    "what the driver's `tick` returned is no position: look at how it reads the encoders",
                );
            }
            K::FollowingError => {
                return Some(
                    "the drives do not follow: move slower, or look for what holds the joint; a driver of your own must return \
                     from `tick` what its encoders read after the drives got `demanded`",
                );
            }
            K::StartPoseMismatch if self.is_of_first_demand() && self.is_far_away() => return Some(UNITS),
            K::StartPoseMismatch if self.is_of_first_demand() => BEGIN,
            K::StartPoseMismatch => {
                return Some(
                    "something moved the robot between two motions: look at its drives; a driver of your own must hold \
                     the position demanded last",
                );
            }
            K::Panicked => {
                return Some(
                    "the line that panicked is printed above: let it return `Err(Fault::thrown(\"..\"))` there, in a `Result`; a \
                     reading is None until the sensor has answered: write `is_some_and` or `match`",
                );
            }
            K::NoRegulator => {
                return Some(
                    "choose a parameter set that the driver's `has_regulator` knows; set 0 is always there",
                );
            }
            K::NoOutput => {
                return Some(
                    "name the output in `outputs` of the robot's table in cell.toml, and ask this robot for it: \
                     `arm.output(\"vacuum\")?`",
                );
            }
            K::RobotStopped => return self.stopped().map(Stopped::help),
            K::DriveFault => return Some("look at the drive: clear what tripped it, then start again"),
            K::PeerLost if self.process().is_some_and(|process| process.role == Role::Vsp) => {
                return Some(
                    "the sensor answers later than a step allows: write mode = \"with delay\" in its table of cell.toml, or let \
                     `aggregate` take less time",
                );
            }
            K::PeerLost => {
                return Some(
                    "a process has ended, or gave no answer for longer than 20 ms (for longer than a step, where a Move leads several \
                     robots by poses), because it stood still or computed: let every step return at once, also the first one; plan \
                     what takes longer before the Move, while the robots hold; if nothing computes, the machine gives its processes \
                     too little time: see `doctor`, and write a [realtime] table or a longer step_ms in cell.toml",
                );
            }
            K::SensorStale | K::SensorFailed => {
                return Some(
                    "look at the virtual sensor, or at the program that sends its readings: they must come in time for the motions that read it",
                );
            }
            K::Overrun => {
                return Some(
                    "the machine gives its processes too little time: see `doctor`; write a [realtime] table or a longer step_ms in \
                     cell.toml",
                );
            }
            K::TimedOut => {
                return Some("allow the Wait more steps, or handle the time-out: match on `Fault::kind`");
            }
            K::ProtectiveStop if self.says(BY_OPERATOR) => return None,
            K::ProtectiveStop if self.says(UNSUPERVISED) => {
                return Some(
                    "let the launcher's process go on: kill -CONT and its number; if it was not stopped by a signal, the machine \
                     gives it too little time",
                );
            }
            K::ProtectiveStop => {
                return Some("what the guard allows is in the function passed to `Cell::guard`");
            }
            K::Config
            | K::Program
            | K::Aborted
            | K::InstructionEnded
            | K::StoppedByCell
            | K::CellClosed
            | K::Message => return None,
        };
        Some(if self.is_of_first_demand() { BEGIN } else { demanded })
    }

    /// Whether it is about a place so far away as a number of millimetres or degrees makes it in the place of one of metres or radians.
    fn is_far_away(&self) -> bool {
        self.excess()
            .is_some_and(|Excess { actual, unit, .. }| (unit == "m" || unit == "rad") && actual.abs() > 20.0)
    }

    /// Whether its message begins with this: a stop may have added what became of it, as in `by the operator; left the path`.
    fn says(&self, what: &str) -> bool {
        self.message().starts_with(what)
    }
}

const BESIDE_SINGULARITY: &str = "beside a singularity joints turn fast even if the tool moves slowly: demand joints there, as JointMove does, \
     or keep the tool away from it";

const UNITS: &str = "write metres and radians: what is demanded is as far away as a number of millimetres or degrees would be";

const BEGIN: &str = "begin where the robot is: write a first step, `#[generator(.., first = begin)]`, that takes `e: &State<..>` and \
     starts from `e.demanded()`, in an MP from `e.0.demanded()`, `e.1.demanded()` ..";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_added_to_a_message_changes_no_advice() {
        for (kind, message) in [
            (FaultKind::DemandedVelocity, AT_REDUCED_SPEED),
            (FaultKind::NoInverseKinematics, DISAGREEMENT),
            (FaultKind::NoInverseKinematics, NOT_ATTAINABLE),
            (FaultKind::NoInverseKinematics, NOT_FOUND),
            (FaultKind::NoInverseKinematics, NOT_REDUNDANT),
            (FaultKind::NoInverseKinematics, GOAL),
            (FaultKind::DemandOutOfRange, GOAL),
            (FaultKind::ProtectiveStop, BY_OPERATOR),
            (FaultKind::ProtectiveStop, UNSUPERVISED),
        ] {
            let help = |text: &str| Fault::new(kind).text(text).help();
            assert_eq!(help(&format!("{message}; left the path")), help(message), "{message}");
            // It is advice of its own.
            assert_ne!(help(message), help("something else"), "{message}");
        }
    }
}
