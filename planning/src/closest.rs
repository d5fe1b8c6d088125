//! How near a plan comes to what is around: in its motion, and in each kind of stop that its proof covers.
//!
//! In: a plan, and a clearance of its robots. Out: a [`ClosestTable`], looked at in double precision at samples of the motion and of
//! stops from each of them. A stop begins in the state that the plan has then: position, velocity and acceleration.

use core::fmt;

use mrroc_robots::clearance::{CheckError, Clearance, Nearest};

use crate::braking::Braking;
use crate::error::PlanError;
use crate::plan::{Motion, Plan};

/// At how many instants a stop is looked at.
const INSTANTS: u32 = 8;

/// What robots do where they are nearest to something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum During {
    /// They follow the plan; a stop on the path does so too.
    Motion,
    /// All of them stop by a fault, at the same time.
    FaultStop,
    /// Some stop at once. The others follow the plan until the reaction time is over, and stop then. Only for several robots.
    LateStop,
    /// Some go straight on at their velocities until the reaction time is over, and stop then. The others, if any, stop at once.
    StraightStop,
}

impl During {
    /// All of them, as they stand in the table.
    const ALL: [During; 4] = [During::Motion, During::FaultStop, During::LateStop, During::StraightStop];
}

impl fmt::Display for During {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            During::Motion => "motion, stop on the path",
            During::FaultStop => "fault stop of all at once",
            During::LateStop => "fault stop, some later",
            During::StraightStop => "fault stop, first straight on",
        })
    }
}

/// The nearest that robots come to something, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Closest {
    /// Path time from the beginning of the motion \[s\]: of a stop, when the fault happens.
    pub time: f64,
    /// What they do then.
    pub during: During,
    /// Both bodies and their distance.
    pub nearest: Nearest,
}

impl fmt::Display for Closest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} at {:.3} s", self.nearest, self.during, self.time)
    }
}

/// The nearest that robots come to something in the motion and in each kind of stop. It prints as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestTable {
    rows: Vec<Closest>,
}

impl ClosestTable {
    /// One row for the motion, and one for each kind of stop that the robots can make.
    #[must_use]
    pub fn rows(&self) -> &[Closest] {
        &self.rows
    }

    /// The row of a kind; `None` for [`During::LateStop`] of one robot.
    #[must_use]
    pub fn during(&self, during: During) -> Option<&Closest> {
        self.rows.iter().find(|row| row.during == during)
    }

    /// The smallest distance of all rows \[m\]; below 0, how deep bodies overlap.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.rows.iter().map(|row| row.nearest.distance).fold(f64::INFINITY, f64::min)
    }
}

impl fmt::Display for ClosestTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<29}  {:>9}  {:>8}  between", "during", "clearance", "from")?;
        for Closest { time, during, nearest } in &self.rows {
            let [a, b] = &nearest.sides;
            write!(f, "\n{during:<29}  {:>6.1} mm  {time:>6.3} s  {a} and {b}", 1e3 * nearest.distance)?;
        }
        Ok(())
    }
}

/// A stop after a fault.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultStop {
    /// Which kind it is.
    pub during: During,
    /// The positions of all joints [rad or m] at eight instants, evenly spaced from the fault until all robots stand. The last one is
    /// where they stand.
    pub positions: Vec<Vec<f64>>,
}

