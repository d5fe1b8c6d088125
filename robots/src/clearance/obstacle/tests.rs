//! Gaps of obstacles against those of points that are sampled on capsules and obstacles.

use std::sync::Arc;

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

use super::{Bodies, Cloud, HeightField, Obstacle, ObstacleError};
use crate::clearance::Capsule;

#[test]
fn above_a_table_the_lower_end_counts() {
    let capsule = Capsule::new(Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 0.7), 0.1);
    let gap = Obstacle::table(0.2).gap(&capsule);
    assert!((gap.distance - 0.4).abs() < 1e-15);
    assert!((gap.points[0] - Vector3::new(1.0, 0.0, 0.6)).amax() < 1e-15);
    assert!((gap.points[1] - Vector3::new(1.0, 0.0, 0.2)).amax() < 1e-15);
}

proptest! {
    #[test]
    fn the_distance_to_a_box_is_the_least_of_all_points(
        a in proptest::array::uniform3(-2.0..2.0_f64), b in proptest::array::uniform3(-2.0..2.0_f64),
        turn in proptest::array::uniform3(-3.0..3.0_f64),
    ) {
        const N: usize = 2000;
        let half = Vector3::new(0.3, 0.5, 0.2);
        let place = Pose::new(Vector3::new(0.1, -0.2, 0.3), Vector3::from(turn));
        let (a, b) = (Vector3::from(a), Vector3::from(b));
        let distance = Obstacle::Box { X_WO: place, half }.gap(&Capsule::new(a, b, 0.05)).distance + 0.05;
        let sampled = (0..=N).map(|k| {
            let p = a + (b - a) * (k as f64 / N as f64);
            let p = place.inverse() * Point3::from(p);
            // Outside a box, what each coordinate is beyond its face.
            p.coords.zip_map(&half, |x, h| (x.abs() - h).max(0.0)).norm()
        });
        let sampled = sampled.fold(f64::INFINITY, f64::min);
        prop_assert!(distance <= sampled + 1e-12);
        prop_assert!(distance >= sampled - 0.5 * (b - a).norm() / N as f64);
    }
}

/// The least of a function over a segment, of which it is sampled at 2001 points, and how far a point is from a sample.
fn least_along([a, b]: [Vector3<f64>; 2], distance: impl Fn(Vector3<f64>) -> f64) -> (f64, f64) {
    const N: usize = 2000;
    let sampled = (0..=N).map(|k| distance(a + (b - a) * (k as f64 / N as f64)));
    (sampled.fold(f64::INFINITY, f64::min), 0.5 * (b - a).norm() / N as f64)
}

/// Distance of a point from a box along the axes.
fn from_box(p: &Vector3<f64>, low: &Vector3<f64>, high: &Vector3<f64>) -> f64 {
    let beyond = |i: usize| (low[i] - p[i]).max(p[i] - high[i]).max(0.0);
    Vector3::new(beyond(0), beyond(1), beyond(2)).norm()
}

prop_compose! {
    fn within(reach: f64)(p in proptest::array::uniform3(-1.0..1.0_f64)) -> Vector3<f64> {
        Vector3::from(p) * reach
    }
}

prop_compose! {
    fn capsule(reach: f64)(a in within(reach), b in within(reach), is_ball in any::<bool>(), radius in 0.01..0.2_f64) -> Capsule {
        Capsule::new(a, if is_ball { a } else { b }, radius)
    }
}

prop_compose! {
    fn place()(at in within(0.5), turn in within(3.0)) -> Pose {
        Pose::new(at, turn)
    }
}

/// Balls around random points, in two heaps and between them.
fn points() -> impl Strategy<Value = Vec<Vector3<f64>>> {
    let heaps = (within(0.3), any::<bool>()).prop_map(|(p, far)| p + Vector3::x() * f64::from(u8::from(far)));
    proptest::collection::vec(heaps, 1..700)
}

/// A height field of some rows and columns.
fn field() -> impl Strategy<Value = HeightField> {
    (place(), 1..12_usize, 1..12_usize).prop_flat_map(|(place, columns, rows)| {
        proptest::collection::vec(-0.3..0.5_f64, columns * rows)
            .prop_map(move |heights| HeightField::new(place, 0.15, columns, heights).unwrap())
    })
}

