//! How well a base follows a path, by where it truly is.

use mrroc::prelude::Robot as _;
use mrroc::random::Random;
use mrroc_wheels::generators::Follower;
use mrroc_wheels::simulation::{Chassis, Ground};
use mrroc_wheels::{DiffDrive, Path, Planar, Two};
use nalgebra::Vector2;

use crate::usage::bench::{LIMITS, followed};

/// Around a room of a metre, and back to its start: 5 m with eleven corners.
fn tour() -> Path {
    let places = [
        [0.0, 0.0],
        [0.9, 0.0],
        [0.9, 0.4],
        [0.5, 0.5],
        [0.3, 0.2],
        [0.1, 0.4],
        [0.1, 0.8],
        [0.9, 0.9],
        [0.9, 0.6],
        [0.3, 0.6],
        [0.0, 0.7],
        [0.0, 0.3],
    ];
    Path::through(&places.map(Vector2::from), 0.03).expect("a path")
}

/// How far the places are off the path: root mean square, and the largest \[m\].
fn off(path: &Path, trace: &[Planar]) -> (f64, f64) {
    let points: Vec<Vector2<f64>> =
        (0..=20_000).map(|i| path.at(path.length() * f64::from(i) / 2e4).pose.at()).collect();
    let near = |at: &Planar| points.iter().map(|on| (on - at.at()).norm()).fold(f64::INFINITY, f64::min);
    let all: Vec<f64> = trace.iter().step_by(5).map(near).collect();
    let sum: f64 = all.iter().map(|off| off * off).sum();
    ((sum / all.len() as f64).sqrt(), all.iter().copied().fold(0.0, f64::max))
}

/// What must drag so that the tyres slip by this share at half a metre a second: the force of the tyres, inverted.
fn dragging(slip: f64) -> f64 {
    let x = slip / 0.05;
    let each = 0.9 * 0.45 * Chassis::MASS * 9.80665 * x / (1.0 + x * x).sqrt();
    2.0 * each - 0.05 * 0.1 * Chassis::MASS * 9.80665
}

/// How far a base goes for a metre that its wheels turn, as a share, on a metre straight ahead measured with a tape.
fn calibrated(ground: &Ground) -> f64 {
    let path = Path::through(&[Vector2::zeros(), Vector2::new(1.0, 0.0)], 0.03).expect("a path");
    let gone = followed(path, ground.clone(), 1.0, 0).last().map_or(0.0, |end| end.x);
    assert!(gone > 0.9 && gone < 1.01, "{gone}");
    gone
}

#[test]
fn a_base_is_at_most_10_mm_off_its_path_at_half_a_metre_a_second_with_2_percent_of_slip() {
    let path = tour();
    let slippery = Ground { drag: dragging(0.02), ..Ground::default() };
    let scale = calibrated(&slippery);
    // Standing still it slips less: the mean of a metre from rest to rest is a little less than 2 %.
    assert!((1.0 - scale - 0.02).abs() < 2e-3, "{scale}");
    for seed in 0..3 {
        let (rms, most) = off(&path, &followed(tour(), Ground::default(), 1.0, seed));
        println!("no drag: {:.2} mm rms, {:.2} mm at most", 1e3 * rms, 1e3 * most);
        assert!(rms < 0.005, "{rms}");
        let (rms, most) = off(&path, &followed(tour(), slippery.clone(), scale, seed));
        println!("2 % of slip: {:.2} mm rms, {:.2} mm at most", 1e3 * rms, 1e3 * most);
        assert!(rms < 0.010, "{rms}");
        // Who does not know the slip is off by its share of how far the place is from the start, up to 1.3 m.
        let (rms, most) = off(&path, &followed(tour(), slippery.clone(), 1.0, seed));
        println!("2 % of slip, not calibrated: {:.2} mm rms, {:.2} mm at most", 1e3 * rms, 1e3 * most);
        assert!(most < 0.02 * 1.3 + 0.006, "{most}");
    }
}

#[test]
fn whatever_is_measured_no_demand_breaks_a_limit() {
    let mut chance = Random::seeded(11);
    for _ in 0..20 {
        let mut follower = Follower::on(tour(), LIMITS, 1.5);
        follower.begin(Two::new(3.0, -2.0)).expect("limits");
        let (dt, limits) = (0.002, *DiffDrive::new().limits());
        let (mut last, mut speed) = (Two::new(3.0, -2.0), Two::zeros());
        let mut fastest = 0.0_f64;
        loop {
            let at = *follower.reference();
            let jump = 0.02;
            let seen = Planar {
                x: at.x + chance.within(jump),
                y: at.y + chance.within(jump),
                heading: at.heading + chance.within(0.5),
            };
            let Some(next) = follower.advance(Some(&seen), dt).expect("not too far off") else { break };
            let now = (next - last) / dt;
            assert!(now.amax() <= 0.9 * limits.velocity[0], "{now}");
            assert!(((now - speed) / dt).amax() <= 0.9 * limits.acceleration[0] * (1.0 + 1e-9));
            fastest = fastest.max(now.amax());
            (last, speed) = (next, now);
        }
        assert!(speed.amax() < 0.9 * limits.acceleration[0] * dt, "it ends at rest: {speed}");
        assert!(fastest > 0.5 / DiffDrive::WHEEL, "{fastest}");
    }
}
