//! A path between walls as a taut string: straight lines and arcs, at a distance from all walls.
//!
//! In: walls, a distance from them, a path over corners ([`Inflated::shortest`](crate::Inflated::shortest)). Out: the shortest path of the
//! same kind that keeps the distance: it touches discs about corners of walls, on the side on which the path passes them.
//!
//! ```text
//! c, r, s     centre and radius of a disc, s = +1 if it lies on the left of the path, -1 if on the right; r = 0 at the ends
//! p = c + s r n(u)     where the path leaves a disc in the direction u; n(u) is to the right of u
//! d = L u - q n(u),    d = c2 - c1, q = s2 r2 - s1 r1, L^2 = d^2 - q^2        from one disc to the next
//! ```
//!
//! A disc that the path does not lean on is dropped, one that a line cuts is added, until neither is left.

use crate::walls::{Place, Wall, Walls};

/// A part of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// Straight \[m\].
    Line {
        /// From here ..
        from: Place,
        /// .. to here.
        to: Place,
    },
    /// Around a corner.
    Arc {
        /// The corner \[m\].
        centre: Place,
        /// \[m\].
        radius: f64,
        /// Where it begins, as seen from the corner \[rad\].
        from: f64,
        /// By how much it turns, to the left if > 0 \[rad\].
        turn: f64,
    },
}

/// A path of lines and arcs without bends.
#[derive(Clone, Debug, PartialEq)]
pub struct Taut(Vec<Piece>);

/// A disc that the path passes; an end of the path is one without radius.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Disc {
    centre: Place,
    /// s r.
    signed: f64,
}

/// So near counts as touching \[m\].
const EPS: f64 = 1e-9;
/// The string is pulled so often at most.
const PULLS: usize = 200;

fn cross(a: Place, b: Place) -> f64 {
    a.x * b.y - a.y * b.x
}

fn right(u: Place) -> Place {
    Place::new(u.y, -u.x)
}

fn corners(wall: &Wall) -> [Place; 4] {
    let (l, u) = (wall.lower, wall.upper);
    [l, Place::new(u.x, l.y), u, Place::new(l.x, u.y)]
}

/// Direction of the path from one disc to the next, and where it begins and ends. `None` where they overlap.
fn tangent(one: &Disc, other: &Disc) -> Option<(Place, [Place; 2])> {
    let d = other.centre - one.centre;
    let q = other.signed - one.signed;
    let square = d.norm_squared();
    let length = (square - q * q).sqrt();
    // NaN where they overlap.
    (length > 0.0).then(|| {
        let u = (d * length + right(d) * q) / square;
        (u, [one.centre + right(u) * one.signed, other.centre + right(u) * other.signed])
    })
}

fn to_segment(at: &Place, [from, to]: &[Place; 2]) -> f64 {
    let segment = to - from;
    let share = ((at - from).dot(&segment) / segment.norm_squared().max(1e-30)).clamp(0.0, 1.0);
    (from + segment * share - at).norm()
}