/// Obstacles of every kind.
#[allow(non_snake_case)]
fn obstacle() -> impl Strategy<Value = Obstacle> {
    let sizes = || proptest::array::uniform3(0.05..0.5_f64);
    prop_oneof![
        (within(1.0), -0.5..0.5_f64)
            .prop_filter("a direction", |(normal, _)| normal.norm() > 0.1)
            .prop_map(|(normal, height)| Obstacle::HalfSpace { normal: normal.normalize(), height }),
        capsule(1.0).prop_map(Obstacle::Capsule),
        (place(), sizes()).prop_map(|(X_WO, half)| Obstacle::Box { X_WO, half: Vector3::from(half) }),
        (place(), sizes()).prop_map(|(X_WO, [radius, half_length, _])| Obstacle::Cylinder {
            X_WO,
            radius,
            half_length
        }),
        proptest::collection::vec(capsule(1.0), 1..80)
            .prop_map(|capsules| Obstacle::Bodies(Arc::new(Bodies::new(&capsules).unwrap()))),
        (points(), 0.01..0.1_f64)
            .prop_map(|(points, radius)| Obstacle::Cloud(Arc::new(Cloud::new(&points, radius).unwrap()))),
        field().prop_map(|field| Obstacle::HeightField(Arc::new(field))),
    ]
}

