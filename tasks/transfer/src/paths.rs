//! How a tool or the body moves softly: along a line, with a velocity that has no corners.

use mrroc::prelude::*;
use mrroc_generators::cooperation::TimedBody;
use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileLimits;

/// A straight line from rest to rest, `s = 10 u³ - 15 u⁴ + 6 u⁵` of the share `u` of its time: velocity and acceleration are
/// zero at both ends.
#[derive(Clone, Copy, Debug)]
pub struct Soft {
    line: LinePath,
    duration: f64,
}

impl Soft {
    /// The fastest from one pose to another within `limits`: the largest velocity is `15/8 d/T`, the largest acceleration
    /// `10/sqrt(3) d/T²` of a distance `d` in the time `T`.
    ///
    /// # Errors
    /// A limit that is not finite and above 0, or poses that give no duration.
    pub fn between(from: Pose, to: Pose, limits: ToolLimits) -> Result<Soft, Fault> {
        let line = LinePath::new(from, to);
        let distances = [(line.length(), limits.translation), (line.angle(), limits.rotation)];
        let mut duration = 0.0_f64;
        for (distance, ProfileLimits { velocity, acceleration }) in distances {
            if ![velocity, acceleration].iter().all(|limit| limit.is_finite() && *limit > 0.0) {
                let text = format!("limits {velocity} /s, {acceleration} /s^2: write finite ones above 0");
                return Err(Fault::thrown(&text));
            }
            let least =
                [15.0 / 8.0 * distance / velocity, (10.0 / 3_f64.sqrt() * distance / acceleration).sqrt()];
            if !least.iter().all(|time| time.is_finite()) {
                return Err(Fault::thrown(&format!(
                    "a distance of {distance} m or rad takes no finite time"
                )));
            }
            duration = least.into_iter().fold(duration, f64::max);
        }
        Ok(Soft { line, duration })
    }

    /// How long it takes \[s\].
    #[must_use]
    pub const fn duration(&self) -> f64 {
        self.duration
    }

    /// Where it is at the time `t` \[s\]; the end is met exactly.
    #[must_use]
    pub fn pose(&self, t: f64) -> Pose {
        let u = if t < self.duration { t / self.duration } else { 1.0 };
        self.line.pose(u * u * u * (10.0 + u * (6.0 * u - 15.0)))
    }
}

/// The body softly by `X_BsB`, within `limits`.
///
/// # Errors
/// As [`Soft::between`].
#[allow(non_snake_case)]
pub fn soft(X_BsB: Pose, limits: ToolLimits) -> Result<TimedBody<impl FnMut(f64) -> Pose>, Fault> {
    let motion = Soft::between(Pose::identity(), X_BsB, limits)?;
    Ok(TimedBody::new(motion.duration(), move |t| motion.pose(t)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_soft_motion_reaches_its_end_and_the_limit_that_binds_and_none_else() {
        let limit = |velocity, acceleration| ProfileLimits { velocity, acceleration };
        let end = Pose::new(Vector3::new(0.3, 0.0, 0.4), Vector3::z() * 0.2);
        // A distance of 0.5 m: bound by velocity, and by acceleration.
        for (translation, v, a) in [(limit(0.1, 1.0), 0.1, 0.0), (limit(10.0, 0.5), 0.0, 0.5)] {
            let motion =
                Soft::between(Pose::identity(), end, ToolLimits { translation, rotation: limit(1.0, 10.0) });
            let motion = motion.expect("in order");
            let (h, mut fastest, mut hardest) = (motion.duration() * 1e-4, 0.0_f64, 0.0_f64);
            let at = |i: i32| motion.pose(f64::from(i) * h).translation.vector;
            for i in 1..10_000 {
                fastest = fastest.max((at(i + 1) - at(i - 1)).norm() / (2.0 * h));
                hardest = hardest.max((at(i + 1) - at(i) * 2.0 + at(i - 1)).norm() / (h * h));
            }
            assert!(v == 0.0 || (fastest / v - 1.0).abs() < 1e-5, "{fastest}");
            assert!(a == 0.0 || (hardest / a - 1.0).abs() < 1e-4, "{hardest}");
            assert!(
                fastest <= translation.velocity * (1.0 + 1e-5)
                    && hardest <= translation.acceleration * 1.0001
            );
            assert_eq!((motion.pose(0.0), motion.pose(motion.duration())), (Pose::identity(), end));
        }
        let nowhere =
            Soft::between(end, end, ToolLimits { translation: limit(1.0, 1.0), rotation: limit(1.0, 1.0) })
                .expect("in order");
        assert_eq!((nowhere.duration(), nowhere.pose(0.0)), (0.0, end));
    }

    #[test]
    fn limits_that_are_none_are_refused_and_so_are_motions_that_never_end() {
        let good = ProfileLimits { velocity: 0.1, acceleration: 0.2 };
        let end = Pose::new(Vector3::new(0.3, 0.0, 0.4), Vector3::z() * 0.2);
        let between = |translation, rotation| {
            Soft::between(Pose::identity(), end, ToolLimits { translation, rotation })
                .map(|motion| motion.duration())
        };
        assert!(between(good, good).is_ok());
        for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            for limits in
                [ProfileLimits { velocity: bad, ..good }, ProfileLimits { acceleration: bad, ..good }]
            {
                for refused in [between(limits, good), between(good, limits)] {
                    let text = refused.expect_err("refused").to_string();
                    assert!(text.contains(&bad.to_string()), "{text}");
                }
            }
        }
        // Finite, but the quotient is not.
        let slow = ProfileLimits { velocity: f64::MIN_POSITIVE, acceleration: 0.2 };
        let far = Pose::translation(1e10, 0.0, 0.0);
        let limits = ToolLimits { translation: slow, rotation: good };
        assert!(Soft::between(Pose::identity(), far, limits).is_err());
    }
}
