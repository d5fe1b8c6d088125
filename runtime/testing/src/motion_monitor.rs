//! Watches the demands that a robot's drives get: whether they are within the limits, and when the robot moves.
//!
//! In: the position demanded of the drives in each servo period. Out: the first demand that the drives should not have
//! got, and the intervals of motion. Velocity and acceleration are computed here, independently of the runtime: as
//! differences of the positions that the drives got, divided by the time that passed. Servo periods that a late EDP
//! left out have no demands (fault 11 in docs/safety).

use core::time::Duration;
use std::collections::VecDeque;

use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::{JointLayout, RobotLayout};
use mrroc_core::robot::{JointVector, Limits};

/// The limits of what a robot's drives may be demanded.
#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// Of third differences over this time \[ns\]; empty where jerk is not checked.
    pub jerk: Vec<f64>,
    pub over: Nanos,
    pub servo: Nanos,
}

impl Bounds {
    /// The limits of a robot of a cell.
    pub fn of(robot: &RobotLayout) -> Bounds {
        let joints = |value: fn(&JointLayout) -> f64| robot.joints.iter().map(value).collect();
        Bounds {
            lower: joints(|joint| joint.lower),
            upper: joints(|joint| joint.upper),
            velocity: joints(|joint| joint.velocity),
            acceleration: joints(|joint| joint.acceleration),
            jerk: Vec::new(),
            over: 0,
            servo: robot.servo.as_nanos() as Nanos,
        }
    }

    /// The limits of a robot whose drives have this servo period; jerk is not checked.
    pub fn of_limits<J: JointVector>(limits: &Limits<J>, servo: Duration) -> Bounds {
        let joints = |all: &J| all.as_slice().to_vec();
        Bounds {
            lower: joints(&limits.lower),
            upper: joints(&limits.upper),
            velocity: joints(&limits.velocity),
            acceleration: joints(&limits.acceleration),
            jerk: Vec::new(),
            over: 0,
            servo: servo.as_nanos() as Nanos,
        }
    }

    /// The same with the jerk limits of the robot, in a cell of this step. A jerk limit holds from step to step: where there
    /// are several servo periods in one, the acceleration changes at its beginning.
    pub fn with_jerk(mut self, robot: &RobotLayout, step: Duration) -> Bounds {
        let jerk: Option<Vec<f64>> = robot.joints.iter().map(|joint| joint.jerk).collect();
        self.jerk = jerk.unwrap_or_default();
        self.over = (step.as_nanos() as Nanos).max(self.servo);
        self
    }
}

/// The demands that one robot's drives got in a trial.
#[derive(Clone, Debug)]
pub(crate) struct MotionMonitor {
    pub name: String,
    bounds: Bounds,
    last: Vec<f64>,
    velocity: Vec<f64>,
    ticks: u64,
    /// The end of the last servo period \[ns\], and the time from the one before it \[s\].
    told: Nanos,
    lasted: f64,
    /// The positions of the servo periods before, the newest last, for third differences.
    before: VecDeque<Vec<f64>>,
    /// The intervals of motion: when the robot began to move, and when it stood again \[ns\].
    pub episodes: Vec<(Nanos, Nanos)>,
    /// The first demand that was wrong, as text.
    pub wrong: Option<String>,
}

/// By how much a difference may exceed a limit, as a share of the limit.
const SHARE: f64 = 1e-9;
/// Relative round-off error of a position.
const ROUND_OFF: f64 = 1e-15;

impl MotionMonitor {
    pub fn new(name: &str, bounds: Bounds) -> MotionMonitor {
        let velocity = vec![0.0; bounds.lower.len()];
        let (last, episodes) = (Vec::new(), Vec::new());
        let lasted = bounds.servo as f64 * 1e-9;
        MotionMonitor {
            name: name.to_owned(),
            bounds,
            last,
            velocity,
            ticks: 0,
            told: 0,
            lasted,
            before: VecDeque::new(),
            episodes,
            wrong: None,
        }
    }