proptest! {
    #[test]
    fn the_distance_to_a_cylinder_is_the_least_of_all_points(
        capsule in capsule(2.0), place in place(), radius in 0.05..0.8_f64, half_length in 0.05..0.8_f64,
    ) {
        let gap = Obstacle::Cylinder { X_WO: place, radius, half_length }.gap(&capsule);
        let distance = gap.distance + capsule.radius;
        let (sampled, error) = least_along(capsule.ends, |p| {
            let p = place.inverse() * Point3::from(p);
            // Outside, what it is beyond the shell and beyond the ends.
            (p.x.hypot(p.y) - radius).max(0.0).hypot((p.z.abs() - half_length).max(0.0))
        });
        prop_assert!(distance <= sampled + 1e-12, "{distance} {sampled}");
        prop_assert!(distance >= sampled - error - 1e-12, "{distance} {sampled}");
    }

    #[test]
    fn the_distance_to_bodies_is_that_to_the_nearest_of_them(
        capsules in proptest::collection::vec(capsule(1.0), 1..100), own in capsule(2.0), most in 0.0..0.5_f64,
    ) {
        let bodies = Obstacle::Bodies(Arc::new(Bodies::new(&capsules).unwrap()));
        let least = capsules.iter().map(|other| own.gap(other).distance).fold(f64::INFINITY, f64::min);
        prop_assert!((bodies.gap(&own).distance - least).abs() < 1e-12);
        let ball = |other: &Capsule| Capsule::new(own.ends[0], own.ends[0], 0.0).gap(other).distance;
        let least = capsules.iter().map(ball).fold(f64::INFINITY, f64::min);
        prop_assert!((bodies.distance(&own.ends[0], most) - least.min(most)).abs() < 1e-12);
    }

    #[test]
    fn the_distance_to_a_cloud_is_that_to_the_nearest_of_its_points(
        points in points(), radius in 0.001..0.1_f64, own in capsule(1.5), most in 0.0..0.5_f64,
    ) {
        let cloud = Cloud::new(&points, radius).unwrap();
        prop_assert_eq!(cloud.len(), points.len());
        // Numbers of single precision below 2 are 1.2e-7 apart, and rounded by half of that along each axis.
        let lost = cloud.radius() - radius;
        prop_assert!((0.0..3.0_f64.sqrt() * 6e-8).contains(&lost), "{lost}");
        let to = |p: &Vector3<f64>, own: &Capsule| own.gap(&Capsule::new(*p, *p, radius)).distance;
        let nearest = |own: &Capsule| points.iter().map(|p| to(p, own)).fold(f64::INFINITY, f64::min);
        let gap = cloud.gap(&own);
        prop_assert!(gap.distance <= nearest(&own) + 1e-12);
        prop_assert!(gap.distance >= nearest(&own) - 2.0 * lost - 1e-12);
        prop_assert!((gap.points[0] - gap.points[1]).norm() <= gap.distance.abs() + 1e-9);
        let centre = &own.ends[0];
        let kept = |p: Vector3<f64>| (p - centre).norm() - cloud.radius();
        let least = cloud.points().map(kept).fold(f64::INFINITY, f64::min);
        prop_assert!((cloud.distance(centre, most) - least.min(most)).abs() < 1e-12);
        prop_assert_eq!(cloud.is_clear(centre, least + 1e-9), false);
        prop_assert_eq!(cloud.is_clear(centre, (least - 1e-9).max(0.0)), least > 0.0);
    }

    #[test]
    fn a_thinned_cloud_holds_the_balls_of_all_points(points in points(), cell in 0.01..0.3_f64) {
        let thinned = Cloud::thinned(&points, 0.01, cell).unwrap();
        prop_assert!(thinned.len() <= points.len());
        // No two points of a cell are farther apart than its diagonal.
        prop_assert!(thinned.radius() <= 0.01 + 3.0_f64.sqrt() * cell + 1e-6);
        for point in points {
            let nearest = thinned.points().map(|kept| (kept - point).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest + 0.01 <= thinned.radius() + 1e-12);
        }
    }

    #[test]
    fn the_distance_to_a_height_field_is_that_to_the_nearest_column(field in field(), own in capsule(2.0)) {
        let (sampled, error) = least_along(own.ends, |p| {
            let p = (field.place().inverse() * Point3::from(p)).coords;
            let columns = field.heights().iter().enumerate().map(|(index, height)| {
                let corner = Vector3::new((index % field.columns()) as f64, (index / field.columns()) as f64, 0.0) * 0.15;
                let low = Vector3::new(corner.x, corner.y, f64::NEG_INFINITY);
                from_box(&p, &low, &Vector3::new(corner.x + 0.15, corner.y + 0.15, *height))
            });
            columns.fold(f64::INFINITY, f64::min)
        });
        let distance = field.gap(&own).distance + own.radius;
        prop_assert!(distance <= sampled + 1e-12, "{distance} {sampled}");
        prop_assert!(distance >= sampled - error - 1e-12, "{distance} {sampled}");
    }

    #[test]
    fn all_queries_of_an_obstacle_agree(
        obstacle in obstacle(), centre in within(2.0), own in capsule(2.0), most in 0.0..1.0_f64,
    ) {
        prop_assert!(obstacle.is_valid());
        let gap = obstacle.gap(&Capsule::new(centre, centre, 0.1));
        let distance = gap.distance + 0.1;
        prop_assert!((obstacle.distance(&centre, f64::INFINITY) - 0.1 - gap.distance).abs() < 1e-12);
        prop_assert!((obstacle.distance(&centre, most) - distance.min(most)).abs() < 1e-12);
        prop_assert_eq!(obstacle.ball_clear(&centre, distance.max(0.0) + 1e-9), false);
        if distance > 0.0 {
            prop_assert!(obstacle.ball_clear(&centre, (distance - 1e-9).max(0.0)));
        }
        let gap_of_own = obstacle.gap(&own).distance;
        prop_assert_eq!(obstacle.gap_below(&own, gap_of_own - 1e-9), None);
        let found = obstacle.gap_below(&own, gap_of_own + 1e-9).map(|gap| gap.distance);
        prop_assert!(found.is_some_and(|found| (found - gap_of_own).abs() < 1e-12), "{found:?} {gap_of_own}");
        prop_assert!(!obstacle.capsule_clear(&own, gap_of_own.max(0.0) + 1e-9));
        if gap_of_own > 0.0 {
            prop_assert!(obstacle.capsule_clear(&own, (gap_of_own - 1e-9).max(0.0)));
        }
        if let Some((low, high)) = obstacle.bounds() {
            // The nearest point of the obstacle lies in its bounds, which therefore are no farther away.
            prop_assert!(distance <= 0.0 || from_box(&gap.points[1], &low, &high) < 1e-9);
            prop_assert!(from_box(&centre, &low, &high) <= distance.max(0.0) + 1e-9);
        }
    }

    #[test]
    fn the_bounds_of_an_obstacle_with_ends_are_touched_on_all_six_sides(obstacle in obstacle()) {
        let Some((low, high)) = obstacle.bounds() else { return Ok(()) };
        for axis in 0..3 {
            for (side, along) in [(low[axis], -1.0), (high[axis], 1.0)] {
                if !side.is_finite() || matches!(obstacle, Obstacle::HeightField(_)) {
                    continue;
                }
                // From far beyond a side, a body that touches it is no farther away than from the side, but for its curvature.
                let mut far = (low + high) * 0.5;
                far[axis] = side + along * 1e4;
                let distance = obstacle.distance(&far, f64::INFINITY);
                prop_assert!((distance - 1e4).abs() < 1e-3, "{distance}");
            }
        }
    }
}

