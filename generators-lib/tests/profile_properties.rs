//! What every profile of a path scalar keeps, for random inputs; `just sweep-profiles` takes many.

use mrroc::random::Random;
use mrroc_generators::profile::*;

/// Random inputs by a seed.
struct Inputs(Random);

impl Inputs {
    fn seeded(seed: u64) -> Inputs {
        Inputs(Random::seeded(seed))
    }

    fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// Over orders of magnitude.
    fn sized(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.unit())
    }

    fn distance(&mut self) -> f64 {
        if self.unit() < 0.04 { 0.0 } else { self.sized(1e-9, 20.0) }
    }

    fn limits(&mut self) -> JerkLimits {
        JerkLimits {
            velocity: self.sized(0.01, 5.0),
            acceleration: self.sized(0.02, 20.0),
            jerk: self.sized(0.1, 500.0),
        }
    }
}

/// How many inputs a test takes, and how many `just sweep-profiles` does.
const SHARE: u64 = 8000;
const WHOLE: u64 = 256_000;

/// Limits that a kind does not know are infinite: it steps there.
struct Bounds {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

/// Reaches its distance at rest, in `expected` seconds, within the limits at and between any instants.
fn check<P: Profile + Clone + std::fmt::Debug>(
    profile: &P,
    bounds: &Bounds,
    expected: f64,
    random: &mut Inputs,
) {
    let (d, t) = (profile.distance(), profile.duration());
    assert!((t - expected).abs() <= 1e-10 * expected, "{t} s, not {expected} s: {profile:?}");
    assert_eq!(profile.at(t), ProfilePoint { s: d, v: 0.0, a: 0.0 }, "{profile:?}");
    if d == 0.0 {
        return;
    }
    // The end itself is exact by definition; what leads there is what may miss, in the last instant that a time can name.
    let (before, left) = (profile.at(t.next_down()), t - t.next_down());
    assert!((before.s - d).abs() <= 1e-8, "{before:?} {profile:?}");
    assert!(before.v.abs() <= 1e-8 || bounds.acceleration.is_infinite(), "{before:?} {profile:?}");
    assert!(before.a.abs() <= 1e-10 + bounds.jerk * left, "{before:?} {profile:?}");
    let (mut last, mut at) = (profile.at(0.0), 0.0);
    let most = |limit: f64| limit + 1e-12 * (1.0 + limit);
    // Where the peaks of all kinds are, and anywhere.
    let peaks = [0.0, (3.0 - 3.0_f64.sqrt()) / 6.0, 0.5, (3.0 + 3.0_f64.sqrt()) / 6.0, 1.0_f64.next_down()];
    let mut instants: Vec<_> = (0..8).map(|_| random.unit()).chain(peaks).map(|x| x * t).collect();
    instants.sort_by(f64::total_cmp);
    for x in instants {
        let here = profile.at(x);
        assert!(here.s >= last.s - 1e-12 && here.s <= d + 1e-12 * (1.0 + d), "{here:?} {profile:?}");
        assert!(here.v >= -1e-12 && here.v <= most(bounds.velocity), "{here:?} at {x} s: {profile:?}");
        assert!(here.a.abs() <= most(bounds.acceleration), "{here:?} at {x} s: {profile:?}");
        // What the limits leave room for in between; an infinite one sets no bound.
        let room = |limit: f64| if limit.is_finite() { limit * (x - at) } else { f64::INFINITY };
        assert!(
            here.s - last.s <= room(bounds.velocity) + 1e-12 * (1.0 + d),
            "{here:?} {last:?} {profile:?}"
        );
        assert!(
            (here.v - last.v).abs() <= room(bounds.acceleration) + 1e-12 * (1.0 + bounds.velocity),
            "{here:?} {profile:?}"
        );
        assert!(
            (here.a - last.a).abs() <= room(bounds.jerk) + 1e-12 * (1.0 + bounds.acceleration),
            "{here:?} {profile:?}"
        );
        (last, at) = (here, x);
    }
    // Slower by k it is the same motion: velocity by k, acceleration by its square.
    let (k, x) = (1.0 + random.unit(), random.unit() * 0.999 * t);
    let slow = profile.clone().stretched_to(k * t).expect("a longer duration");
    let (there, here) = (slow.at(k * x), profile.at(x));
    assert_eq!(slow.duration(), k * t);
    assert!(
        (there.s - here.s).abs() <= 1e-9 * d + 1e-15
            && (there.v * k - here.v).abs() <= 1e-9 * here.v.max(1e-3 * bounds.velocity)
    );
}

/// Every kind by its limits, with the duration of its closed form.
fn sweep(first: u64, count: u64, mut kind: impl FnMut(f64, JerkLimits, &mut Inputs)) {
    for seed in first..first + count {
        let mut random = Inputs::seeded(seed);
        let (distance, limits) = (random.distance(), random.limits());
        kind(distance, limits, &mut random);
    }
}

fn rectangular_profiles(count: u64) {
    sweep(0, count, |d, JerkLimits { velocity, .. }, random| {
        let bounds = Bounds { velocity, acceleration: f64::INFINITY, jerk: f64::INFINITY };
        check(&Rectangular::new(d, velocity).expect("in range"), &bounds, d / velocity, random);
    });
}

#[test]
fn rectangular() {
    rectangular_profiles(SHARE);
}

fn trapezoidal_profiles(count: u64) {
    sweep(1 << 32, count, |d, JerkLimits { velocity, acceleration, .. }, random| {
        let bounds = Bounds { velocity, acceleration, jerk: f64::INFINITY };
        let profile = Trapezoid::new(d, ProfileLimits { velocity, acceleration }).expect("in range");
        let reached = d >= velocity * velocity / acceleration;
        let expected =
            if reached { d / velocity + velocity / acceleration } else { 2.0 * (d / acceleration).sqrt() };
        check(&profile, &bounds, expected, random);
    });
}

#[test]
fn trapezoidal() {
    trapezoidal_profiles(SHARE);
}

fn triangular_profiles(count: u64) {
    sweep(2 << 32, count, |d, JerkLimits { acceleration, .. }, random| {
        let bounds = Bounds { velocity: (d * acceleration).sqrt(), acceleration, jerk: f64::INFINITY };
        let profile = Trapezoid::triangular(d, acceleration).expect("in range");
        check(&profile, &bounds, 2.0 * (d / acceleration).sqrt(), random);
    });
}

#[test]
fn triangular() {
    triangular_profiles(SHARE);
}

fn cubic_profiles(count: u64) {
    sweep(3 << 32, count, |d, JerkLimits { velocity, acceleration, .. }, random| {
        let bounds = Bounds { velocity, acceleration, jerk: f64::INFINITY };
        let profile = Cubic::new(d, ProfileLimits { velocity, acceleration }).expect("in range");
        let expected = (1.5 * d / velocity).max((6.0 * d / acceleration).sqrt());
        check(&profile, &bounds, expected, random);
    });
}

#[test]
fn cubic() {
    cubic_profiles(SHARE);
}

fn quintic_profiles(count: u64) {
    sweep(4 << 32, count, |d, limits, random| {
        let JerkLimits { velocity, acceleration, jerk } = limits;
        let profile = Quintic::new(d, limits).expect("in range");
        let by_acceleration = (10.0 * d / (acceleration * 3.0_f64.sqrt())).sqrt();
        let expected = (15.0 * d / (8.0 * velocity)).max(by_acceleration).max((60.0 * d / jerk).cbrt());
        check(&profile, &Bounds { velocity, acceleration, jerk }, expected, random);
    });
}

#[test]
fn quintic() {
    quintic_profiles(SHARE);
}

fn seven_phase_profiles(count: u64) {
    sweep(5 << 32, count, |d, limits, random| {
        let JerkLimits { velocity: v, acceleration: a, jerk: j } = limits;
        let ramp = if v >= a * a / j { v / a + a / j } else { 2.0 * (v / j).sqrt() };
        let expected = if d == 0.0 {
            0.0
        } else if d >= v * ramp {
            d / v + ramp
        } else if d >= 2.0 * a * a * a / (j * j) {
            a / j + ((a / j).powi(2) + 4.0 * d / a).sqrt()
        } else {
            4.0 * (d / (2.0 * j)).cbrt()
        };
        let profile = SevenPhase::new(d, limits).expect("in range");
        check(&profile, &Bounds { velocity: v, acceleration: a, jerk: j }, expected, random);
    });
}

#[test]
fn seven_phase() {
    seven_phase_profiles(SHARE);
}

/// A duration in whole steps is the next one, and no limit is broken by it.
fn profiles_in_whole_steps(count: u64) {
    sweep(6 << 32, count, |d, JerkLimits { velocity, acceleration, .. }, random| {
        let fast = Trapezoid::new(d, ProfileLimits { velocity, acceleration }).expect("in range");
        let dt = random.sized(1e-4, 1e-1);
        let whole = fast.in_whole_steps(dt);
        let steps = whole.duration() / dt;
        assert!(whole.duration() >= fast.duration() && whole.duration() < fast.duration() + dt);
        assert!((steps - steps.round()).abs() <= 1e-8 * steps.max(1.0), "{steps}");
        let bounds = Bounds { velocity, acceleration, jerk: f64::INFINITY };
        check(&whole, &bounds, whole.duration(), random);
    });
}

#[test]
fn whole_steps() {
    profiles_in_whole_steps(SHARE);
}

mod whole {
    use super::{
        WHOLE, cubic_profiles, profiles_in_whole_steps, quintic_profiles, rectangular_profiles,
        seven_phase_profiles, trapezoidal_profiles, triangular_profiles,
    };

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn rectangular() {
        rectangular_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn trapezoidal() {
        trapezoidal_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn triangular() {
        triangular_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn cubic() {
        cubic_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn quintic() {
        quintic_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn seven_phase() {
        seven_phase_profiles(WHOLE);
    }

    #[test]
    #[ignore = "takes a minute: `just sweep-profiles`"]
    fn whole_steps() {
        profiles_in_whole_steps(WHOLE);
    }
}
