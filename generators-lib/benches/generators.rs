//! Times of the stepping functions: `cargo bench -p mrroc-generators --bench generators`.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

use mrroc_generators::bspline::*;
use mrroc_generators::feed::{FedPath, FeedLimits};
use mrroc_generators::profile::{ProfileLimits, Trapezoid};
use nalgebra::Vector3;
use std::hint::black_box;
use std::time::Instant;

fn wave(points: u32) -> impl Iterator<Item = Vector3<f64>> {
    (0..points).map(|i| {
        let x = f64::from(i) * 5e-4;
        // A slow recursion-free wave, cheap enough not to be what is measured.
        let y = (x * 60.0).fract() - 0.5;
        Vector3::new(x, 0.02 * y * (1.0 - y * y), 1e-3 * y)
    })
}

fn best(name: &str, count: u32, mut work: impl FnMut()) {
    let ns = (0..5)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e9 / f64::from(count)
        })
        .fold(f64::INFINITY, f64::min);
    println!("{name:<58}{ns:9.1} ns");
}

fn main() {
    let Ok(profile) = Trapezoid::new(1.0, ProfileLimits { velocity: 0.4, acceleration: 1.0 }) else { return };
    let million = 1_000_000;
    best("trapezoid at(t)", million, || {
        for i in 0..million {
            black_box(profile.at(black_box(f64::from(i) * 3e-6)));
        }
    });
    best("points alone", million, || {
        wave(million).for_each(|p| {
            black_box(p);
        })
    });
    let methods = [
        Method::Literal(EndCondition::Natural),
        Method::Interpolating,
        Method::C2,
        Method::FrozenControlPoints,
    ];
    for method in methods {
        let set = SplineSettings { method, corner: 3.0, ..SplineSettings::default() };
        best(&format!("window shift + span evaluation, {method:?}"), million, || {
            let Ok(mut segment) = MovingSegment::new(set) else { return };
            for point in wave(million) {
                if segment.push(point.into()).is_err() {
                    return;
                }
                while let Poll::Span(path) = segment.poll() {
                    black_box(path.span.position(0.4 * path.span.knot_span()));
                }
            }
        });
    }
    let set = SplineSettings { corner: 3.0, ..SplineSettings::default() };
    let ten = 10 * million;
    let start = Instant::now();
    let spans = SpanStream::new(set, wave(ten)).map_or(0, |s| s.flatten().count());
    println!("{:<58}{:9.2} s  ({spans} spans)", "ten million points", start.elapsed().as_secs_f64());
    for (feed, chord_error) in [(0.02, f64::INFINITY), (0.5, 1e-6)] {
        let limits =
            FeedLimits { feed, tangential: 2.0, normal: 2.0, step: 1e-3, chord_error, jerk: f64::INFINITY };
        let Ok(stream) = SpanStream::new(set, wave(20_000)) else { return };
        let Ok(mut path) = FedPath::<_>::new(limits, stream) else { return };
        let (start, mut steps) = (Instant::now(), 0_u32);
        while path.advance(1e-3).is_some() {
            steps += 1;
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / f64::from(steps);
        println!(
            "advance() with planning, feed {feed} m/s, {:6.2} steps a span {ns:20.1} ns",
            f64::from(steps) / 19_999.0
        );
    }
}
