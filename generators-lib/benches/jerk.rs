//! Times of jerk-limited planning: `cargo bench -p mrroc-generators --bench jerk`.

use mrroc_generators::jerk::*;
use nalgebra::SVector;
use std::hint::black_box;
use std::time::Instant;

type Six = SVector<f64, 6>;

/// Least time of ten rounds over all cases [ns].
fn best<T>(name: &str, cases: &[T], mut work: impl FnMut(&T)) {
    let round = |_| {
        let start = Instant::now();
        cases.iter().for_each(&mut work);
        start.elapsed().as_secs_f64() * 1e9 / cases.len() as f64
    };
    println!("{name:<58}{:9.1} ns", (0..10).map(round).fold(f64::INFINITY, f64::min));
}

/// A sequence in -1..1 that does not repeat soon.
fn sequence() -> impl FnMut() -> f64 {
    let mut x = 0.5_f64;
    move || {
        x = (x + 0.618_033_988_749_894_9).fract();
        (x * 97.0).fract() * 2.0 - 1.0
    }
}

fn main() {
    let mut next = sequence();
    let limits =
        JointLimits { velocity: Six::repeat(1.0), acceleration: Six::repeat(4.0), jerk: Six::repeat(20.0) };
    let mut cases = |moving: f64| -> Vec<(JointState<Six>, JointTarget<Six>)> {
        let mut draw = |size: f64| Six::from_fn(|_, _| size * next());
        (0..20_000)
            .map(|_| {
                let start = JointState {
                    position: draw(2.0),
                    velocity: draw(0.6 * moving),
                    acceleration: draw(2.0 * moving),
                };
                (
                    start,
                    JointTarget {
                        position: draw(2.0),
                        velocity: draw(0.6 * moving),
                        acceleration: Six::zeros(),
                    },
                )
            })
            .collect()
    };
    let (rest, moving) = (cases(0.0), cases(1.0));
    for (name, cases) in [("rest to rest", &rest), ("state to velocity", &moving)] {
        best(&format!("plan of 6 axes, {name}"), cases, |(start, target)| {
            let _ = black_box(SynchronisedMove::new(start, target, &limits));
        });
        best(&format!("plan of 1 axis, {name}"), cases, |(start, target)| {
            let from = AxisState {
                position: start.position[0],
                velocity: start.velocity[0],
                acceleration: start.acceleration[0],
            };
            let to =
                AxisTarget { position: target.position[0], velocity: target.velocity[0], acceleration: 0.0 };
            let _ = black_box(AxisPlan::new(&from, &to, &limits.axis(0)));
        });
    }
    let refused = moving.iter().filter(|(s, t)| SynchronisedMove::new(s, t, &limits).is_err()).count();
    println!("{:<58}{refused:9} of {}", "refused", moving.len());
    let motions: Vec<_> =
        moving.iter().take(500).filter_map(|(s, t)| SynchronisedMove::new(s, t, &limits).ok()).collect();
    best("6 axes at an instant", &motions, |motion| {
        black_box(motion.at(black_box(0.37 * motion.duration())));
    });
}