#[test]
fn cylinders_in_known_positions_have_the_distances_of_geometry() {
    let drum = Obstacle::Cylinder { X_WO: Pose::translation(1.0, 0.0, 0.0), radius: 0.5, half_length: 1.0 };
    let at = Vector3::new;
    let cases = [
        // Beside it, above it, and 3, 4, 5 from its edge.
        ([at(3.0, 0.0, -2.0), at(3.0, 0.0, 2.0)], 1.5),
        ([at(1.2, 0.1, 3.0), at(1.2, 0.1, 4.0)], 2.0),
        ([at(1.0 + 0.5 + 3.0, 0.0, 5.0), at(9.0, 0.0, 5.0)], 5.0),
        // Across above it, through it, and one that goes by at a right angle.
        ([at(-4.0, 0.3, 1.25), at(5.0, 0.3, 1.25)], 0.25),
        ([at(-4.0, 0.3, 0.25), at(5.0, 0.3, 0.25)], 0.0),
        ([at(-4.0, 0.75, 0.25), at(5.0, 0.75, 0.25)], 0.25),
    ];
    for (ends, expected) in cases {
        let distance = drum.gap(&Capsule::new(ends[0], ends[1], 0.1)).distance;
        assert!((distance - (expected - 0.1)).abs() < 1e-12, "{ends:?}: {distance}");
    }
}

#[test]
fn numbers_that_make_no_obstacle_are_refused_by_what_is_wrong_with_them() {
    let p = Vector3::new(1.0, 2.0, 3.0);
    assert_eq!(Cloud::new(&[], 0.01), Err(ObstacleError::EmptyCloud));
    assert_eq!(Cloud::thinned(&[], 0.01, 0.1), Err(ObstacleError::EmptyCloud));
    for bad in [f64::NAN, f64::INFINITY, 1e39] {
        let error = Cloud::new(&[p, Vector3::new(0.0, bad, 0.0)], 0.01).unwrap_err();
        assert!(error.to_string().starts_with("point 1 of a cloud is (0.0, "), "{error}");
    }
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Cloud::new(&[p], radius), Err(ObstacleError::BadRadius { .. })));
        assert!(matches!(Cloud::thinned(&[p], 0.01, radius), Err(ObstacleError::BadCell { .. })));
        assert!(matches!(
            HeightField::new(Pose::identity(), radius, 1, vec![0.0]),
            Err(ObstacleError::BadCell { .. })
        ));
    }
    let many = vec![p; Cloud::MOST_POINTS + 1];
    assert!(matches!(Cloud::new(&many, 0.01), Err(ObstacleError::TooManyPoints { .. })));
    assert_eq!(Cloud::thinned(&many, 0.01, 0.1).unwrap().len(), 1);

    assert_eq!(Bodies::new(&[]), Err(ObstacleError::NoCapsules));
    let capsules = [Capsule::new(p, p, 0.1), Capsule::new(p, p, 0.0)];
    assert_eq!(Bodies::new(&capsules), Err(ObstacleError::BadCapsule { index: 1 }));

    let field = |columns, heights| HeightField::new(Pose::identity(), 0.1, columns, heights);
    for (columns, heights) in [(1, vec![]), (0, vec![1.0]), (2, vec![1.0, 2.0, 3.0])] {
        assert!(matches!(field(columns, heights), Err(ObstacleError::BadGrid { .. })));
    }
    let error = field(2, vec![0.0, 0.0, 0.0, f64::NAN]).unwrap_err();
    assert_eq!(error.to_string(), "the height in column 1 of row 1 is NaN m: it must be finite");
    assert!(matches!(field(1, vec![f64::NEG_INFINITY]), Err(ObstacleError::BadHeight { .. })));
    let nowhere = Pose::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(HeightField::new(nowhere, 0.1, 1, vec![0.0]), Err(ObstacleError::BadPose));

    for (radius, half_length) in [(0.0, 1.0), (1.0, 0.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
        assert!(!Obstacle::Cylinder { X_WO: Pose::identity(), radius, half_length }.is_valid());
    }
    assert!(!Obstacle::Cylinder { X_WO: nowhere, radius: 1.0, half_length: 1.0 }.is_valid());
}
