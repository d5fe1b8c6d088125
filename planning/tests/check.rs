//! What is said to be clear is clear.

use mrroc::random::Random;
use mrroc_planning::{PlanError, Planner};

use super::cells::{around_a_box, stopping, two_arms};

#[test]
fn a_path_keeps_its_margin_everywhere() {
    for (seed, arms, build) in [(1, 1, around_a_box as fn() -> _), (2, 2, two_arms)] {
        let mut clearance = build().build(stopping()).expect("a clearance");
        let mut planner = Planner::new(clearance.clone()).expect("a planner").with_effort(20_000);
        let mut random = Random::seeded(seed);
        let mut planned = 0;
        while planned < 25 {
            // The shoulders upwards.
            let mut draw = || -> Vec<f64> {
                (0..6 * arms)
                    .map(|j| if j % 6 == 1 { random.between(-2.5, -0.5) } else { random.within(2.0) })
                    .collect()
            };
            let (start, goal) = (draw(), draw());
            let points = match planner.find(&start, std::slice::from_ref(&goal)) {
                Ok(points) => points,
                Err(
                    PlanError::StartNotClear(_) | PlanError::GoalNotClear(_) | PlanError::NotFound { .. },
                ) => continue,
                Err(error) => panic!("{error}"),
            };
            planned += 1;
            assert_eq!((&points[0], &points[points.len() - 1]), (&start, &goal));
            for leg in points.windows(2) {
                for k in 0..=50 {
                    let at = |(a, b): (&f64, &f64)| a + (b - a) * f64::from(k) / 50.0;
                    let q: Vec<f64> = leg[0].iter().zip(&leg[1]).map(at).collect();
                    let nearest = clearance.nearest_at(&q.chunks(6).collect::<Vec<_>>()).expect("a posture");
                    // Links of one robot must only not meet; `nearest_at` tells of them where they overlap.
                    let is_own = nearest.sides[0].robot == nearest.sides[1].robot;
                    assert!(!is_own && nearest.distance >= 0.02, "seed {seed}, plan {planned}: {nearest}");
                }
            }
        }
    }
}
