//! What is said to be clear is clear.

use mrroc::random::Random;
use mrroc_planning::Planner;

use super::cells::{around_a_box, seven_axes, stopping, two_arms};

#[test]
fn a_path_keeps_its_margin_everywhere() {
    for (seed, build) in [(1, around_a_box as fn() -> _), (2, two_arms)] {
        let mut clearance = build().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance.clone()).expect("a planner").with_seed(seed);
        let n = if seed == 1 { 6 } else { 12 };
        let mut random = Random::seeded(seed);
        let mut planned = 0;
        for trial in 0..400 {
            let draw = |random: &mut Random| -> Vec<f64> { (0..n).map(|_| random.within(2.5)).collect() };
            let (start, goal) = (draw(&mut random), draw(&mut random));
            let found = planner.find(&start, &[goal.clone()]);
            if trial < 30 { if let Err(error) = &found { println!("{error}"); } }
            let Ok(points) = found else { continue };
            planned += 1;
            assert_eq!((&points[0], &points[points.len() - 1]), (&start, &goal));
            for leg in points.windows(2) {
                for k in 0..=50 {
                    let q: Vec<f64> =
                        leg[0].iter().zip(&leg[1]).map(|(a, b)| a + (b - a) * f64::from(k) / 50.0).collect();
                    let robots: Vec<&[f64]> = q.chunks(6).collect();
                    let nearest = clearance.nearest_at(&robots).expect("a posture");
                    assert!(nearest.distance >= 0.02 - 1e-9 || nearest.sides[0].robot == nearest.sides[1].robot, "seed {seed}, trial {trial}: {nearest}");
                }
            }
            if planned == 25 {
                break;
            }
        }
        assert!(planned >= 20, "{planned}");
    }
    drop(seven_axes(mrroc::pose::Pose::identity()));
}
