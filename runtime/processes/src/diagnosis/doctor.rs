//! `doctor`: what this machine can do for a cell of processes, and what to change.
//!
//! In: the limits of the machine, and wake-ups measured on it. Out: a text of one line for each, with what to change.

mod network;

use std::fmt::Write;
use std::fs;
use std::process::Command;
use std::time::Duration;

use rustix::mm::{MlockAllFlags, mlockall, munlockall};
use rustix::system::uname;
use rustix::thread::{ClockId, clock_nanosleep_absolute, sched_getaffinity};
use rustix::time::Timespec;

use crate::link::monotonic;
use crate::machine::capacity::{SHARED_MEMORY, free_shared_memory};
use crate::machine::scheduling::set_priority;
use crate::session::base;

/// For how long wake-ups are measured, half of it at each priority.
const MEASURED: Duration = Duration::from_secs(10);

/// The period of the wake-ups \[ns\].
const PERIOD: u64 = 1_000_000;

/// The priority that is tried.
const PRIORITY: u8 = 50;

/// Shared memory that a cell of eight processes takes, with capacity to spare \[bytes\].
const ENOUGH: u64 = 64 << 20;

/// Examines the machine: one line for each thing found, and what to change.
pub(crate) fn examine() -> String {
    let mut found = String::new();
    let mut changes: Vec<String> = Vec::new();
    let mut line = |what: &str, is: String| {
        // Writing to a text does not fail.
        let _ = writeln!(found, "{what:<16}{is}");
    };
    let kernel = uname();
    let preempts = fs::read_to_string("/sys/kernel/realtime").is_ok_and(|text| text.trim() == "1");
    let kind = if preempts { "PREEMPT_RT" } else { "not PREEMPT_RT" };
    line("kernel", format!("{}, {kind}", kernel.release().to_string_lossy()));
    if !preempts {
        changes.push(
            "a kernel with PREEMPT_RT bounds the lateness of wake-ups; without it there are late steps"
                .into(),
        );
    }
    let cores = sched_getaffinity(None).map_or(0, |set| set.count());
    line("cores", cores.to_string());
    if cores < 2 {
        changes.push("with one core everything else on the machine takes time from the steps".into());
    }
    match base() {
        Ok(folder) => line("sessions", folder.display().to_string()),
        Err(error) => line("sessions", format!("none possible: {error}")),
    }
    let free = free_shared_memory().unwrap_or(0);
    line("shared memory", format!("{} MB free in {SHARED_MEMORY}", free >> 20));
    if free < ENOUGH {
        changes.push("mount /dev/shm with at least 64 MB; in a container: --shm-size=64m".into());
    }
    // Locks the present memory only, and unlocks it at once: memory that is taken later is not locked.
    let locks = mlockall(MlockAllFlags::CURRENT).and_then(|()| munlockall()).is_ok();
    line("locked memory", permitted(locks));
    let usual = wake_ups(None);
    line("wake-ups", usual.unwrap_or_else(|| "not measured".to_owned()));
    let first = wake_ups(Some(PRIORITY));
    let has_priority = first.is_some();
    line("at priority 50", first.unwrap_or_else(|| permitted(false)));
    if let Some(theirs) = cyclictest() {
        line("cyclictest", theirs);
    }
    if !(locks && has_priority) {
        changes.push(
            "allow priorities and locked memory, as root: setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM".into(),
        );
    }
    for interface in network::interfaces() {
        line(&interface.heading(), interface.describe());
        changes.extend(interface.change());
    }
    for change in changes {
        let _ = writeln!(found, " help: {change}");
    }
    found
}

fn permitted(is: bool) -> String {
    if is { "permitted" } else { "not permitted" }.to_owned()
}

/// How late a thread of this priority wakes when it sleeps until each millisecond; `None` when it is not allowed the
/// priority.
fn wake_ups(priority: Option<u8>) -> Option<String> {
    let measure = move || {
        if priority.is_some_and(|priority| !set_priority(priority)) {
            return None;
        }
        let count = MEASURED.as_nanos() as u64 / 2 / PERIOD;
        let begin = monotonic();
        let late = (1..=count).map(|i| {
            let due = begin + i * PERIOD;
            let until = Timespec {
                tv_sec: (due / 1_000_000_000).cast_signed(),
                tv_nsec: (due % 1_000_000_000).cast_signed(),
            };
            let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
            monotonic().saturating_sub(due)
        });
        Some(summary(late.collect()))
    };
    // A thread of its own, so that the priority ends with the thread.
    std::thread::Builder::new().spawn(measure).ok()?.join().ok().flatten()
}

/// `late by 60 us (half), 120 us (99 %), 900 us (worst of 5000)`.
fn summary(mut late: Vec<u64>) -> String {
    late.sort_unstable();
    let at = |share: f64| {
        late.get((share * (late.len().saturating_sub(1)) as f64) as usize).map_or(0, |ns| ns / 1000)
    };
    format!("late by {} us (half), {} us (99 %), {} us (worst of {})", at(0.5), at(0.99), at(1.0), late.len())
}

/// What `cyclictest` measures; `None` where the program is not installed.
fn cyclictest() -> Option<String> {
    let arguments = ["--quiet", "--priority=50", "--interval=1000", "--loops=5000", "--threads=1"];
    let output = Command::new("cyclictest").args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    Some(text.lines().find(|line| line.starts_with("T:"))?.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_says_the_middle_the_tail_and_the_worst() {
        // 1 to 100 us, shuffled by a step that has no factor in common with 100.
        let late: Vec<_> = (0..100).map(|i| 1000 * (1 + i * 37 % 100)).collect();
        assert_eq!(summary(late), "late by 50 us (half), 99 us (99 %), 100 us (worst of 100)");
        assert_eq!(summary(Vec::new()), "late by 0 us (half), 0 us (99 %), 0 us (worst of 0)");
    }
}
