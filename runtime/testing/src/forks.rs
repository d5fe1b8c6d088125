//! Copies of a run: the run goes through its program once, and the process is forked where each fault begins.
//!
//! In: cases. Out: in the run itself, the verdicts on its copies; in a copy, the case with which it goes on. So a case
//! costs the time from its fault to a standstill, and the part of the program before the fault is not repeated.

use std::collections::VecDeque;
use std::io::{self, PipeReader, PipeWriter, Read, Write, pipe};

use super::case::{Case, Injected, LinkFault};
use super::verdict::Verdict;

/// How long a trial goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lasting {
    /// How long the robots are watched after the MP's program is over or the MP is gone \[steps\].
    pub afterwards: u64,
    /// After so many steps a trial is given up as endless.
    pub most: u64,
    /// After so many steps a trial that goes on has been watched for long enough.
    pub watched: u64,
}

/// How many steps before its fault a copy is made: earlier, because messages name steps that are still to come.
const LEAD: u64 = 4;

/// After this time of the machine's clock a copy is ended, because something in it does not return \[s\].
#[cfg(unix)]
const TIMEOUT: u32 = 60;

/// In the run: its copies. In a copy: where it reports its verdict.
#[derive(Default)]
pub(super) struct Forks {
    /// The cases that are left, the next one last.
    cases: Vec<Case>,
    /// How long a copy lasts, counted from its fault.
    lasting: Option<Lasting>,
    at_a_time: usize,
    replay: bool,
    copies: VecDeque<Copy>,
    verdicts: Vec<(Case, Verdict)>,
    tells: Option<PipeWriter>,
}

/// A copy of the process, which goes on with a case.
struct Copy {
    case: Case,
    process: i32,
    hears: PipeReader,
}

impl Forks {
    pub fn new(mut cases: Vec<Case>, lasting: Lasting, at_a_time: usize) -> Forks {
        cases.sort_by_key(|case| core::cmp::Reverse(case.at));
        let is_replay = |case: &Case| matches!(case.injected, Injected::Link(_, LinkFault::Replay, _));
        let replay = cases.iter().any(is_replay);
        Forks { cases, lasting: Some(lasting), at_a_time: at_a_time.max(1), replay, ..Forks::default() }
    }

    /// Whether one of the cases that are left sends old messages again.
    pub const fn replay(&self) -> bool {
        self.replay
    }

    /// Makes a copy for each case that begins soon after this step. In a copy, returns its case; in the run, `None`.
    pub fn fork(&mut self, step: u64) -> Option<(Case, Lasting)> {
        let lasting = self.lasting?;
        while let Some(case) = self.cases.pop_if(|case| case.at <= step + LEAD) {
            if self.copies.len() == self.at_a_time {
                self.hear_of_one();
            }
            match pipe().and_then(|(hears, tells)| Ok((hears, tells, copy()?))) {
                Ok((_, tells, 0)) => {
                    *self = Forks { tells: Some(tells), ..Forks::default() };
                    return Some((
                        case,
                        Lasting { watched: case.at.saturating_add(lasting.watched), ..lasting },
                    ));
                }
                Ok((hears, _, process)) => self.copies.push_back(Copy { case, process, hears }),
                Err(error) => self.verdicts.push((case, Verdict::Broken(format!("no copy: {error}")))),
            }
        }
        None
    }

    /// In the run itself: waits for all copies and returns their verdicts.
    pub fn verdicts(mut self) -> Vec<(Case, Verdict)> {
        while !self.copies.is_empty() {
            self.hear_of_one();
        }
        self.verdicts
    }

    /// Reports the verdict of a copy and ends it.
    pub fn tell(self, verdict: &Verdict) {
        if let Some(mut tells) = self.tells {
            // Writing fails only if the run is gone.
            drop(tells.write_all(verdict.to_line().as_bytes()));
        }
        end_copy();
    }

    fn hear_of_one(&mut self) {
        let Some(Copy { case, process, mut hears }) = self.copies.pop_front() else { return };
        let mut line = String::new();
        let heard = hears.read_to_string(&mut line);
        reap(process);
        let verdict = heard.ok().and_then(|_| Verdict::from_line(&line));
        let silent = || Verdict::Broken("its run panicked, or did not return".to_owned());
        self.verdicts.push((case, verdict.unwrap_or_else(silent)));
    }
}

/// Copies this process; returns 0 in the copy, and the copy's process number in the run.
#[cfg(unix)]
#[allow(unsafe_code)]
fn copy() -> io::Result<i32> {
    // SAFETY: the copy has only this thread. It runs a cell, whose processes are coroutines of this thread; it
    // allocates memory, for which the C library prepares the copy; it ends by `end_copy`; and it never takes locks of
    // other threads.
    let process = unsafe { libc::fork() };
    match process {
        -1 => Err(io::Error::last_os_error()),
        0 => {
            // SAFETY: no memory is passed.
            unsafe { libc::alarm(TIMEOUT) };
            Ok(0)
        }
        process => Ok(process),
    }
}

/// Ends this process at once, without the work at a process's usual end, which is left to the run.
#[cfg(unix)]
#[allow(unsafe_code)]
pub(super) fn end_copy() -> ! {
    // SAFETY: no memory is passed, and nothing runs after the call.
    unsafe { libc::_exit(0) }
}

#[cfg(unix)]
#[allow(unsafe_code)]
fn reap(process: i32) {
    // SAFETY: the process is a child for which nothing else waits, and no status is asked for.
    unsafe { libc::waitpid(process, core::ptr::null_mut(), 0) };
}

#[cfg(not(unix))]
fn copy() -> io::Result<i32> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(not(unix))]
pub(super) fn end_copy() -> ! {
    std::process::exit(0)
}

#[cfg(not(unix))]
fn reap(_: i32) {}
