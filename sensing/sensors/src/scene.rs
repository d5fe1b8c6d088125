//! What sensors see of a world: convex solids that move.

use mrroc::pose::{AngleAxis, Pose};
use nalgebra::{Translation3, Vector2, Vector3};

/// A convex solid, and how it moves.
#[derive(Clone, Copy, Debug)]
pub struct Solid<'h> {
    /// Points whose convex hull it is \[m, in its frame B\], at most [`Solid::POINTS`].
    pub hull: &'h [Vector3<f64>],
    /// `X_WB`, at the scene's time.
    pub pose: Pose,
    /// Velocity of the origin of B [m/s, world].
    pub velocity: Vector3<f64>,
    /// [rad/s, world].
    pub angular_velocity: Vector3<f64>,
    /// How much light it scatters, in that of white paper: 0 to 1.
    pub reflectance: f64,
}

/// A world with solids in it, at its time.
pub trait Scene {
    /// \[s\].
    fn now(&self) -> f64;

    /// Visits every solid that is in it.
    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>));
}

impl Solid<'_> {
    /// The most points of a hull.
    pub const POINTS: usize = 64;

    /// Where it was `before` \[s\] ago, a short time.
    #[must_use]
    pub fn pose_before(&self, before: f64) -> Pose {
        let turn = AngleAxis(self.angular_velocity * -before).rotation();
        let place = self.pose.translation.vector - self.velocity * before;
        Pose::from_parts(Translation3::from(place), turn * self.pose.rotation)
    }

    /// The share of a round beam that it covers, 0 to 1, where it was `before` \[s\] ago. The beam of this radius \[m\] runs along z
    /// of its frame L, at `X_WL`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn covers(&self, X_WL: &Pose, radius: f64, before: f64) -> f64 {
        if self.is_beside(X_WL, radius, before) { 0.0 } else { self.shadow(X_WL, radius, before) }
    }

    /// The same, computed from the outline of its shadow.
    #[allow(non_snake_case)]
    fn shadow(&self, X_WL: &Pose, radius: f64, before: f64) -> f64 {
        let X_LB = X_WL.inv_mul(&self.pose_before(before));
        let mut points = [Vector2::zeros(); Self::POINTS];
        let count = self.hull.len().min(Self::POINTS);
        for (projected, point) in points.iter_mut().zip(self.hull) {
            *projected = (X_LB.translation.vector + X_LB.rotation * point).xy();
        }
        let points = &mut points[..count];
        // All of its points lie on one side of the beam.
        let far = |side: fn(&Vector2<f64>) -> f64| points.iter().all(|point| side(point) >= radius);
        if count < 3 || far(|p| p.x) || far(|p| -p.x) || far(|p| p.y) || far(|p| -p.y) {
            return 0.0;
        }
        let mut outline = [Vector2::zeros(); 2 * Self::POINTS];
        let corners = hull(points, &mut outline);
        let outline = &outline[..corners];
        let edges = outline.iter().zip(outline.iter().cycle().skip(1)).take(corners);
        let area: f64 = edges.map(|(a, b)| sector(a, b, radius)).sum();
        (area / (core::f64::consts::PI * radius * radius)).clamp(0.0, 1.0)
    }

    /// Whether a ball about the origin of B that holds the hull lies on one side of a beam: most solids are far away, and this is cheap.
    #[allow(non_snake_case)]
    fn is_beside(&self, X_WL: &Pose, radius: f64, before: f64) -> bool {
        let ball = self.hull.iter().map(Vector3::norm_squared).fold(0.0, f64::max).sqrt();
        let place = self.pose.translation.vector - self.velocity * before - X_WL.translation.vector;
        let off = X_WL.rotation.inverse_transform_vector(&place).xy().abs();
        // A nanometre for round-off: nothing that the beam may touch is beside it.
        off.max() >= radius + ball + 1e-9
    }

    /// How far a thin ray comes to it \[m\], where it was `before` \[s\] ago: from the origin of its frame L, at `X_WL`, along z. `None`
    /// of one that it passes by.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn meets(&self, X_WL: &Pose, before: f64) -> Option<f64> {
        let X_LB = X_WL.inv_mul(&self.pose_before(before));
        let mut points = [Vector3::zeros(); Self::POINTS];
        let count = self.hull.len().min(Self::POINTS);
        for (moved, point) in points.iter_mut().zip(self.hull) {
            *moved = X_LB.translation.vector + X_LB.rotation * point;
        }
        let mut nearest: Option<f64> = None;
        // By Caratheodory's theorem the nearest point of the hull on the ray lies in a triangle of three of its points.
        for (i, a) in points[..count].iter().enumerate() {
            for (j, b) in points[..i].iter().enumerate() {
                for c in &points[..j] {
                    let met = through(a, b, c).filter(|distance| *distance >= 0.0);
                    nearest = [nearest, met].into_iter().flatten().reduce(f64::min);
                }
            }
        }
        nearest
    }
}