    /// The position demanded last [rad or m].
    pub fn last(&self) -> &[f64] {
        &self.last
    }

    /// Notes that the drives get the positions `demanded` [rad or m] for the end of a servo period \[ns\].
    pub fn see(&mut self, end: Nanos, demanded: &[f64]) {
        if self.last.is_empty() {
            (self.last, self.told) = (demanded.to_vec(), end.saturating_sub(self.bounds.servo));
        }
        let servo = self.bounds.servo as f64 * 1e-9;
        let dt = (end.saturating_sub(self.told) as f64 * 1e-9).max(servo);
        // Each velocity is a mean over an interval; this is the time between the middles of the two intervals.
        let between = (dt + self.lasted) / 2.0;
        let mut moves = false;
        for (i, &q) in demanded.iter().enumerate() {
            let velocity = (q - self.last[i]) / dt;
            let acceleration = (velocity - self.velocity[i]) / between;
            moves |= velocity != 0.0;
            let round_off = ROUND_OFF * (1.0 + q.abs());
            let is_within = |x: f64, limit: f64, error: f64| x.abs() <= limit * (1.0 + SHARE) + error;
            let bounds = &self.bounds;
            let says = if !q.is_finite() {
                Some("not a number")
            } else if q < bounds.lower[i] - round_off || q > bounds.upper[i] + round_off {
                Some("position beyond its limit")
            } else if !is_within(velocity, bounds.velocity[i], 2.0 * round_off / dt) {
                Some("velocity beyond its limit")
            } else if self.ticks > 1
                && !is_within(acceleration, bounds.acceleration[i], 4.0 * round_off / (servo * servo))
            {
                Some("acceleration beyond its limit")
            } else {
                None
            };
            if let (Some(says), None) = (says, &self.wrong) {
                let (name, joint, time) = (&self.name, i + 1, end as f64 * 1e-9);
                self.wrong = Some(format!(
                    "{name} joint {joint} at {time:.4} s: {says}: {q}, {velocity}/s, {acceleration}/s²"
                ));
            }
            (self.last[i], self.velocity[i]) = (q, velocity);
        }
        self.check_jerk(end, demanded, dt);
        self.ticks += 1;
        let began = self.told.max(end.saturating_sub((dt * 1e9).round() as Nanos));
        (self.told, self.lasted) = (end, dt);
        if moves {
            match self.episodes.last_mut() {
                Some((_, stood)) if *stood >= began => *stood = end,
                Some(_) | None => self.episodes.push((began, end)),
            }
        }
    }

    /// Compares third differences with the jerk limits. After a period that was left out they begin anew.
    fn check_jerk(&mut self, end: Nanos, demanded: &[f64], dt: f64) {
        let bounds = &self.bounds;
        if bounds.jerk.is_empty() {
            return;
        }
        let apart = bounds.over.div_ceil(bounds.servo.max(1)) as usize;
        if dt > bounds.servo as f64 * 1.5e-9 {
            self.before.clear();
        }
        self.before.push_back(demanded.to_vec());
        if self.before.len() > 3 * apart + 1 {
            self.before.pop_front();
        }
        if self.before.len() <= 3 * apart || self.wrong.is_some() {
            return;
        }
        let over = bounds.over as f64 * 1e-9;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &self.before[k * apart]);
        for i in 0..demanded.len() {
            let jerk = (d[i] - 3.0 * c[i] + 3.0 * b[i] - a[i]) / over.powi(3);
            // As demands are checked: within the round-off of a difference of positions.
            let round_off = 8.0 * 1e-12 * d[i].abs().max(1.0) / over.powi(3);
            let limit = bounds.jerk[i];
            if jerk.abs() > limit * (1.0 + 1e-6) + round_off {
                let (name, joint, time) = (&self.name, i + 1, end as f64 * 1e-9);
                self.wrong = Some(format!(
                    "{name} joint {joint} at {time:.4} s: jerk beyond its limit: {jerk}, {limit}"
                ));
                return;
            }
        }
    }

    /// Servo periods that were seen.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The servo period \[ns\].
    pub fn servo(&self) -> Nanos {
        self.bounds.servo
    }

    /// When the robot moved last \[ns\].
    pub fn stood(&self) -> Nanos {
        self.episodes.last().map_or(0, |&(_, stood)| stood)
    }
}