impl Taut {
    /// The path that keeps `radius` \[m\], > 0, from all walls, and passes them as `path` does: a start, corners of walls inflated by about that
    /// radius, and an end. `None` where there is none.
    ///
    /// ```
    /// use mrroc_map::{Inflated, Layout, Place, Region, Taut, Walls};
    ///
    /// let maze: Layout = "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o".parse()?;
    /// let walls = Walls::of(&maze, 0.025, 0.002);
    /// let (start, goal) = (Place::new(0.0125, 0.0375), Place::new(0.0375, 0.0375));
    /// // Polygons that hold the arcs: a corner is inflated by chords of 45 degrees.
    /// let inflated = Inflated::by(&walls, 0.002 / 22.5_f64.to_radians().cos());
    /// let (length, path) = inflated.shortest(&start, &Region { lower: goal, upper: goal }).expect("a path");
    /// let taut = Taut::along(&walls, 0.002, &path).expect("the same path");
    /// // A line, an arc, a line over the end of the wall, an arc, a line.
    /// assert!(taut.pieces().len() == 5 && taut.length() < length);
    /// # Ok::<(), mrroc_map::LayoutError>(())
    /// ```
    #[must_use]
    pub fn along(walls: &Walls, radius: f64, path: &[Place]) -> Option<Self> {
        let all: Vec<Place> = walls.boxes().iter().flat_map(corners).collect();
        let end = |centre: &Place| Disc { centre: *centre, signed: 0.0 };
        let mut discs = vec![end(path.first()?)];
        for at in path.windows(3) {
            let distance = |corner: &Place| (corner - at[1]).norm_squared();
            let near = all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            let side = cross(at[2] - at[0], near - at[1]);
            let disc = Disc { centre: *near, signed: radius.copysign(side) };
            if discs.last() != Some(&disc) {
                discs.push(disc);
            }
        }
        discs.push(end(path.last()?));
        for _ in 0..PULLS {
            let lines: Vec<_> =
                discs.windows(2).map(|pair| tangent(&pair[0], &pair[1])).collect::<Option<_>>()?;
            // The disc that is passed on the wrong side by most.
            let loose = lines
                .windows(2)
                .zip(1..)
                .map(|(at, i)| (cross(at[0].0, at[1].0).atan2(at[0].0.dot(&at[1].0)), i))
                .map(|(turn, i)| (turn * discs[i].signed.signum(), i))
                .filter(|(turn, _)| *turn < -1e-12)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, i)) = loose {
                discs.remove(i);
                continue;
            }
            let cut = lines.iter().enumerate().find_map(|(i, (u, line))| {
                let ends = [discs[i].centre, discs[i + 1].centre];
                let distance = |corner: &&Place| to_segment(corner, line);
                let worst = all
                    .iter()
                    .filter(|corner| !ends.contains(corner) && distance(corner) < radius - EPS)
                    .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
                Some((i + 1, Disc { centre: *worst, signed: radius.copysign(cross(*u, worst - line[0])) }))
            });
            match cut {
                Some((at, disc)) => discs.insert(at, disc),
                None => return Some(Self::of(&discs, &lines)).filter(|taut| taut.keeps(walls, radius)),
            }
        }
        None
    }

    fn of(discs: &[Disc], lines: &[(Place, [Place; 2])]) -> Self {
        let mut pieces = Vec::new();
        for (i, (u, [from, to])) in lines.iter().enumerate() {
            if i > 0 {
                let (before, disc) = (lines[i - 1].0, &discs[i]);
                let begin = lines[i - 1].1[1] - disc.centre;
                pieces.push(Piece::Arc {
                    centre: disc.centre,
                    radius: disc.signed.abs(),
                    from: begin.y.atan2(begin.x),
                    turn: cross(before, *u).atan2(before.dot(u)),
                });
            }
            pieces.push(Piece::Line { from: *from, to: *to });
        }
        Self(pieces)
    }

    /// Whether no wall is nearer to a line; arcs are about corners.
    fn keeps(&self, walls: &Walls, radius: f64) -> bool {
        self.points(0.25 * radius, 0.25 * radius).iter().all(|at| walls.clearance(at) > radius * 0.999)
    }

    /// Its pieces.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.0
    }

    /// \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.0.iter().map(Piece::length).sum()
    }

    /// Places on it, both ends included: `fine` apart \[m\] on arcs and beside them, farther by and by along lines, at most `coarse`.
    #[must_use]
    pub fn points(&self, fine: f64, coarse: f64) -> Vec<Place> {
        let mut points = Vec::new();
        for piece in &self.0 {
            match *piece {
                Piece::Line { from, to } => {
                    points.extend(graded((to - from).norm(), fine, coarse).map(|s| from + (to - from) * s));
                }
                Piece::Arc { centre, radius, from, turn } => {
                    let count = (radius * turn.abs() / fine).ceil().max(1.0);
                    // Its ends are those of the lines.
                    points.extend((1..count as u32).map(|i| {
                        let (sin, cos) = (from + turn * f64::from(i) / count).sin_cos();
                        centre + Place::new(cos, sin) * radius
                    }));
                }
            }
        }
        points.dedup_by(|a, b| (*a - *b).norm() < 1e-7);
        points
    }
}

