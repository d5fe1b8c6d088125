//! Where on a plan robots are.
//!
//! In: the positions and velocities that are demanded of all robots. Out: the place on the path that they are at, and where they are some path
//! time later.
//!
//! The place is found from the last one by Newton's method, as far as the robots can have got meanwhile. Where the path turns back on
//! itself, the velocity says on which side they are.

use core::ops::Range;

use mrroc::robot::RobotView;
use mrroc_robots::clearance::{Joints, KnownPath, Stretch};

use crate::error::PlanError;
use crate::limits::Limits;
use crate::plan::Plan;

/// How far a demand may be from the plan [rad or m]: what computing the same position twice may cost.
const SAME: f64 = 1e-7;
/// Steps of Newton's method: where the path is a line one is enough.
const NEWTON: usize = 8;
/// At how many instants speeds of a plan are looked at.
const INSTANTS: usize = 500;

/// How long before an instant that is told the demands may be that a guard sees first \[s\].
const EARLIER: f64 = 0.02;

/// A place of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// The parameter of its path.
    pub(crate) u: f64,
    /// The path time \[s\]: the latest at which the robots are there.
    pub(crate) time: f64,
}

/// A plan that robots follow, as far as they have got.
pub(crate) struct Followed {
    plan: Plan,
    /// Robot by robot, of those of a clearance, its joints in the plan, and its place among the states that were seen last.
    robots: Vec<(mrroc::fault::Name, Range<usize>)>,
    last: Place,
    /// How many reaction times have passed since then, at most.
    missed: f64,
    /// The largest speed by the limit of acceleration, and limit of acceleration by that of jerk, of all joints \[s\].
    slowest: f64,
    jerkiest: f64,
    /// The largest speed of the parameter \[1/s\], and the times between which its acceleration has no break \[s\].
    fastest: f64,
    breaks: Vec<f64>,
}

impl Followed {
    /// The plan for robots of these names and numbers of joints.
    pub(crate) fn new<'a>(
        plan: &Plan,
        robots: impl Iterator<Item = (&'a str, usize)>,
    ) -> Result<Self, PlanError> {
        let limits = &plan.motion.limits;
        let robots = robots.map(|(name, actual)| {
            let place = plan.place_of(name)?;
            let joints = limits.robots[place].clone();
            if joints.len() == actual {
                Ok((plan.robots[place], joints))
            } else {
                Err(PlanError::Joints { expected: joints.len(), actual })
            }
        });
        let robots = robots.collect::<Result<Vec<_>, _>>()?;
        let mut slowest = 0.0_f64;
        let breaks = plan.motion.speed.breaks();
        let fastest = plan.motion.speed.most_between(&breaks, plan.motion.speed.begins, plan.duration());
        let begins = plan.motion.speed.begins;
        let step = (plan.duration() - begins) / INSTANTS as f64;
        for k in 0..=INSTANTS {
            let at = plan.motion.speed.at(begins + k as f64 * step);
            let first = plan.motion.path.at(at.s).first;
            // Between two instants a speed changes by no more than the limit of acceleration allows.
            let speeds = first.iter().zip(&limits.acceleration).map(|(first, a)| (first * at.v).abs() / a);
            slowest = slowest.max(speeds.fold(0.0, f64::max) + 0.5 * step);
        }
        let jerks = limits.jerk.iter().zip(&limits.acceleration);
        let jerkiest = jerks.filter_map(|(jerk, a)| jerk.map(|jerk| a / jerk)).fold(0.0, f64::max);
        let plan = plan.clone();
        Ok(Followed { plan, robots, last: Place::default(), missed: 0.0, slowest, jerkiest, fastest, breaks })
    }

    /// Its robots are at a path time \[s\], or were so shortly before; returns the parameter at which they are at least.
    pub(crate) fn put_at(&mut self, time: f64, reaction: f64) -> f64 {
        let speed = &self.plan.motion.speed;
        let time = (time - EARLIER).max(speed.begins);
        self.last = Place { u: speed.at(time).s, time };
        self.missed = EARLIER / reaction;
        self.last.u
    }

    /// The parameter at which its path ends.
    pub(crate) fn end(&self) -> f64 {
        self.plan.motion.path.length()
    }

    pub(crate) const fn slowest(&self) -> f64 {
        self.slowest
    }

    pub(crate) const fn jerkiest(&self) -> f64 {
        self.jerkiest
    }

    /// The limits of the joints of its plan.
    pub(crate) fn limits(&self) -> &Limits {
        &self.plan.motion.limits
    }

    /// The reaction time for which the plan's fault stops are proven \[s\].
    pub(crate) fn reaction(&self) -> f64 {
        self.plan.motion.reaction
    }

    /// The joints of each robot in the plan.
    pub(crate) fn joints(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.robots.iter().map(|(_, joints)| joints.clone())
    }

    /// The largest speed of the parameter from one to another, not before the last place, and until the reaction time is over \[1/s\].
    pub(crate) fn fastest_between(&self, from: f64, to: f64) -> f64 {
        let begins = (self.time_of(from, 0.0).max(self.last.time) - 1e-6).max(self.plan.motion.speed.begins);
        let ends = self.time_of(to, begins) + self.reaction();
        self.plan.motion.speed.most_between(&self.breaks, begins, ends)
    }

