//! One case: a fault, and the step in which it begins.

use core::fmt;

use mrroc_core::fault::ProcessId;

/// A direction of a link between two processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Who sends.
    pub from: ProcessId,
    /// Who receives.
    pub to: ProcessId,
}

/// What a link does to messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkFault {
    /// They do not arrive.
    Drop,
    /// They arrive twice.
    Duplicate,
    /// Each arrives after the one that follows it, or a step late where none follows.
    Reorder,
    /// They arrive so many steps late.
    Delay(u32),
    /// One to three of their bits are the wrong way round.
    Corrupt,
    /// Each is followed by one that was sent long before, now and then under the seal of an earlier attempt to start the
    /// cell.
    Replay,
    /// One to three of their bits are the wrong way round, under a right checksum: a sender that is out of its mind. The
    /// drives' limits hold all the same; where the program ends is not asked.
    Forge,
}

/// What the operator does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// Suspends the cell and resumes it so many steps later.
    SuspendAndResume(u32),
    /// Aborts the instruction.
    Abort,
    /// Stops the cell for good.
    Stop,
    /// Suspends, aborts and resumes, all in one step.
    Everything,
}

/// What is done to a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Injected {
    /// The process ends at once and says nothing more.
    Kill(ProcessId),
    /// The process stands still for so many steps, then goes on as if nothing had been.
    Stall(ProcessId, u32),
    /// The link does this to what is sent in so many steps.
    Link(Channel, LinkFault, u32),
    /// The operator presses a button.
    Press(Press),
    /// The cell itself has a fault of this name.
    Own(&'static str),
}

/// A fault in a step. The same case does the same to the same cell, to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// What is done.
    pub injected: Injected,
    /// The step in which it is done first.
    pub at: u64,
    /// What decides which bits are turned round, and at which of its messages in the step a killed process ends.
    pub seed: u64,
}

impl Case {
    /// The first step in which it is no longer done.
    pub(super) const fn end(&self) -> u64 {
        let steps = match self.injected {
            Injected::Kill(_) | Injected::Own(_) => return u64::MAX,
            Injected::Stall(_, steps) | Injected::Link(_, _, steps) => steps,
            Injected::Press(_) => 1,
        };
        self.at.saturating_add(steps as u64)
    }

    /// Whether it is done in a step.
    pub(super) const fn is_at_work(&self, step: u64) -> bool {
        self.at <= step && step < self.end()
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} → {}", self.from, self.to)
    }
}

impl fmt::Display for LinkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LinkFault::Drop => f.write_str("drop"),
            LinkFault::Duplicate => f.write_str("duplicate"),
            LinkFault::Reorder => f.write_str("reorder"),
            LinkFault::Delay(steps) => write!(f, "delay by {steps}"),
            LinkFault::Corrupt => f.write_str("corrupt"),
            LinkFault::Replay => f.write_str("replay"),
            LinkFault::Forge => f.write_str("forge"),
        }
    }
}

impl fmt::Display for Injected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Injected::Kill(process) => write!(f, "kill {process}"),
            Injected::Stall(process, steps) => write!(f, "stall {process} for {steps} steps"),
            Injected::Link(channel, fault, steps) => write!(f, "{fault}, {steps} steps of {channel}"),
            Injected::Press(Press::SuspendAndResume(steps)) => {
                write!(f, "suspend, resume after {steps} steps")
            }
            Injected::Press(Press::Abort) => f.write_str("abort"),
            Injected::Press(Press::Stop) => f.write_str("stop"),
            Injected::Own(name) => f.write_str(name),
            Injected::Press(Press::Everything) => f.write_str("suspend, abort and resume"),
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in step {}, seed {}", self.injected, self.at, self.seed)
    }
}
