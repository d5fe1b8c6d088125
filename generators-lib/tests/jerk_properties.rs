//! What every jerk-limited plan keeps, for random inputs; `just sweep-profiles` takes many.

use mrroc::random::Random;
use mrroc_generators::jerk::*;
use nalgebra::Vector3;

/// Random inputs by a seed.
struct Inputs(Random);

impl Inputs {
    fn seeded(seed: u64) -> Inputs {
        Inputs(Random::seeded(seed))
    }

    fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    fn range(&mut self, low: f64, high: f64) -> f64 {
        self.0.between(low, high)
    }

    /// Uniform, or, once in eight times, one of the ends or 0.
    fn value(&mut self, low: f64, high: f64) -> f64 {
        match (self.unit() * 24.0) as u32 {
            0 => low,
            1 => high,
            2 => 0.0,
            _ => self.range(low, high),
        }
    }

    fn limits(&mut self) -> AxisLimits {
        let symmetric =
            AxisLimits::symmetric(self.range(0.1, 4.0), self.range(0.2, 8.0), self.range(0.5, 80.0));
        if self.unit() < 0.5 {
            return symmetric;
        }
        let (min_velocity, min_acceleration) = (-self.range(0.1, 4.0), -self.range(0.2, 8.0));
        AxisLimits { min_velocity, min_acceleration, ..symmetric }
    }

    /// A start that need not leave the limits, and a target.
    fn axis(&mut self) -> (AxisState, AxisTarget, AxisLimits) {
        loop {
            let limits = self.limits();
            let rests = self.unit() < 0.2;
            let (velocity, acceleration) = if rests {
                (0.0, 0.0)
            } else {
                (
                    self.value(limits.min_velocity, limits.max_velocity),
                    self.value(limits.min_acceleration, limits.max_acceleration),
                )
            };
            let inevitable = velocity + acceleration * acceleration.abs() / (2.0 * limits.jerk);
            if inevitable < limits.min_velocity || inevitable > limits.max_velocity {
                continue;
            }
            let position = self.value(-3.0, 3.0);
            let displacement =
                if self.unit() < 0.3 { self.range(-1e-3, 1e-3) } else { self.value(-4.0, 4.0) };
            let stops = rests || self.unit() < 0.3;
            let end = if stops { 0.0 } else { self.value(limits.min_velocity, limits.max_velocity) };
            let pushed = !stops && self.unit() < 0.5;
            let pushed =
                if pushed { self.value(limits.min_acceleration, limits.max_acceleration) } else { 0.0 };
            let before = end - pushed * pushed.abs() / (2.0 * limits.jerk);
            if before < limits.min_velocity || before > limits.max_velocity {
                continue;
            }
            let target =
                AxisTarget { position: position + displacement, velocity: end, acceleration: pushed };
            return (AxisState { position, velocity, acceleration }, target, limits);
        }
    }
}

/// How many inputs a test takes, and how many `just sweep-profiles` does.
const SHARE: u64 = 8000;
const WHOLE: u64 = 256_000;

fn check(profile: &JerkProfile, axis: &(AxisState, AxisTarget, AxisLimits), what: &str) {
    let (start, target, limits) = axis;
    let AxisPoint { position, velocity, acceleration, .. } = profile.at(0.0);
    assert_eq!(AxisState { position, velocity, acceleration }, *start, "{what}: {axis:?}");
    // The end itself is exact by definition; what leads there is what may miss.
    let (end, before) = (profile.at(profile.duration()), profile.at(profile.duration().next_down()));
    assert_eq!((end.position, end.velocity), (target.position, target.velocity));
    assert_eq!(end.acceleration, target.acceleration);
    assert!((before.position - target.position).abs() < 1e-8, "{what}: {before:?} {axis:?}");
    assert!((before.velocity - target.velocity).abs() < 1e-8, "{what}: {before:?} {axis:?}");
    assert!((before.acceleration - target.acceleration).abs() < 1e-10, "{what}: {before:?} {axis:?}");
    let peaks = profile.peaks();
    let within =
        |(high, low): (f64, f64), most: f64, least: f64| high <= most + 1e-12 && low >= least - 1e-12;
    assert!(
        within(peaks.velocity, limits.max_velocity, limits.min_velocity)
            && within(peaks.acceleration, limits.max_acceleration, limits.min_acceleration)
            && within(peaks.jerk, limits.jerk, -limits.jerk),
        "{what}: {peaks:?} {axis:?}"
    );
}

