//! Whether an arm can go along straight lines, known before it begins to.
//!
//! In: where the arm is, and the poses that its tool is to be brought to, one line after another. Out: whether it keeps all limits on them.
//!
//! Each step of each line is looked at as its EDP will do: the joints of the pose, their velocity and acceleration, what joints share (the
//! angles and speeds of motors), and all of that where the arm would stand if its demands were lost then:
//!
//! ```text
//! q + v (T_detect + max_j(|v_j| / a_j) / 2)
//! ```
//!
//! with the time until an EDP notices that its demands are lost, [`detection_time`].

use core::time::Duration;

use mrroc::prelude::*;
use mrroc::robot::{RobotState, detection_time};
use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileCursor;
use mrroc_robots::{Irp6, Six};

/// What the program of an arm knows of its reach.
#[derive(Clone, Debug)]
pub struct Reach {
    arm: Irp6,
    /// For so long it goes on before it brakes when its demands are lost \[s\].
    noticing: f64,
    /// A step of the cell \[s\].
    step: f64,
}

impl Reach {
    /// Of an arm that stands so far along the belt \[m\], in a cell of these steps.
    #[must_use]
    pub fn at(along: f64, step: Duration) -> Self {
        let arm = Irp6::nominal().with_base(Pose::translation(0.0, along, 0.0));
        Self { arm, noticing: detection_time(step), step: step.as_secs_f64() }
    }

    /// The same for an arm that may go on for another time before it brakes \[s\].
    #[must_use]
    pub fn noticing(self, noticing: f64) -> Self {
        Self { noticing, ..self }
    }

    /// Whether the arm, at rest at `from`, can bring its tool to these poses `X_WE`, on a straight line to each.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn contains(&self, from: &RobotState<Irp6>, poses: &[Pose], limits: ToolLimits) -> bool {
        let X_FE = self.arm.forward(&from.joints).inv_mul(&from.pose);
        let (mut q, mut pose) = (from.joints, from.pose);
        for to in poses {
            let line = LinePath::new(pose, *to);
            let Ok(profile) = line.profile(limits) else { return false };
            let (mut cursor, mut velocity) = (ProfileCursor::new(profile), Six::zeros());
            while let Some(point) = cursor.advance(self.step) {
                let flange = line.pose(point.s) * X_FE.inverse();
                let Ok(next) = self.arm.inverse(&flange, &q) else { return false };
                let faster = (next - q) / self.step;
                if !self.keeps_limits(&q, &next, &faster, &velocity) {
                    return false;
                }
                (q, velocity) = (next, faster);
            }
            pose = *to;
        }
        true
    }

    /// Whether a step from `q` to `next` \[rad\], at `velocity` after one at `before` [rad/s], keeps all limits, and a stop from there too.
    fn keeps_limits(&self, q: &Six, next: &Six, velocity: &Six, before: &Six) -> bool {
        let limits = self.arm.limits();
        let braking = velocity.abs().component_div(&limits.acceleration).max();
        let time = self.noticing + 0.5 * braking;
        let stop = next + velocity * time;
        let within = |i: usize| {
            let range = limits.lower[i]..=limits.upper[i];
            velocity[i].abs() <= limits.velocity[i]
                && (velocity[i] - before[i]).abs() <= limits.acceleration[i] * self.step
                && range.contains(&next[i])
                && range.contains(&stop[i])
        };
        (0..next.len()).all(within)
            && self.arm.check_coupled_to_stop(q, (next, self.step), (&stop, time)).is_ok()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::places::{BELT, END, HIGH, HOME, OVER_TRAY, TRAYS, limits, over_tray, tool};

    /// An arm so far along the belt \[m\] at rest with its tool, 0.2 m beyond the flange, there.
    pub(crate) fn at_rest(pose: Pose, along: f64) -> Option<RobotState<Irp6>> {
        let arm = Irp6::nominal().with_base(Pose::translation(0.0, along, 0.0));
        let flange = pose * Pose::translation(0.0, 0.0, -0.2);
        let joints = arm.inverse(&flange, &Irp6::READY).ok()?;
        Some(RobotState { joints, velocity: Six::zeros(), pose })
    }

    #[test]
    fn with_infrared_sensors_the_arm_gets_to_both_trays_and_back_from_everywhere_at_the_belt() {
        let (reach, home) = (Reach::at(0.0, Duration::from_millis(4)), tool(HOME, 0.0, HIGH));
        // Where `Rise` stops at 1.2 times the fastest belt; across, with the error of the range finder.
        let farthest = END + 0.2 * 1.2 * 0.15;
        for step in 0..=60 {
            let s = farthest * f64::from(step) / 60.0;
            for across in [-0.025, 0.0, 0.025] {
                let from = at_rest(tool(s, across, HIGH), 0.0).expect("a posture");
                assert!(reach.contains(&from, &[home], limits()), "{s} {across}");
                for tray in 0..TRAYS.len() {
                    let lines = [over_tray(tray, HIGH), over_tray(tray, OVER_TRAY), home];
                    assert!(reach.contains(&from, &lines, limits()), "{s} {across} to tray {tray}");
                }
            }
        }
        // A line that leads nearer to the column than the arm can fold is none.
        let beside = tool(0.5 - BELT[1], 0.5 - BELT[0], HIGH);
        let from = at_rest(beside, 0.0).expect("a posture");
        assert!(!reach.contains(&from, &[tool(-0.5 - BELT[1], 0.5 - BELT[0], HIGH)], limits()));
    }
}
