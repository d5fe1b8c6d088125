//! One goal: its robots, and the trajectory that they are to follow; and the file that it is in.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use mrroc::fault::{Fault, Name};
use mrroc::payload::Wire;
use mrroc::program::Recorded;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, TrajectoryPoint};
use rustix::fs::OFlags;

use crate::port::{folder, monotonic};

/// The version of the words of a goal.
const VERSION: u64 = 1;

/// The most words of a goal: what an MP reads and checks between two steps. One for each time, position, velocity and acceleration, and some.
pub const MOST_WORDS: usize = 1 << 14;

/// A trajectory for robots of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// The robots, in the order of their joints in the trajectory.
    pub robots: Vec<Name>,
    /// Where they are to be, and when.
    pub trajectory: JointTrajectory,
    /// How long robots at rest wait before it begins \[s\].
    pub delay: f64,
}

impl Recorded for Goal {
    fn to_words(&self) -> Vec<u64> {
        let trajectory = &self.trajectory;
        let first = &trajectory.points()[0];
        let mut words = vec![VERSION, self.robots.len() as u64];
        for name in &self.robots {
            let mut word = [0; Name::LEN];
            name.put(&mut word);
            words.extend(word);
        }
        words.extend([self.delay, trajectory.tolerance(), trajectory.has_passed()].map(f64::to_bits));
        words.push(trajectory.limits().len() as u64);
        for JointBounds { lower, upper, velocity, acceleration, jerk } in trajectory.limits() {
            words.extend([lower, upper, velocity, acceleration, jerk].map(|limit| limit.to_bits()));
        }
        words.push(trajectory.points().len() as u64);
        words.push(u64::from(!first.velocities.is_empty()) + u64::from(!first.accelerations.is_empty()));
        for point in trajectory.points() {
            words.push(point.time.to_bits());
            let values = [&point.positions, &point.velocities, &point.accelerations].into_iter().flatten();
            words.extend(values.map(|value| value.to_bits()));
        }
        words
    }

    fn from_words(words: &[u64]) -> Option<Self> {
        let mut words = Words(words);
        if words.word()? != VERSION {
            return None;
        }
        let robots = words.count()?;
        let robots: Option<Vec<_>> = (0..robots).map(|_| Name::get(words.some(Name::LEN)?).ok()).collect();
        let [delay, tolerance, passed] = words.numbers(3)?[..] else { return None };
        let joints = words.count()?;
        let limits = |words: &mut Words<'_>| {
            let [lower, upper, velocity, acceleration, jerk] = words.numbers(5)?[..] else { return None };
            Some(JointBounds { lower, upper, velocity, acceleration, jerk })
        };
        let limits: Option<Vec<_>> = (0..joints).map(|_| limits(&mut words)).collect();
        let (points, told) = (words.count()?, words.count()?);
        let point = |words: &mut Words<'_>| {
            let time = f64::from_bits(words.word()?);
            let positions = words.numbers(joints)?;
            let velocities = words.numbers(if told > 0 { joints } else { 0 })?;
            let accelerations = words.numbers(if told > 1 { joints } else { 0 })?;
            Some(TrajectoryPoint { time, positions, velocities, accelerations })
        };
        let points: Option<Vec<_>> = (0..points).map(|_| point(&mut words)).collect();
        if !words.0.is_empty() {
            return None;
        }
        let trajectory = JointTrajectory::new(limits?, points?).ok()?;
        let trajectory = trajectory.starting_within(tolerance).passed(passed);
        Some(Goal { robots: robots?, trajectory, delay })
    }
}

/// Words that are left to be read.
struct Words<'a>(&'a [u64]);

impl<'a> Words<'a> {
    fn some(&mut self, count: usize) -> Option<&'a [u64]> {
        let (some, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(some)
    }

    fn word(&mut self) -> Option<u64> {
        self.some(1).map(|words| words[0])
    }

    /// How many of something follow, each of which takes a word at least.
    fn count(&mut self) -> Option<usize> {
        usize::try_from(self.word()?).ok().filter(|&count| count <= MOST_WORDS)
    }

    fn numbers(&mut self, count: usize) -> Option<Vec<f64>> {
        Some(self.some(count)?.iter().map(|&word| f64::from_bits(word)).collect())
    }
}

/// A goal's file in the folder of ports, which goes when this does.
#[derive(Debug)]
pub struct GoalFile {
    number: u64,
    path: PathBuf,
    /// Locked: where it is not, who wrote it has been killed.
    file: File,
}

fn path(number: u64) -> PathBuf {
    folder().join("goals").join(number.to_string())
}

/// Removes the files of programs that were killed.
fn remove_old(folder: &Path, now: u64) {
    const MINUTE: u64 = 60_000_000;
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let number: Option<u64> = entry.file_name().to_str().and_then(|name| name.parse().ok());
        // Of before the machine was started anew are those of the future. A new one may not be locked yet.
        let is_old = number.is_some_and(|number| now.abs_diff(number) > MINUTE);
        let is_left = || {
            let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
            let file = OpenOptions::new().write(true).custom_flags(flags).open(entry.path());
            file.is_ok_and(|file| file.try_lock().is_ok())
        };
        if is_old && is_left() {
            drop(fs::remove_file(entry.path()));
        }
    }
}

impl GoalFile {
    /// Writes a goal, for the MP of a cell of this user.
    ///
    /// # Errors
    /// It is too long, or the file cannot be written.
    pub fn write(goal: &Goal) -> Result<GoalFile, String> {
        let words = goal.to_words();
        if words.len() > MOST_WORDS {
            return Err(format!(
                "the trajectory has {} numbers, {MOST_WORDS} are possible: send fewer points",
                words.len()
            ));
        }
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let folder = folder().join("goals");
        let failed = |error: io::Error| format!("a goal in {}: {error}", folder.display());
        fs::DirBuilder::new().recursive(true).mode(0o700).create(&folder).map_err(failed)?;
        // Microseconds since the machine has started: greater than all before, and as good as never that of another program.
        let mut number = monotonic() / 1000;
        remove_old(&folder, number);
        let file = loop {
            let created = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path(number));
            match created {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
                created => break created,
            }
        };
        let written = GoalFile { number, path: path(number), file: file.map_err(failed)? };
        written.file.lock().and_then(|()| (&written.file).write_all(&bytes)).map_err(failed)?;
        Ok(written)
    }

    /// The number of the goal.
    #[must_use]
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// The goal of a number.
    ///
    /// # Errors
    /// There is none that can be read.
    pub(super) fn read(number: u64) -> Result<Goal, Fault> {
        let read = || -> io::Result<Vec<u8>> {
            let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
            let file = OpenOptions::new().read(true).custom_flags(flags).open(path(number))?;
            let mut bytes = Vec::new();
            file.take(8 * MOST_WORDS as u64 + 1).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let failed = |why: &str| Fault::thrown(&format!("goal {number}: {why}"));
        let bytes = read().map_err(|error| failed(&error.to_string()))?;
        let (words, rest) = bytes.as_chunks::<8>();
        let words: Vec<u64> = words.iter().map(|word| u64::from_le_bytes(*word)).collect();
        let goal = Goal::from_words(&words).filter(|_| rest.is_empty());
        goal.ok_or_else(|| failed("its file is not what a program of this version writes"))
    }
}

impl Drop for GoalFile {
    fn drop(&mut self) {
        // Another goal has another file.
        drop(fs::remove_file(&self.path));
    }
}
