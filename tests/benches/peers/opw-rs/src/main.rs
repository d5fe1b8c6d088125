//! rs-opw-kinematics on the arm of ortho_parallel.urdf; see ../README.md.

use std::hint::black_box;
use std::time::Instant;

use rs_opw_kinematics::kinematic_traits::Kinematics;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

const LOWER: [f64; 6] = [-3.1416, -1.7453, -1.0472, -3.4907, -2.0944, -6.9813];
const UPPER: [f64; 6] = [3.1416, 1.9199, 1.1345, 3.4907, 2.0944, 6.9813];
const POSITIONS: usize = 1000;

struct SplitMix64(u64);

impl SplitMix64 {
    fn between(&mut self, lower: f64, upper: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        lower + (upper - lower) * (((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// Prints the mean time of a call: of each window of positions in a row the least of all rounds counts.
fn time(what: &str, mut call: impl FnMut(usize)) {
    const WINDOW: usize = 100;
    let mut best = [f64::INFINITY; POSITIONS / WINDOW];
    for _ in 0..200 {
        for (window, best) in best.iter_mut().enumerate() {
            let start = Instant::now();
            (window * WINDOW..(window + 1) * WINDOW).for_each(&mut call);
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    println!("{what} {:.1}", best.iter().sum::<f64>() / POSITIONS as f64 * 1e9);
}

fn main() {
    let robot = OPWKinematics::new(Parameters::irb2400_10());
    let mut random = SplitMix64(2014);
    let mut sum = [0.0; 3];
    let samples: Vec<_> = (0..POSITIONS)
        .map(|_| {
            let q: [f64; 6] = std::array::from_fn(|i| random.between(LOWER[i], UPPER[i]));
            let near: [f64; 6] = std::array::from_fn(|i| q[i] + random.between(-0.01, 0.01));
            let pose = robot.forward(&q);
            for (sum, at) in sum.iter_mut().zip(pose.translation.to_array()) {
                *sum += at;
            }
            (q, pose, near)
        })
        .collect();
    println!("sum {:.9} {:.9} {:.9}", sum[0], sum[1], sum[2]);
    time("forward", |i| {
        black_box(robot.forward(black_box(&samples[i].0)));
    });
    time("inverse_all", |i| {
        black_box(robot.inverse(black_box(&samples[i].1)));
    });
    time("inverse_continuing", |i| {
        black_box(robot.inverse_continuing(black_box(&samples[i].1), black_box(&samples[i].2)));
    });
    let solved = samples.iter().filter(|(_, pose, near)| !robot.inverse_continuing(pose, near).is_empty()).count();
    println!("solved inverse_continuing {:.1}", solved as f64 / POSITIONS as f64 * 100.0);
}
