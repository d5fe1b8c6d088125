//! Copies of a run: it goes through its program once, and the process is forked where each fault begins.
//!
//! In: cases. Out: in the run itself, what its copies came to; in a copy, the case that it is to go on with. A case so costs
//! the way from its fault to a standstill and not the whole program, of which nothing before the fault is done again.

use std::collections::VecDeque;
use std::io::{self, PipeReader, PipeWriter, Read, Write, pipe};

use super::case::{Case, Injected, LinkFault};
use super::stage::Lasting;
use super::verdict::Verdict;

/// How many steps before its fault a copy is made: messages name steps that are still to come.
const LEAD: u64 = 4;

/// After so many seconds of the machine's time a copy is ended: something in it does not return.
#[cfg(unix)]
const PATIENCE: u32 = 60;

/// The copies of a run, or of a copy where it tells what it came to.
#[derive(Default)]
pub(super) struct Forks {
    /// Cases to come, the next one last.
    cases: Vec<Case>,
    /// The time of a copy; it is watched for so many steps from its fault on.
    lasting: Option<Lasting>,
    at_a_time: usize,
    replay: bool,
    copies: VecDeque<Copy>,
    verdicts: Vec<(Case, Verdict)>,
    tells: Option<PipeWriter>,
}

/// A process that goes on with a case.
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

    /// Whether a case to come sends old messages again.
    pub const fn replay(&self) -> bool {
        self.replay
    }

    /// Makes a copy for each case that begins soon after this step; in a copy, returns its case.
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

    /// In the run itself, what all copies came to; waits for those that go on.
    pub fn verdicts(mut self) -> Vec<(Case, Verdict)> {
        while !self.copies.is_empty() {
            self.hear_of_one();
        }
        self.verdicts
    }

    /// Ends a copy, which came to this.
    pub fn tell(self, verdict: &Verdict) {
        if let Some(mut tells) = self.tells {
            // A run that does not listen any more is gone.
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

/// Copies this process: 0 in the copy, its number here.
#[cfg(unix)]
#[allow(unsafe_code)]
fn copy() -> io::Result<i32> {
    // SAFETY: the copy has this thread alone. It runs a cell, whose processes are coroutines of this thread, takes memory,
    // which the C library makes ready for it in the copy, and ends by `end_copy`; other threads' locks it never asks for.
    let process = unsafe { libc::fork() };
    match process {
        -1 => Err(io::Error::last_os_error()),
        0 => {
            // SAFETY: no memory is handed over.
            unsafe { libc::alarm(PATIENCE) };
            Ok(0)
        }
        process => Ok(process),
    }
}

/// Ends this process without what it would do at its end: that is the run's.
#[cfg(unix)]
#[allow(unsafe_code)]
pub(super) fn end_copy() -> ! {
    // SAFETY: no memory is handed over, and nothing runs after it.
    unsafe { libc::_exit(0) }
}

#[cfg(unix)]
#[allow(unsafe_code)]
fn reap(process: i32) {
    // SAFETY: the process is a child, which nobody else waits for, and no status is asked for.
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