/// The area of a disc of this radius about 0 that lies in the triangle 0, a, b; negative where that is passed clockwise.
fn sector(a: &Vector2<f64>, b: &Vector2<f64>, radius: f64) -> f64 {
    let square = radius * radius;
    let turn = |a: &Vector2<f64>, b: &Vector2<f64>| a.perp(b).atan2(a.dot(b));
    let edge = b - a;
    // |a + t edge|^2 = radius^2.
    let (p, q, r) = (edge.norm_squared(), a.dot(&edge), a.norm_squared() - square);
    let discriminant = q * q - p * r;
    if p == 0.0 || discriminant <= 0.0 {
        return 0.5 * square * turn(a, b);
    }
    let root = discriminant.sqrt();
    let (enter, leave) = ((-q - root) / p, (-q + root) / p);
    if leave <= 0.0 || enter >= 1.0 {
        return 0.5 * square * turn(a, b);
    }
    let (from, to) = (a + edge * enter.max(0.0), a + edge * leave.min(1.0));
    let before = if enter > 0.0 { turn(a, &from) } else { 0.0 };
    let after = if leave < 1.0 { turn(&to, b) } else { 0.0 };
    0.5 * (square * (before + after) + from.perp(&to))
}

/// The corners of the convex hull of points, anticlockwise; how many (Andrew's monotone chain, 1979).
fn hull(points: &mut [Vector2<f64>], out: &mut [Vector2<f64>; 2 * Solid::POINTS]) -> usize {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut count = 0;
    let mut add = |point: &Vector2<f64>, keep: usize, count: &mut usize| {
        while *count > keep && (out[*count - 1] - out[*count - 2]).perp(&(point - out[*count - 1])) <= 0.0 {
            *count -= 1;
        }
        out[*count] = *point;
        *count += 1;
    };
    points.iter().for_each(|point| add(point, 1, &mut count));
    let keep = count;
    points.iter().rev().skip(1).for_each(|point| add(point, keep, &mut count));
    count - 1
}

