//! Prints what queries of obstacles with many parts take on this machine: time, and memory.
//! Run with `cargo bench -p mrroc-robots --bench obstacles`.

#![expect(clippy::disallowed_methods, reason = "a benchmark measures")]

mod stopwatch;

use std::hint::black_box;
use std::time::Instant;

use mrroc::pose::Pose;
use mrroc_robots::clearance::{Bodies, Capsule, Cloud, HeightField, Obstacle};
use nalgebra::Vector3;
use stopwatch::best_mean;

/// Places at which is asked.
const PLACES: u32 = 4096;

/// Numbers from 0 to 1 that look random and are the same in every run (SplitMix64).
fn part(index: u32, of: u32) -> f64 {
    let mut bits =
        u64::from(index).wrapping_mul(8).wrapping_add(u64::from(of)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Where is asked: in a cube of 2 m edge.
fn place(index: u32) -> Vector3<f64> {
    Vector3::new(part(index, 0), part(index, 1), part(index, 2)) * 2.0 - Vector3::repeat(1.0)
}

/// A link of an arm somewhere.
fn link(index: u32) -> Capsule {
    let a = place(index);
    Capsule::new(a, a + place(index + PLACES) * 0.4, 0.06)
}

/// What a depth camera sees: points on a table, on a ball and on a wall, 2 mm off.
fn seen(index: u32) -> Vector3<f64> {
    let (u, v) = (2.0 * part(index, 3) - 1.0, 2.0 * part(index, 4) - 1.0);
    let off = Vector3::new(part(index, 5), part(index, 6), part(index, 7)) * 0.004 - Vector3::repeat(0.002);
    let surface = match index % 3 {
        0 => Vector3::new(u, v, -0.5),
        1 => Vector3::new(u, 0.9, v),
        _ => {
            let (sine, cosine) = (core::f64::consts::PI * u).sin_cos();
            Vector3::new(cosine * (1.0 - v * v).sqrt(), sine * (1.0 - v * v).sqrt(), v) * 0.3
        }
    };
    surface + off
}

/// Prints nanoseconds of each query of an obstacle: balls of 5 cm, most of them clear, and links of an arm.
fn measure(what: &str, obstacle: &Obstacle, bytes: usize, build: f64) {
    let balls: Vec<_> = (0..PLACES).map(place).collect();
    let links: Vec<_> = (0..PLACES).map(link).collect();
    let (is_clear, touches): (Vec<_>, Vec<_>) =
        balls.iter().partition(|centre| obstacle.ball_clear(centre, 0.05));
    let ask = |balls: &[Vector3<f64>]| {
        let count = balls.len().max(1);
        let of = |call: u32| balls.get(call as usize % count);
        best_mean(30, PLACES, |call| {
            black_box(of(call).is_none_or(|centre| obstacle.ball_clear(black_box(centre), 0.05)));
        })
    };
    let times = [ask(&is_clear), ask(&touches)];
    let near = best_mean(30, PLACES, |call| {
        black_box(obstacle.distance(black_box(&balls[call as usize]), 0.1));
    });
    let gap = best_mean(30, PLACES, |call| {
        black_box(obstacle.gap(black_box(&links[call as usize])));
    });
    let near_links = best_mean(30, PLACES, |call| {
        black_box(obstacle.capsule_clear(black_box(&links[call as usize]), 0.02));
    });
    println!(
        "{what:24} {:8.1} kB, built in {:8.3} ms; ball clear {:6.1} ns, not clear ({:2.0} %) {:6.1} ns, \
         distance up to 0.1 m {near:7.1} ns, link clear of 20 mm {near_links:7.1} ns, \
         gap of a link {gap:7.1} ns",
        bytes as f64 / 1e3,
        1e3 * build,
        times[0],
        100.0 * touches.len() as f64 / f64::from(PLACES),
        times[1],
    );
}

fn built<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let made = make();
    (made, start.elapsed().as_secs_f64())
}

fn main() {
    for exponent in 1..=5 {
        let count = 10_u32.pow(exponent);
        let points: Vec<_> = (0..count).map(seen).collect();
        let (cloud, time) = built(|| Cloud::new(&points, 0.01).expect("points"));
        let bytes = cloud.bytes();
        measure(&format!("cloud, {count} points"), &Obstacle::Cloud(cloud.into()), bytes, time);
    }
    for count in [10, 100, 1000] {
        let capsules: Vec<_> =
            (0..count).map(|k| Capsule::new(seen(k), seen(k) + place(k) * 0.05, 0.02)).collect();
        let (bodies, time) = built(|| Bodies::new(&capsules).expect("capsules"));
        let bytes = bodies.bytes();
        measure(&format!("{count} capsules"), &Obstacle::Bodies(bodies.into()), bytes, time);
    }
    for edge in [10_u32, 100, 1000] {
        let heights = (0..edge * edge).map(|k| 0.1 * part(k, 0) - 0.5).collect();
        let corner = Pose::translation(-1.0, -1.0, 0.0);
        let make =
            || HeightField::new(corner, 2.0 / f64::from(edge), edge as usize, heights).expect("heights");
        let (field, time) = built(make);
        let bytes = field.bytes();
        measure(&format!("{edge} x {edge} heights"), &Obstacle::HeightField(field.into()), bytes, time);
    }
    for (what, obstacle) in [
        ("box", Obstacle::Box { X_WO: Pose::translation(0.1, 0.2, 0.3), half: Vector3::new(0.2, 0.3, 0.4) }),
        (
            "cylinder",
            Obstacle::Cylinder { X_WO: Pose::translation(0.1, 0.2, 0.3), radius: 0.3, half_length: 0.4 },
        ),
    ] {
        measure(what, &obstacle, size_of::<Obstacle>(), 0.0);
    }
}
