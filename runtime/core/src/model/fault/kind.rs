//! The causes of faults, and how severe each is.

/// How severe a fault is; the most severe active one decides, the first of equals is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultClass {
    /// Bad input before motion: nothing moved.
    Refused,
    /// Late, lost or stale inside the budget: counted, never returned.
    Tolerated,
    /// A controlled stop on the path, drives hold (stop category 2).
    Suspended,
    /// A controlled stop, latched (stop category 1).
    Stopped,
    /// Power removed by a drive (stop category 0).
    PowerOff,
}

macro_rules! fault_kinds {
    ($($(#[doc = $doc:literal])* $kind:ident = $code:literal: $class:ident, $text:literal;)*) => {
        /// The cause of a fault.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum FaultKind {
            $($(#[doc = $doc])* $kind,)*
        }

        impl FaultKind {
            /// The class that the kind belongs to.
            #[must_use]
            pub const fn class(self) -> FaultClass {
                match self { $(FaultKind::$kind => FaultClass::$class,)* }
            }

            pub(super) const fn text(self) -> &'static str {
                match self { $(FaultKind::$kind => $text,)* }
            }

            pub(super) const fn code(self) -> u64 {
                match self { $(FaultKind::$kind => $code,)* }
            }

            pub(super) const fn from_code(code: u64) -> Option<FaultKind> {
                match code { $($code => Some(FaultKind::$kind),)* _ => None }
            }
        }
    };
}

fault_kinds! {
    /// The cell was put together wrongly.
    Config = 1: Refused, "the cell is not put together as the program needs it";
    /// The program broke a rule of the runtime, or threw a fault of its own.
    Program = 2: Stopped, "fault thrown by the program";
    /// The two halves of a motion disagree about the order's payload.
    PayloadMismatch = 3: Refused, "the MP and the ECP disagree about the order";
    /// The operator aborted the instruction.
    Aborted = 4: Suspended, "aborted by the operator";
    /// The MP ended the instruction that the ECP was still working on. [`Ecp::serve`](crate::program::Ecp::serve) turns it into `Ok`.
    InstructionEnded = 5: Suspended, "the instruction was ended by the MP";
    /// A Wait did not see its condition within its time-out.
    TimedOut = 6: Suspended, "the condition was not met in time";
    /// An ECP finished a tight motion before the MP ended it.
    FinishedEarly = 7: Stopped, "the ECP finished a tight motion before the MP ended it";
    /// The process at the other end is gone.
    PeerLost = 8: Stopped, "the process at the other end is gone";
    /// Another process of the cell stopped with a fault, which is reported there.
    StoppedByCell = 9: Stopped, "the cell was stopped by a fault elsewhere";
    /// A number in a demand is NaN or infinite.
    DemandNotFinite = 10: Stopped, "demand is not finite";
    /// A demanded orientation is no rotation.
    DemandInvalidFrame = 11: Stopped, "demanded frame is no rotation";
    /// A demanded position lies beyond a joint limit, or so near that the joint could not stop before it.
    DemandOutOfRange = 12: Stopped, "demanded position exceeds the limit";
    /// The demanded velocity exceeds the limit.
    DemandedVelocity = 13: Stopped, "demanded velocity exceeds the limit";
    /// The demanded acceleration exceeds the limit.
    DemandedAcceleration = 14: Stopped, "demanded acceleration exceeds the limit";
    /// The demanded jerk exceeds the limit.
    DemandedJerk = 15: Stopped, "demanded jerk exceeds the limit";
    /// At the start of a motion the robot is not where it was demanded to be.
    StartPoseMismatch = 16: Refused, "wrong start";
    /// A demanded pose has no joint positions.
    NoInverseKinematics = 17: Stopped, "no inverse kinematics";
    /// A sensor's reading is older than the program allows.
    SensorStale = 18: Suspended, "the sensor's reading is too old";
    /// A virtual sensor gave no reading.
    SensorFailed = 19: Suspended, "the virtual sensor failed";
    /// The robot does not follow its demands.
    FollowingError = 20: Stopped, "following error exceeds the limit";
    /// A drive tripped.
    DriveFault = 21: PowerOff, "drive fault";
    /// The robot was stopped by its own controller, or by a person beside it.
    RobotStopped = 28: PowerOff, "stopped at the robot";
    /// A step function, a driver or a guard panicked.
    Panicked = 22: Stopped, "panic in the program";
    /// A demand chooses a regulator's parameter set that the drive does not have.
    NoRegulator = 25: Stopped, "the drive has no such regulator";
    /// A demand switches an output that the cell does not name, or tells it what is no number.
    NoOutput = 29: Stopped, "the robot has no such output";
    /// A guard of the cell saw what must not go on: a protective stop on the path.
    ProtectiveStop = 26: Stopped, "protective stop";
    /// A process was late for too many steps.
    Overrun = 27: Stopped, "too many steps were missed";
    /// The cell is closing: the MP's program is over.
    CellClosed = 24: Refused, "the MP's program is over";
    /// A message could not be read.
    Message = 23: Stopped, "a message could not be read";
}

impl FaultKind {
    /// Whether it says how the runtime ended an instruction or the cell: thrown by a program it means nothing.
    pub(super) const fn is_the_runtimes(self) -> bool {
        matches!(
            self,
            FaultKind::Aborted
                | FaultKind::InstructionEnded
                | FaultKind::StoppedByCell
                | FaultKind::CellClosed
        )
    }
}