impl Piece {
    /// \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc { radius, turn, .. } => radius * turn.abs(),
        }
    }
}

/// Shares of a length, 0 and 1 included, `fine` apart at both ends and up to `coarse` in the middle.
fn graded(length: f64, fine: f64, coarse: f64) -> impl Iterator<Item = f64> {
    let mut half = vec![0.0];
    let (mut at, mut step) = (0.0, fine);
    while at + 1.5 * step < 0.5 * length {
        at += step;
        half.push(at / length);
        step = (1.5 * step).min(coarse);
    }
    let back: Vec<f64> = half.iter().rev().map(|share| 1.0 - share).collect();
    half.into_iter().chain(back)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Inflated, Layout, Region};
    use core::f64::consts::FRAC_PI_2;

    /// Inflated by so much more than the distance that its polygons hold the arcs.
    const AROUND: f64 = 1.0824;

    #[test]
    fn around_the_end_of_a_wall_it_has_the_length_of_its_closed_form() {
        let maze: Layout = "o---o---o\n| S | G |\no   o   o\n|       |\no---o---o".parse().expect("a maze");
        let walls = Walls::of(&maze, 0.025, 0.002);
        let (start, goal) = (Place::new(0.0125, 0.0375), Place::new(0.0375, 0.0375));
        let region = Region { lower: goal, upper: goal };
        let (_, path) = Inflated::by(&walls, 0.002 * AROUND).shortest(&start, &region).expect("a path");
        let taut = Taut::along(&walls, 0.002, &path).expect("a path");
        // Tangent to a circle of 2 mm about a corner, over the end of the wall, and up again.
        let corner = Place::new(0.024, 0.024);
        let away = (start - corner).norm();
        let tangent = (away * away - 4e-6_f64).sqrt();
        let angle = ((start.x - corner.x).abs() / away).asin();
        let turn = FRAC_PI_2 - (angle - (2e-3 / away).asin());
        let exact = 2.0 * (tangent + 2e-3 * turn) + 2e-3;
        assert!((taut.length() - exact).abs() < 1e-12, "{} {exact}", taut.length());
    }

    #[test]
    fn it_keeps_its_distance_and_is_between_the_inner_and_the_outer_polygons() {
        for seed in 0..6 {
            let maze = Layout::random(16, seed);
            let walls = Walls::of(&maze, 0.025, 0.002);
            let start = Place::new(0.0125, 0.0125);
            let goal = Region { lower: Place::new(0.18, 0.18), upper: Place::new(0.22, 0.22) };
            let (inner, _) = Inflated::by(&walls, 0.0023).shortest(&start, &goal).expect("a path");
            let (outer, path) =
                Inflated::by(&walls, 0.0023 * AROUND).shortest(&start, &goal).expect("a path");
            let taut = Taut::along(&walls, 0.0023, &path).expect("a path");
            assert!(inner <= taut.length() + 1e-9 && taut.length() <= outer + 1e-9, "seed {seed}");
            for at in taut.points(1e-4, 1e-4) {
                assert!(walls.clearance(&at) > 0.0023 - 1e-8, "seed {seed}: {}", walls.clearance(&at));
            }
            // No bends: each piece goes on in the direction of the one before.
            let points = taut.points(1e-4, 1e-4);
            for at in points.windows(3) {
                let (a, b) = (at[1] - at[0], at[2] - at[1]);
                assert!(a.angle(&b) < 0.05, "seed {seed}");
            }
        }
    }
}