/// The state of all joints at a path time.
struct State {
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Plan {
    /// The smallest clearance of the motion and of each kind of its stops, looked at every `step` \[s\], > 0: at the instants of the
    /// motion, and at eight instants of each stop after a fault at each of them. Where several robots need not stop together, all choices
    /// of those that stop later are looked at: that is 17 postures per instant for one robot, and 241 for four.
    ///
    /// # Errors
    /// [`PlanError::Check`]: the clearance is of other robots.
    pub fn closest(&self, clearance: &mut Clearance, step: f64) -> Result<ClosestTable, PlanError> {
        let begins = self.motion.speed.begins;
        let count = ((self.duration() - begins) / step).ceil().max(1.0) as usize;
        let mut rows: [Option<Closest>; During::ALL.len()] = [const { None }; During::ALL.len()];
        for k in 0..=count {
            let time = begins + k as f64 * step;
            let mut keep = |during: During, q: &[f64]| -> Result<(), PlanError> {
                let nearest = clearance.nearest_at(&self.motion.limits.split(q))?;
                let row = &mut rows[during as usize];
                if row.as_ref().is_none_or(|row| nearest.distance < row.nearest.distance) {
                    *row = Some(Closest { time, during, nearest });
                }
                Ok(())
            };
            keep(During::Motion, &self.at(time))?;
            for stop in self.fault_stops(time) {
                stop.positions.iter().try_for_each(|q| keep(stop.during, q))?;
            }
        }
        let rows: Vec<Closest> = rows.into_iter().flatten().collect();
        if rows.is_empty() { Err(CheckError::NothingToCheck.into()) } else { Ok(ClosestTable { rows }) }
    }

    /// The stops that robots may make after a fault at a path time \[s\]: of each kind, and of every choice of robots that stop later.
    #[must_use]
    pub fn fault_stops(&self, time: f64) -> Vec<FaultStop> {
        let robots = self.motion.limits.robots.len();
        let all_robots = (1_u32 << robots) - 1;
        let mut stops = Vec::new();
        for during in During::ALL {
            // The robots that stop later, bit by bit. If all do so on the path, it is a stop of all that begins later.
            let late = match during {
                During::Motion => continue,
                During::FaultStop => 0..=0,
                During::LateStop if robots == 1 => continue,
                During::LateStop => 1..=all_robots - 1,
                During::StraightStop => 1..=all_robots,
            };
            stops.extend(late.map(|late| FaultStop { during, positions: self.stopping(time, during, late) }));
        }
        stops
    }

    /// The positions of all joints at some instants after a fault at a path time, until all robots stand.
    fn stopping(&self, time: f64, during: During, late: u32) -> Vec<Vec<f64>> {
        let Motion { limits, reaction, .. } = &*self.motion;
        let is_straight = during == During::StraightStop;
        let (q, now, then) = (self.at(time), self.motion.state(time), self.motion.state(time + reaction));
        // Joint by joint: when it brakes, from where, and how.
        let mut stops: Vec<(f64, f64, Braking)> = Vec::with_capacity(limits.joints());
        for (robot, joints) in limits.robots.iter().enumerate() {
            let is_late = late >> robot & 1 == 1;
            let state = if is_late && !is_straight { &then } else { &now };
            let longest =
                joints.clone().map(|j| state.velocity[j].abs() / limits.acceleration[j]).fold(0.0, f64::max);
            for j in joints.clone() {
                let velocity = state.velocity[j];
                let braking = limits.jerk[j].map_or_else(
                    || Braking::even(velocity, longest),
                    |jerk| Braking::with_jerk(velocity, state.acceleration[j], limits.acceleration[j], jerk),
                );
                let (delay, from) = match (is_late, is_straight) {
                    (false, _) => (0.0, q[j]),
                    (true, true) => (*reaction, q[j] + velocity * reaction),
                    (true, false) => (*reaction, self.motion.joint_at(time + reaction, j)),
                };
                stops.push((delay, from, braking));
            }
        }
        let lasts = stops.iter().map(|(delay, _, braking)| delay + braking.duration()).fold(0.0, f64::max);
        let positions_at = |t: f64| -> Vec<f64> {
            let joints = stops.iter().enumerate();
            joints
                .map(|(j, (delay, from, braking))| {
                    if t >= *delay {
                        from + braking.at(t - delay)
                    } else if is_straight {
                        q[j] + now.velocity[j] * t
                    } else {
                        self.motion.joint_at(time + t, j)
                    }
                })
                .collect()
        };
        (1..=INSTANTS).map(|k| positions_at(lasts * f64::from(k) / f64::from(INSTANTS))).collect()
    }
}

impl Motion {
    /// Velocity and acceleration of all joints at a path time \[s\]; at rest before it begins and behind its end.
    fn state(&self, time: f64) -> State {
        let n = self.limits.joints();
        if time < self.speed.begins || time >= self.speed.duration() {
            return State { velocity: vec![0.0; n], acceleration: vec![0.0; n] };
        }
        let at = self.speed.at(time);
        let point = self.path.at(at.s);
        State {
            velocity: point.first.iter().map(|first| first * at.v).collect(),
            acceleration: point
                .first
                .iter()
                .zip(&point.second)
                .map(|(first, second)| first * at.a + second * at.v * at.v)
                .collect(),
        }
    }
}
