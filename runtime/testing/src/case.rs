//! One case: a fault, and the step in which it begins.

use core::fmt;

use mrroc_core::fault::{Name, ProcessId};

/// A direction of a link between two processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The process that sends.
    pub from: ProcessId,
    /// The process that receives.
    pub to: ProcessId,
}

/// What a faulty link does to messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkFault {
    /// Messages do not arrive.
    Drop,
    /// Messages arrive twice.
    Duplicate,
    /// Each message arrives after the one that follows it, or a step late if none follows.
    Reorder,
    /// Messages arrive so many steps late.
    Delay(u32),
    /// One to three bits of each message are inverted.
    Corrupt,
    /// Each message is followed by one that was sent long before, sometimes under the seal of an earlier attempt to
    /// start the cell.
    Replay,
    /// One to three bits of each message are inverted, with a correct checksum, as by a sender that computes wrongly.
    /// The drives' limits must still hold; where the program ends is not checked.
    Forge,
    /// Messages are late, and lost, as on this wire.
    Wire(Wire),
}

/// A wire of a network: what it does to each message by itself, so that later ones overtake earlier ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// The shortest and the longest time that a message takes \[us\].
    pub takes_us: [u32; 2],
    /// How many of a thousand messages are lost.
    pub lost_per_mille: u32,
}

/// What the operator does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// Suspends the cell and resumes it so many steps later.
    SuspendAndResume(u32),
    /// Aborts the instruction.
    Abort,
    /// Stops the cell permanently.
    Stop,
    /// Suspends, aborts and resumes, all in one step.
    Everything,
}

/// The fault that is injected into a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Injected {
    /// The process ends at once and sends nothing more.
    Kill(ProcessId),
    /// The process does nothing for so many steps, then goes on as before.
    Stall(ProcessId, u32),
    /// The link does this to the messages that are sent in so many steps.
    Link(Channel, LinkFault, u32),
    /// The ECP of this robot, or every one, is at the other end of this wire, seen from the MP, for the messages that are sent in
    /// so many steps.
    Apart(Option<Name>, Wire, u32),
    /// The operator presses a button.
    Press(Press),
    /// The cell is built with a fault of this name.
    Own(&'static str),
}

/// A fault and the step in which it begins. The same case has the same effect on the same cell, to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The fault.
    pub injected: Injected,
    /// The step in which the fault begins.
    pub at: u64,
    /// The seed, which decides which bits are inverted, and at which of its messages in the step a killed process ends.
    pub seed: u64,
}

impl Case {
    /// The first step in which the fault is over.
    pub(super) const fn end(&self) -> u64 {
        let steps = match self.injected {
            Injected::Kill(_) | Injected::Own(_) => return u64::MAX,
            Injected::Stall(_, steps) | Injected::Link(_, _, steps) | Injected::Apart(_, _, steps) => steps,
            Injected::Press(_) => 1,
        };
        self.at.saturating_add(steps as u64)
    }

    /// Whether the fault is present in a step.
    pub(super) const fn is_at_work(&self, step: u64) -> bool {
        self.at <= step && step < self.end()
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} → {}", self.from, self.to)
    }
}

impl fmt::Display for Wire {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.takes_us.map(|us| f64::from(us) * 1e-3);
        write!(f, "{least} to {most} ms, {} % lost", f64::from(self.lost_per_mille) * 0.1)
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
            LinkFault::Wire(wire) => wire.fmt(f),
        }
    }
}

impl fmt::Display for Injected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Injected::Kill(process) => write!(f, "kill {process}"),
            Injected::Stall(process, steps) => write!(f, "stall {process} for {steps} steps"),
            Injected::Link(channel, fault, steps) => write!(f, "{fault}, {steps} steps of {channel}"),
            Injected::Apart(whom, wire, steps) => {
                match *steps {
                    u32::MAX => f.write_str("apart")?,
                    steps => write!(f, "apart for {steps} steps")?,
                }
                whom.as_ref().map_or(Ok(()), |whom| write!(f, ", {}", whom.as_str()))?;
                write!(f, ": {wire}")
            }
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