/// Where the z axis passes through a triangle.
fn through(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Option<f64> {
    let (p, q) = ((b - a).xy(), (c - a).xy());
    let area = p.perp(&q);
    if area == 0.0 {
        return None;
    }
    let to = -a.xy();
    let (s, t) = (to.perp(&q) / area, p.perp(&to) / area);
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| a.z + s * (b.z - a.z) + t * (c.z - a.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn cube(half: f64) -> Vec<Vector3<f64>> {
        let sides = [-half, half];
        sides
            .iter()
            .flat_map(|&x| sides.iter().flat_map(move |&y| sides.map(|z| Vector3::new(x, y, z))))
            .collect()
    }

    fn solid(hull: &[Vector3<f64>], pose: Pose) -> Solid<'_> {
        Solid { hull, pose, velocity: Vector3::zeros(), angular_velocity: Vector3::zeros(), reflectance: 1.0 }
    }

    #[test]
    fn a_straight_edge_covers_the_segment_of_the_disc_that_geometry_gives() {
        let hull = cube(0.05);
        for i in 0..=20 {
            // The edge at d from the middle of the beam: r^2 acos(d/r) - d sqrt(r^2 - d^2) is left open.
            let d = -1.0 + 0.1 * f64::from(i);
            let covered = solid(&hull, Pose::translation(d * 0.0025 - 0.05, 0.0, 0.3)).covers(
                &Pose::identity(),
                0.0025,
                0.0,
            );
            let open = (d.acos() - d * (1.0 - d * d).max(0.0).sqrt()) / PI;
            assert!((covered - (1.0 - open)).abs() < 1e-9, "{d}: {covered}");
        }
    }

    #[test]
    fn a_solid_whose_ball_is_beside_the_beam_has_no_shadow_in_it() {
        let mut random = mrroc::random::Noise::seeded(7);
        let (hull, radius) = (cube(0.03), 0.0025);
        let (mut beside, mut covering) = (0, 0);
        for _ in 0..20_000 {
            let mut vector = |size: f64| Vector3::from_fn(|_, _| random.between(-size, size));
            let place = vector(0.09);
            let pose = Pose::translation(place.x, place.y, place.z) * Pose::rotation(vector(2.0));
            let beam = Pose::rotation(vector(2.0));
            let moving = Solid { velocity: vector(0.2), angular_velocity: vector(1.0), ..solid(&hull, pose) };
            let shadow = moving.shadow(&beam, radius, 5e-3);
            let is_beside = moving.is_beside(&beam, radius, 5e-3);
            assert!(!is_beside || shadow == 0.0, "{place}: {shadow}");
            beside += i32::from(is_beside);
            covering += i32::from(shadow > 0.0);
        }
        // Both happen, and most that cover nothing are known to be beside it.
        assert!(covering > 2000 && beside > 6000, "{covering} cover the beam, {beside} are beside it");
    }

    #[test]
    fn a_corner_covers_a_quarter_and_a_thin_bar_in_the_beam_its_own_area() {
        let hull = cube(0.05);
        let quarter = solid(&hull, Pose::translation(0.05, 0.05, 0.0)).covers(&Pose::identity(), 0.0025, 0.0);
        assert!((quarter - 0.25).abs() < 1e-12, "{quarter}");
        // Turned by any angle about the beam, a square of 1 mm that lies within it.
        let small = cube(5e-4);
        let turned = Pose::rotation(Vector3::z() * 0.3) * Pose::translation(3e-4, 0.0, 0.0);
        let share = solid(&small, turned).covers(&Pose::identity(), 0.0025, 0.0);
        assert!((share - 1e-6 / (PI * 6.25e-6)).abs() < 1e-12, "{share}");
    }

    #[test]
    fn a_ray_meets_the_near_side_of_a_turned_cube() {
        let hull = cube(0.05);
        let turned = |angle: f64| Pose::translation(0.0, 0.0, 0.4) * Pose::rotation(Vector3::x() * angle);
        let met = solid(&hull, turned(0.0)).meets(&Pose::identity(), 0.0).expect("met");
        assert!((met - 0.35).abs() < 1e-12);
        // On its edge by 45 degrees.
        let met = solid(&hull, turned(PI / 4.0)).meets(&Pose::identity(), 0.0).expect("met");
        assert!((met - (0.4 - 0.05 * 2.0_f64.sqrt())).abs() < 1e-9, "{met}");
        assert!(solid(&hull, Pose::translation(0.06, 0.0, 0.4)).meets(&Pose::identity(), 0.0).is_none());
        assert!(solid(&hull, Pose::translation(0.0, 0.0, -0.4)).meets(&Pose::identity(), 0.0).is_none());
    }

    #[test]
    fn a_solid_that_moves_was_elsewhere_before() {
        let hull = cube(0.05);
        let moving = Solid { velocity: Vector3::x() * 0.2, ..solid(&hull, Pose::translation(0.1, 0.0, 0.0)) };
        assert!((moving.pose_before(5e-3).translation.x - 0.099).abs() < 1e-15);
    }
}
