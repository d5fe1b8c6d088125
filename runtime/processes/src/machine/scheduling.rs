//! Asks the machine for the priority, the core and the locked memory that a process of a cell needs in real time.
//!
//! In: what the cell asks for, and which process this is. Out: what the machine did not grant.

use core::fmt;

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use mrroc_core::cell::Realtime;
use mrroc_core::fault::ProcessId;

/// What a machine did not grant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lacks(u64);

impl Lacks {
    const PRIORITY: u64 = 1;
    const MEMORY: u64 = 2;
    const CORE: u64 = 4;

    pub(crate) const fn to_word(self) -> u64 {
        self.0
    }

    pub(crate) const fn from_word(word: u64) -> Lacks {
        Lacks(word)
    }

    pub(crate) const fn and(self, other: Lacks) -> Lacks {
        Lacks(self.0 | other.0)
    }

    pub(crate) const fn is_nothing(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Lacks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = [
            (Lacks::PRIORITY, "its priority under SCHED_FIFO"),
            (Lacks::MEMORY, "its memory locked in place"),
            (Lacks::CORE, "its core"),
        ];
        let lacking: Vec<_> =
            all.iter().filter(|(bit, _)| self.0 & bit != 0).map(|(_, what)| *what).collect();
        f.write_str(&lacking.join(", "))
    }
}

/// Asks the machine for what `realtime` gives the process `me` of a cell with these ECPs; returns what was not granted.
pub(crate) fn ask(realtime: &Realtime, me: ProcessId, ecps: &[ProcessId]) -> Lacks {
    let mut lacks = Lacks::default();
    if !set_priority(realtime.priority) {
        lacks.0 |= Lacks::PRIORITY;
    }
    if realtime.lock_memory && mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).is_err() {
        lacks.0 |= Lacks::MEMORY;
    }
    let usable =
        sched_getaffinity(None).map(|set| (0..CpuSet::MAX_CPU).filter(|&core| set.is_set(core)).collect());
    let usable: Vec<usize> = usable.unwrap_or_default();
    if let Some(core) = realtime.core(me, ecps, &usable) {
        let mut set = CpuSet::new();
        if core < CpuSet::MAX_CPU {
            set.set(core);
        }
        if sched_setaffinity(None, &set).is_err() {
            lacks.0 |= Lacks::CORE;
        }
    }
    lacks
}

/// Returns this thread to ordinary priority: the work that is left has no deadline.
pub(crate) fn give_back_priority() {
    // SAFETY: a `sched_param` of zero bytes is valid, because it holds numbers only.
    #[allow(unsafe_code)]
    let parameters: libc::sched_param = unsafe { core::mem::zeroed() };
    // SAFETY: 0 is the calling thread, and the parameters are read before the call returns.
    #[allow(unsafe_code)]
    let _ = unsafe { libc::sched_setscheduler(0, libc::SCHED_OTHER, &raw const parameters) };
}

/// Sets SCHED_FIFO with a priority from 1 to 99; returns whether that is permitted.
pub(crate) fn set_priority(priority: u8) -> bool {
    // SAFETY: a `sched_param` of zero bytes is valid, because it holds numbers only.
    #[allow(unsafe_code)]
    let mut parameters: libc::sched_param = unsafe { core::mem::zeroed() };
    parameters.sched_priority = libc::c_int::from(priority);
    // SAFETY: 0 is the calling thread, and the parameters are read before the call returns.
    #[allow(unsafe_code)]
    let outcome = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) };
    outcome == 0
}