/// The first demand beyond a robot's limits of position, velocity or acceleration, as text, of those that its drives got: each the end of its
/// servo period \[ns\] and positions [rad or m]. Periods that a late EDP left out are missing.
///
/// ```
/// # use std::time::Duration;
/// use mrroc::robot::Robot;
/// use mrroc_robots::Irp6;
/// use mrroc_testing::first_beyond_limits;
///
/// let (arm, servo) = (Irp6::nominal(), Duration::from_millis(2));
/// let mut there = Irp6::READY;
/// let stands = [(2_000_000, Irp6::READY), (4_000_000, there)];
/// assert_eq!(first_beyond_limits("arm", arm.limits(), servo, stands.iter().map(|(end, q)| (*end, q.as_slice()))), None);
/// there[0] += 0.1;
/// let jumps = [(2_000_000, Irp6::READY), (4_000_000, there)];
/// let found = first_beyond_limits("arm", arm.limits(), servo, jumps.iter().map(|(end, q)| (*end, q.as_slice())));
/// assert!(found.is_some_and(|text| text.starts_with("arm joint 1 at 0.0040 s: velocity beyond its limit")));
/// ```
pub fn first_beyond_limits<'a, J: JointVector>(
    name: &str,
    limits: &Limits<J>,
    servo: Duration,
    demands: impl IntoIterator<Item = (Nanos, &'a [f64])>,
) -> Option<String> {
    let mut monitor = MotionMonitor::new(name, Bounds::of_limits(limits, servo));
    demands.into_iter().for_each(|(end, demanded)| monitor.see(end, demanded));
    monitor.wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> MotionMonitor {
        let bounds = Bounds {
            lower: vec![-1.0],
            upper: vec![1.0],
            velocity: vec![1.0],
            acceleration: vec![10.0],
            jerk: vec![2e3],
            over: 1_000_000,
            servo: 1_000_000,
        };
        MotionMonitor::new("g", bounds)
    }

    fn seen(demands: &[f64]) -> MotionMonitor {
        let mut monitor = monitor();
        for (i, &q) in demands.iter().enumerate() {
            monitor.see((i as u64 + 1) * 1_000_000, &[q]);
        }
        monitor
    }

    #[test]
    fn what_no_drive_should_get_is_seen() {
        for (demands, says) in [
            (&[0.0, 0.0, f64::NAN][..], "not a number"),
            (&[0.999_999, 0.999_999, 1.000_001], "position"),
            // 1.1 m/s; 11 m/s².
            (&[0.0, 0.0, 1.1e-3], "velocity"),
            (&[0.0, 0.0, 0.0, 1.1e-5], "acceleration"),
            // 2.1 m/s² after none, in 1 ms.
            (&[0.0, 0.0, 0.0, 0.0, 2.1e-6], "jerk"),
        ] {
            let wrong = seen(demands).wrong.expect(says);
            assert!(wrong.contains(says), "{wrong}");
        }
        // 10 m/s², which is exactly the limit, and 2000 m/s³ until then.
        let (mut q, mut v) = (0.0, 0.0);
        let mut demands = vec![0.0; 4];
        for step in 1..50 {
            v += (2e-3 * f64::from(step)).min(10e-3);
            q += v * 1e-3;
            demands.push(q);
        }
        assert_eq!(seen(&demands).wrong, None);
    }

    #[test]
    fn episodes_are_when_the_robot_moves() {
        let monitor = seen(&[0.0, 0.0, 1e-6, 2e-6, 2e-6, 2e-6, 1e-6]);
        assert_eq!(monitor.episodes, [(2_000_000, 4_000_000), (6_000_000, 7_000_000)]);
        assert_eq!(monitor.stood(), 7_000_000);
    }
}
