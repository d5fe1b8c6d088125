//! Writes `capsules_parry.csv`: distances of the segments of 300 pairs of capsules by parry3d-f64 0.31.1 (an implementation
//! independent of this crate's), GJK on capsules of 1 mm, 1 mm added for each.
//!
//! Not part of the build: `cargo new`, `cargo add parry3d-f64@0.31.1`, this as `src/main.rs`, `cargo run > capsules_parry.csv`.

use parry3d_f64::math::{Pose3, Vec3};
use parry3d_f64::query;
use parry3d_f64::shape::Capsule;

fn main() {
    // A generator of George Marsaglia's (xorshift), so that the rows are the same in every run.
    let mut state = 88_172_645_463_325_252_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    println!("a1x,a1y,a1z,b1x,b1y,b1z,a2x,a2y,a2z,b2x,b2y,b2z,distance");
    for _ in 0..300 {
        let p: [f64; 12] = core::array::from_fn(|_| next());
        let at = |i: usize| Vec3::new(p[i], p[i + 1], p[i + 2]);
        let (one, other) = (Capsule::new(at(0), at(3), 1e-3), Capsule::new(at(6), at(9), 1e-3));
        let place = Pose3::identity();
        let Ok(found) = query::distance(&place, &one, &place, &other) else { continue };
        if found.distance > 0.0 {
            let row = p.map(|x| format!("{x:.17}")).join(",");
            println!("{row},{:.17}", found.distance + 2e-3);
        }
    }
}
