//! Plans as words, so that a program can record them and a replay does not plan again.
//!
//! In: a [`Plan`]. Out: words of 64 bits, of numbers their bits, so nothing is lost; or back. What a path and a speed have is written one
//! behind the other, lists behind their lengths. A leg of a path has two numbers for each joint, a curve six.
//!
//! Words that are of no plan are refused. Whether the plan is clear is not proven again: it is clear in the world that it was planned in.

use core::ops::Range;
use std::sync::Arc;

use mrroc::fault::Name;
use mrroc::payload::Wire;
use mrroc::program::Recorded;
use mrroc::robot::JointKind;
use mrroc_generators::profile::ProfilePoint;

use crate::limits::Limits;
use crate::path::{Path, Piece};
use crate::plan::{Motion, Plan};
use crate::speed::{Knot, Speed};

/// The first word: that this is a plan, in this form.
const PLAN: u64 = u64::from_be_bytes(*b"plan  03");

const REVOLUTE: u64 = 0;
const PRISMATIC: u64 = 1;
const LEG: u64 = 0;
const CURVE: u64 = 1;

impl Recorded for Plan {
    fn to_words(&self) -> Vec<u64> {
        let Plan { robots, motion } = self;
        let Motion { path, speed, limits, offset, ends: [from, to], grid, leaves, reaction, carries } =
            &**motion;
        let mut words = Words(vec![PLAN, robots.len() as u64]);
        for (name, joints) in robots.iter().zip(&limits.robots) {
            words.name(name);
            words.0.push(joints.len() as u64);
        }
        words.limits(limits);
        words.floats(offset);
        words.floats(from);
        words.floats(to);
        words.floats(&[*leaves, *reaction]);
        words.0.push(u64::from(*carries));
        words.path(path);
        words.0.push(grid.len() as u64);
        words.floats(grid);
        words.speed(speed);
        words.0
    }

    fn from_words(words: &[u64]) -> Option<Self> {
        let mut words = Reader(words);
        if words.word()? != PLAN {
            return None;
        }
        let count = words.count()?;
        let (mut robots, mut joints) = (Vec::new(), Vec::<Range<usize>>::new());
        for _ in 0..count {
            robots.push(words.name()?);
            let first = joints.last().map_or(0, |last| last.end);
            joints.push(first..first + words.count()?);
        }
        let n = joints.last()?.end;
        let limits = words.limits(joints, n)?;
        let offset = words.floats(n)?;
        let ends = [words.floats(n)?, words.floats(n)?];
        let [leaves, reaction] = words.array()?;
        let carries = match words.word()? {
            0 => false,
            1 => true,
            _ => return None,
        };
        let path = words.path(n)?;
        let cells = words.count()?;
        let grid = words.floats(cells)?;
        let speed = words.speed()?;
        words.0.is_empty().then(|| {
            let motion =
                Arc::new(Motion { path, speed, limits, offset, ends, grid, leaves, reaction, carries });
            Plan { robots, motion }
        })
    }
}

/// Words being written.
struct Words(Vec<u64>);

impl Words {
    fn float(&mut self, number: f64) {
        self.0.push(number.to_bits());
    }

    /// Numbers whose count is known.
    fn floats(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.float(*number));
    }

    fn name(&mut self, name: &Name) {
        let mut words = [0; Name::LEN];
        name.put(&mut words);
        self.0.extend(words);
    }

    fn limits(&mut self, limits: &Limits) {
        let Limits { robots: _, kinds, lower, upper, velocity, acceleration, jerk } = limits;
        self.0.extend(kinds.iter().map(|kind| match kind {
            JointKind::Revolute => REVOLUTE,
            JointKind::Prismatic => PRISMATIC,
        }));
        for numbers in [lower, upper, velocity, acceleration] {
            self.floats(numbers);
        }
        for jerk in jerk {
            self.0.push(u64::from(jerk.is_some()));
            jerk.iter().for_each(|jerk| self.float(*jerk));
        }
    }

    fn path(&mut self, path: &Path) {
        let Path { knots, pieces } = path;
        self.0.push(pieces.len() as u64);
        self.floats(knots);
        for piece in pieces {
            match piece {
                Piece::Leg { from, along } => {
                    self.0.push(LEG);
                    self.floats(from);
                    self.floats(along);
                }
                Piece::Curve(points) => {
                    self.0.push(CURVE);
                    points.iter().for_each(|points| self.floats(points));
                }
            }
        }
    }

    fn speed(&mut self, speed: &Speed) {
        let Speed { knots, window, stretch, begins } = speed;
        self.floats(&[*window, *stretch, *begins]);
        self.0.push(knots.len() as u64);
        for Knot { time, at: ProfilePoint { s, v, a }, sum } in knots {
            self.floats(&[*time, *s, *v, *a, *sum]);
        }
    }
}

/// Words being read.
struct Reader<'w>(&'w [u64]);

impl Reader<'_> {
    fn word(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// A number of things of which each has at least one word.
    fn count(&mut self) -> Option<usize> {
        let count = usize::try_from(self.word()?).ok()?;
        (count <= self.0.len()).then_some(count)
    }

    fn floats(&mut self, count: usize) -> Option<Vec<f64>> {
        let (first, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(first.iter().map(|word| f64::from_bits(*word)).collect())
    }

    fn array<const N: usize>(&mut self) -> Option<[f64; N]> {
        self.floats(N)?.try_into().ok()
    }

    fn name(&mut self) -> Option<Name> {
        let (first, rest) = self.0.split_at_checked(Name::LEN)?;
        self.0 = rest;
        Name::get(first).ok()
    }

    fn limits(&mut self, robots: Vec<Range<usize>>, n: usize) -> Option<Limits> {
        let kind = |word| match word {
            REVOLUTE => Some(JointKind::Revolute),
            PRISMATIC => Some(JointKind::Prismatic),
            _ => None,
        };
        let kinds = (0..n).map(|_| self.word().and_then(kind)).collect::<Option<_>>()?;
        let (lower, upper) = (self.floats(n)?, self.floats(n)?);
        let (velocity, acceleration) = (self.floats(n)?, self.floats(n)?);
        let jerk = (0..n).map(|_| match self.word()? {
            0 => Some(None),
            1 => self.array().map(|[jerk]| Some(jerk)),
            _ => None,
        });
        let jerk = jerk.collect::<Option<_>>()?;
        Some(Limits { robots, kinds, lower, upper, velocity, acceleration, jerk })
    }

    fn path(&mut self, n: usize) -> Option<Path> {
        // A path has at least one piece.
        let count = self.count().filter(|count| *count > 0)?;
        let knots = self.floats(count + 1).filter(|knots| knots.is_sorted_by(|a, b| a <= b))?;
        let piece = |_| match self.word()? {
            LEG => Some(Piece::Leg { from: self.floats(n)?, along: self.floats(n)? }),
            CURVE => (0..n).map(|_| self.array()).collect::<Option<_>>().map(Piece::Curve),
            _ => None,
        };
        let pieces = (0..count).map(piece).collect::<Option<_>>()?;
        Some(Path { knots, pieces })
    }

    fn speed(&mut self) -> Option<Speed> {
        let [window, stretch, begins] = self.array()?;
        let count = self.count()?;
        let knot = |_| {
            let [time, s, v, a, sum] = self.array()?;
            Some(Knot { time, at: ProfilePoint { s, v, a }, sum })
        };
        Some(Speed { knots: (0..count).map(knot).collect::<Option<_>>()?, window, stretch, begins })
    }
}