fn fastest(count: u64) {
    for seed in 0..count {
        let axis = Inputs::seeded(seed).axis();
        let plan = AxisPlan::new(&axis.0, &axis.1, &axis.2).unwrap_or_else(|e| panic!("{e}: {axis:?}"));
        check(&plan.fastest(), &axis, "fastest");
    }
}

#[test]
fn a_fastest_motion_reaches_its_target_within_the_limits() {
    fastest(SHARE);
}

fn lasting(count: u64) {
    for seed in 0..count {
        let mut random = Inputs::seeded(seed + 1_000_000_000);
        let axis = random.axis();
        let plan = AxisPlan::new(&axis.0, &axis.1, &axis.2).unwrap();
        let longer = random.value(1.0, 2.5);
        let duration = plan.possible_from(plan.least() * longer + random.value(0.0, 0.3));
        let profile = plan.lasting(duration).unwrap_or_else(|e| panic!("{e}: {axis:?}"));
        assert_eq!(profile.duration(), duration);
        check(&profile, &axis, "lasting");
        for (from, until) in plan.blocked() {
            let inside = from + (until - from) * random.range(0.01, 0.99);
            if until - from > 1e-6 && inside > plan.least() {
                assert!(matches!(plan.lasting(inside), Err(JerkError::Duration { .. })), "{axis:?}");
            }
        }
    }
}

#[test]
fn a_motion_of_any_possible_duration_reaches_its_target_within_the_limits() {
    lasting(SHARE);
}

fn from_outside(count: u64) {
    for seed in 0..count {
        let mut random = Inputs::seeded(seed + 4_000_000_000);
        let (inside, target, limits) = random.axis();
        let (v, a) = (random.value(-3.0, 3.0), random.value(-3.0, 3.0));
        let start = AxisState {
            velocity: v * limits.max_velocity,
            acceleration: a * limits.max_acceleration,
            ..inside
        };
        let plan = AxisPlan::new(&start, &target, &limits).unwrap_or_else(|e| panic!("{e}: {start:?}"));
        let longer = plan.possible_from(1.5 * plan.least());
        for profile in [plan.fastest(), plan.lasting(longer).unwrap()] {
            let what = || format!("{start:?} {target:?} {limits:?}");
            let (back, end) = (plan.recovery_time(), profile.duration());
            let before = profile.at(end.next_down());
            let size = 1.0 + (start.velocity.abs() + limits.max_velocity) * end;
            assert!((before.position - target.position).abs() < 1e-9 * size, "{before:?} {}", what());
            assert!((before.velocity - target.velocity).abs() < 1e-8, "{before:?} {}", what());
            assert!((before.acceleration - target.acceleration).abs() < 1e-9, "{before:?} {}", what());
            // Where the path back ends below the other limit's reach, the velocity is not inside yet, but gets nowhere worse.
            let at = profile.at(back);
            let (high, low) =
                (limits.max_velocity.max(at.velocity) + 1e-9, limits.min_velocity.min(at.velocity) - 1e-9);
            for i in 0..=200 {
                let point = profile.at(back + (end - back) * f64::from(i) / 200.0);
                let (v, a) = (point.velocity, point.acceleration);
                assert!(v <= high && v >= low, "{point:?} {}", what());
                assert!(
                    a <= limits.max_acceleration + 1e-9 && a >= limits.min_acceleration - 1e-9,
                    "{}",
                    what()
                );
                assert!(point.jerk.abs() <= limits.jerk + 1e-9);
            }
        }
    }
}

