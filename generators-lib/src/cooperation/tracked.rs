//! A frame that moves by itself, followed by readings that come late and not in every step.
//!
//! A reading of age `a` says where the frame was; with the velocity `u` between readings (low-passed), it now is at
//! `z = Exp(u a) X_read`. With the rate `k`, the frame that is followed is drawn there critically damped:
//!
//! ```text
//! v' = k^2 (z - x) + 2 k (u - v), |v'| <= A        x' = v
//! ```
//!
//! so neither its position nor its velocity ever has a step, and a steady motion is followed without lag. RCCL's functional
//! transforms with an age (Hayward and Paul 1986), where the function is a sensor.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use crate::between::{displacement, moved};

/// How a frame is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// `k` [1/s], finite, > 0; errors are gone after some `6 / k`.
    pub rate: f64,
    /// `A` of the translation [m/s^2], finite, > 0.
    pub acceleration: f64,
    /// The same of the rotation [rad/s^2], finite, > 0.
    pub turning: f64,
}

/// A frame that is followed.
#[derive(Clone, Copy, Debug)]
pub struct TrackedFrame {
    how: Tracking,
    pose: Pose,
    velocity: [Vector3<f64>; 2],
    /// Time by the clock \[s\].
    clock: f64,
    /// The last reading and the time that it is of, and the velocities between readings.
    read: Option<(Pose, f64)>,
    between: [Vector3<f64>; 2],
}

impl TrackedFrame {
    /// Not seen yet.
    #[must_use]
    pub fn new(how: Tracking) -> Self {
        let still = [Vector3::zeros(); 2];
        TrackedFrame { how, pose: Pose::identity(), velocity: still, clock: 0.0, read: None, between: still }
    }

    /// The frame after `time` \[s\] by the clock and `dt` \[s\] of path time more, and what is read now: a pose and its age
    /// \[s\], the same as before or a new one. `None` before the first reading. Without path time it stays. Where path time
    /// goes at a share `r` of the clock's, the frame is followed at a distance of `2 u (1 / r - 1) / k`.
    pub fn follow(&mut self, reading: Option<(Pose, f64)>, time: f64, dt: f64) -> Option<Pose> {
        self.clock += time;
        if let Some((pose, age)) = reading {
            self.take(pose, self.clock - age);
        }
        let (pose, at) = self.read?;
        let to = moved(&pose, self.between.map(|u| u * (self.clock - at)));
        let Tracking { rate: k, acceleration, turning } = self.how;
        if dt > 0.0 {
            let gap = displacement(&self.pose, &to);
            for (i, most) in [acceleration, turning].into_iter().enumerate() {
                // Implicit in v: stable whatever the step.
                let wanted = (self.velocity[i] + (gap[i] * (k * k) + self.between[i] * (2.0 * k)) * dt)
                    / (1.0 + 2.0 * k * dt + k * k * dt * dt);
                let change = wanted - self.velocity[i];
                let share = most * dt / change.norm();
                self.velocity[i] += if share < 1.0 { change * share } else { change };
            }
            self.pose = moved(&self.pose, self.velocity.map(|v| v * dt));
        }
        Some(self.pose)
    }

    /// A reading of the time `at`; one that is no later than the last is the last one.
    fn take(&mut self, pose: Pose, at: f64) {
        let Some((before, then)) = self.read else {
            self.pose = pose;
            self.read = Some((pose, at));
            return;
        };
        let between = at - then;
        if between <= 1e-9 {
            return;
        }
        // Over the time constant of the tracking.
        let share = between / (between + 1.0 / self.how.rate);
        for (u, moved_by) in self.between.iter_mut().zip(displacement(&before, &pose)) {
            *u += (moved_by / between - *u) * share;
        }
        self.read = Some((pose, at));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 2e-3;

    fn belt(t: f64) -> Pose {
        Pose::new(Vector3::new(0.1 * t, 0.3, 0.0), Vector3::z() * (0.4 * t))
    }

    /// Followed for `n` steps by readings every fourth step that are three to six steps old.
    fn followed(truth: impl Fn(f64) -> Pose, n: u32) -> Vec<Pose> {
        let mut frame = TrackedFrame::new(Tracking { rate: 20.0, acceleration: 2.0, turning: 10.0 });
        let seen = |i: u32| {
            let of = (i.checked_sub(3)? / 4) * 4;
            Some((truth(f64::from(of) * DT), f64::from(i - of) * DT))
        };
        (1..=n).filter_map(|i| frame.follow(seen(i), DT, DT)).collect()
    }

    #[test]
    fn a_steady_motion_is_followed_without_lag_however_late_its_readings_are() {
        let trace = followed(belt, 1000);
        let off = displacement(trace.last().expect("seen"), &belt(2.0));
        assert!(off[0].norm() < 1e-9 && off[1].norm() < 1e-9, "{} {}", off[0], off[1]);
        // Within 0.5 s to a tenth of a millimetre, as 6 / k says.
        let off = displacement(&trace[250 - 3], &belt(0.5));
        assert!(off[0].norm() < 1e-3, "{}", off[0]);
    }

    #[test]
    fn a_frame_that_stops_and_noise_make_no_step_of_velocity() {
        let stops = |t: f64| {
            let noise = 2e-4 * (t * 7e3).sin();
            moved(&belt(t.min(1.0)), [Vector3::x() * noise, Vector3::zeros()])
        };
        let trace = followed(stops, 1000);
        for w in trace.windows(3) {
            let a = displacement(&w[0], &w[1]);
            let b = displacement(&w[1], &w[2]);
            assert!(
                (b[0] - a[0]).norm() <= 2.0 * DT * DT + 1e-15
                    && (b[1] - a[1]).norm() <= 10.0 * DT * DT + 1e-12
            );
        }
        let end = displacement(trace.last().expect("seen"), &belt(1.0));
        assert!(end[0].norm() < 3e-4, "{}", end[0]);
    }

    #[test]
    fn it_is_nowhere_before_it_is_seen_and_stands_without_path_time() {
        let mut frame = TrackedFrame::new(Tracking { rate: 20.0, acceleration: 2.0, turning: 10.0 });
        assert_eq!(frame.follow(None, DT, DT), None);
        assert_eq!(frame.follow(Some((belt(1.0), 0.0)), DT, DT), Some(belt(1.0)));
        assert_eq!(frame.follow(Some((belt(2.0), 0.0)), DT, 0.0), Some(belt(1.0)));
    }

    /// At half the feed: v = u / r in path time, and k^2 e = 2 k (v - u).
    #[test]
    fn at_a_lower_feed_rate_it_lags_as_stated() {
        let k = 20.0;
        let r = 0.5;
        let mut frame = TrackedFrame::new(Tracking { rate: 20.0, acceleration: 2.0, turning: 10.0 });
        let mut here = None;
        for i in 1..=4000 {
            here = frame.follow(Some((belt(f64::from(i) * DT), 0.0)), DT, r * DT);
        }
        let lag = displacement(&here.expect("seen"), &belt(4000.0 * DT))[0].x;
        assert!((lag - 2.0 * 0.1 * (1.0 / r - 1.0) / k).abs() < 0.02 * lag, "{lag}");
    }
}
