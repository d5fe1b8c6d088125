//! What is said to be clear is clear.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc_planning::{PlanError, Planner};
use mrroc_robots::clearance::{Capsule, Clearance, Link, Motion, Obstacle, Outline};
use mrroc_robots::{Serial, SerialOutline, Six};
use nalgebra::Vector3;

use super::cells::{around_a_box, six_axes, stopping, two_arms};

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

/// An arm that is no chain to the planner, and that cannot stand where its first joint is in the middle of its range.
struct Folded(SerialOutline<6>);

impl Outline for Folded {
    type Robot = Serial<6>;

    fn robot(&self) -> &Serial<6> {
        self.0.robot()
    }

    fn links(&self) -> Vec<Link> {
        self.0.links()
    }

    fn capsules(&self, q: &Six, visit: &mut dyn FnMut(Capsule)) {
        if q[0].abs() > 1e-6 {
            self.0.capsules(q, visit);
        }
    }

    fn motions(&self, q: &Six, distances: &Six, visit: &mut dyn FnMut(Motion)) {
        self.0.motions(q, distances, visit);
    }

    fn flange_motions(&self) -> u32 {
        self.0.flange_motions()
    }
}

#[test]
fn an_arm_that_cannot_stand_in_the_middle_of_its_ranges_is_seen_where_it_is() {
    let ball = Obstacle::ball(Vector3::new(-0.5, 0.1, 0.4), 0.35);
    let builder = Clearance::with_margin(0.02).robot("arm", Folded(six_axes(Pose::identity())));
    let builder = builder.expect("an arm").obstacle("ball", ball).expect("a ball").ignore_own("arm");
    let mut clearance = builder.build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance.clone()).expect("a planner");
    let mut random = Random::seeded(3);
    let mut seen = [0; 2];
    for _ in 0..2000 {
        let q: Vec<f64> = (0..6).map(|_| random.within(2.5)).collect();
        let distance = clearance.nearest_at(&[&q]).expect("a posture").distance;
        let is_clear = planner.find_first(&q, std::slice::from_ref(&q)).is_ok();
        // Balls stand out of the capsules by less than 3 mm.
        if distance < 0.02 {
            assert!(!is_clear, "{q:?}: {distance}");
            seen[0] += 1;
        } else if distance > 0.0231 {
            assert!(is_clear, "{q:?}: {distance}");
            seen[1] += 1;
        }
    }
    assert!(seen.iter().all(|seen| *seen > 200), "{seen:?}");
}