#[test]
fn a_start_outside_the_limits_comes_back_and_reaches_its_target() {
    from_outside(SHARE);
}

/// The principle of optimality: what is left of a fastest motion is the fastest motion from there.
fn rests(count: u64) {
    for seed in 0..count {
        let mut random = Inputs::seeded(seed + 2_000_000_000);
        let (start, target, limits) = random.axis();
        let fastest = AxisPlan::new(&start, &target, &limits).unwrap().fastest();
        let t = random.range(0.0, 0.9) * fastest.duration();
        let AxisPoint { position, velocity, acceleration, .. } = fastest.at(t);
        let from = AxisState { position, velocity, acceleration };
        let expected = fastest.duration() - t;
        // During a motion to a target with an acceleration there are states that, but for the target, must leave the limits.
        if AxisPlan::new(&from, &target, &limits).is_ok_and(|plan| plan.recovery_time() > 0.0) {
            continue;
        }
        // A sum of rounding errors is a distance, which at the least jerk takes its cube root of time; and where the
        // duration jumps, they decide on which side.
        let near = [0.0, 1e-11, -1e-11].iter().any(|off| {
            let target = AxisTarget { position: target.position + off, ..target };
            let rest = AxisPlan::new(&from, &target, &limits).unwrap_or_else(|e| panic!("{e}: {from:?}"));
            (rest.least() - expected).abs() < 2e-5 * (1.0 + expected)
        });
        assert!(near, "{expected} {start:?} {target:?} {limits:?}");
    }
}

#[test]
fn the_rest_of_a_fastest_motion_is_a_fastest_motion() {
    rests(SHARE);
}

fn synchronised(count: u64) {
    const DT: f64 = 1e-3;
    for seed in 0..count / 3 {
        let mut random = Inputs::seeded(seed + 3_000_000_000);
        let axes: [_; 3] = std::array::from_fn(|_| random.axis());
        let vector =
            |f: fn(&(AxisState, AxisTarget, AxisLimits)) -> f64| Vector3::from_fn(|i, _| f(&axes[i]));
        let start = JointState {
            position: vector(|x| x.0.position),
            velocity: vector(|x| x.0.velocity),
            acceleration: vector(|x| x.0.acceleration),
        };
        let target = JointTarget {
            position: vector(|x| x.1.position),
            velocity: vector(|x| x.1.velocity),
            acceleration: vector(|x| x.1.acceleration),
        };
        let free =
            SynchronisedMove::with_limits(&start, &target, |i| axes[i].2, MoveDuration::default()).unwrap();
        let on_step = MoveDuration { step: Some(DT), ..MoveDuration::default() };
        let whole = SynchronisedMove::with_limits(&start, &target, |i| axes[i].2, on_step).unwrap();
        let steps = whole.duration() / DT;
        assert!(whole.duration() >= free.duration() && (steps - steps.round()).abs() < 1e-6 * steps.max(1.0));
        for motion in [free, whole] {
            for (i, axis) in axes.iter().enumerate() {
                let profile = motion.axis(i).unwrap();
                assert_eq!(profile.duration(), motion.duration());
                check(profile, axis, "synchronised");
            }
        }
    }
}

#[test]
fn axes_arrive_together_on_a_step_within_their_limits() {
    synchronised(SHARE);
}

mod whole {
    use super::{WHOLE, fastest, from_outside, lasting, rests, synchronised};

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn a_fastest_motion_reaches_its_target_within_the_limits() {
        fastest(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn a_motion_of_any_possible_duration_reaches_its_target_within_the_limits() {
        lasting(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn a_start_outside_the_limits_comes_back_and_reaches_its_target() {
        from_outside(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn the_rest_of_a_fastest_motion_is_a_fastest_motion() {
        rests(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn axes_arrive_together_on_a_step_within_their_limits() {
        synchronised(WHOLE);
    }
}