    /// For each joint of each robot, by their numbers, the least and the largest derivative by the parameter between two.
    pub(crate) fn rates(&self, from: f64, to: f64, mut visit: impl FnMut(usize, usize, [f64; 2])) {
        self.plan.motion.path.rates(from, to, |joint, rates| {
            let mut own = self.robots.iter().enumerate();
            if let Some((robot, (_, joints))) = own.find(|(_, (_, joints))| joints.contains(&joint)) {
                visit(robot, joint - joints.start, rates);
            }
        });
    }

    /// Takes what is demanded of its robots out of the states of all; `None` where one is missing.
    pub(crate) fn see(
        &self,
        states: &[RobotView],
        demanded: &mut [Joints],
        velocity: &mut [Joints],
    ) -> Option<()> {
        for ((name, _), (q, v)) in self.robots.iter().zip(demanded.iter_mut().zip(velocity)) {
            let state = states.iter().find(|state| state.name == *name)?;
            (*q, *v) = (state.demanded.joints, state.demanded.velocity);
        }
        Some(())
    }

    /// Where the robots are on the plan; `None` where they are not on it, not behind the last place, or farther than they get in the reaction time
    /// \[s\], in which a guard looks at least once.
    pub(crate) fn locate(
        &mut self,
        demanded: &[Joints],
        velocity: &[Joints],
        reaction: f64,
    ) -> Option<Place> {
        let passed = reaction * (self.missed + 1.0);
        let from = self.last.u;
        let to = (from + self.fastest * passed).min(self.end());
        let found = [0.0, 0.5, 1.0].into_iter().find_map(|share| {
            let u = self.newton(demanded, from + share * (to - from), [from, to])?;
            // On a path that turns back it is there twice: on the way there and on the way back.
            // Where they rest in a corner they have come from before it.
            let along = |u: f64| -> f64 {
                self.all(velocity).map(|(joint, v)| v * self.plan.motion.path.first_at(u, joint)).sum()
            };
            (along(u) >= -SAME || along(u.next_down()) >= -SAME).then_some(u)
        });
        match found {
            Some(u) => {
                self.last = Place { u, time: self.time_of(u, self.last.time) };
                self.missed = 0.0;
                Some(self.last)
            }
            None => {
                self.missed += 1.0;
                None
            }
        }
    }

    /// The values of all robots, joint by joint of the plan.
    fn all<'a>(&'a self, values: &'a [Joints]) -> impl Iterator<Item = (usize, f64)> + 'a {
        let of_robot = |((_, joints), values): (&(_, Range<usize>), &'a Joints)| {
            joints.clone().zip(values.iter().copied())
        };
        self.robots.iter().zip(values).flat_map(of_robot)
    }

    fn newton(&self, demanded: &[Joints], start: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let motion = &self.plan.motion;
        let mut u = start;
        for _ in 0..NEWTON {
            let (mut along, mut squared) = (0.0, 0.0);
            for (joint, q) in self.all(demanded) {
                let first = motion.path.first_at(u, joint);
                along += first * (q - motion.place(u, joint));
                squared += first * first;
            }
            let next = if squared > 0.0 { (u + along / squared).clamp(from, to) } else { u };
            let is_there = (next - u).abs() <= 1e-12;
            u = next;
            if is_there {
                break;
            }
        }
        self.all(demanded).all(|(joint, q)| (q - motion.place(u, joint)).abs() <= SAME).then_some(u)
    }

    /// The latest path time, not before `from`, at which the parameter is no more than `u`.
    fn time_of(&self, u: f64, from: f64) -> f64 {
        let speed = &self.plan.motion.speed;
        let (mut low, mut high) = (from, self.plan.duration());
        if speed.at(high).s <= u {
            return high;
        }
        // To a thousandth of a microsecond.
        while high - low > 1e-9 {
            let middle = 0.5 * (low + high);
            if speed.at(middle).s <= u { low = middle } else { high = middle }
        }
        high
    }

    /// Where the robots are a path time \[s\] later.
    pub(crate) fn after(&self, place: Place, time: f64) -> Place {
        let time = place.time + time;
        if time >= self.plan.duration() {
            return Place { u: self.end(), time: self.plan.duration() };
        }
        Place { u: self.plan.motion.speed.at(time).s, time }
    }
}

impl KnownPath for Followed {
    fn stretch(&self, from: f64, to: f64, robots: &mut [Stretch]) -> f64 {
        let motion = &self.plan.motion;
        motion.path.stretch(from, to, |joint, middle, half| {
            let mut own = self.robots.iter().zip(robots.iter_mut());
            if let Some(((_, joints), stretch)) = own.find(|((_, joints), _)| joints.contains(&joint)) {
                stretch.middle[joint - joints.start] = middle + motion.offset[joint];
                stretch.half[joint - joints.start] = half + SAME;
            }
        })
    }
}
