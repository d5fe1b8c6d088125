//! Paths of a base on a floor: straight pieces and corners of continuous curvature, or a turn on the spot.
//!
//! ```text
//! corner   two clothoids, curvature sigma s up to its middle and down again:  heading(s) = heading_0 + sigma s^2 / 2
//!          turned by phi in all, each is L long and sigma = phi / L^2;   it leaves the line at T before the corner, with
//!          T = L (C + S tan(phi / 2)),   C + i S = integral over 0..1 of exp(i phi u^2 / 2) du
//!          and passes the corner at L S / cos(phi / 2)
//! wheels   q(s) = q_0 + wheels(s, heading(s) - heading_0): of the third degree on each piece, twice continuously differentiable
//! ```
//!
//! Its parameter is the length of the path of the axle's middle \[m\]; of a turn on the spot it is the length that a wheel rolls.

use mrroc_generators::curve::{Parametric, SplinePoint};
use nalgebra::Vector2;

use crate::model::{DiffDrive, Two, angle};
use crate::sensing::Planar;

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// A path needs two places.
    #[error("a path needs two places or more")]
    TooFew,
    /// Two places that follow each other are the same, or not finite.
    #[error("place {0}, counted from 1, is at no distance from the one before")]
    NoDistance(usize),
    /// The path turns back so sharply that no bend leads around.
    #[error(
        "at place {at}, counted from 1, it turns by {turn:.2} rad, and a bend can by {most:.2}: stop there, and turn on the spot"
    )]
    Sharp {
        /// Which place.
        at: usize,
        /// The turn \[rad\].
        turn: f64,
        /// The largest \[rad\].
        most: f64,
    },
}

/// A piece whose curvature is linear.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    /// Parameter at its beginning.
    from: f64,
    /// The base there.
    pose: Planar,
    /// Turn by distance at its beginning [rad/m], and how that changes [rad/m²].
    bend: f64,
    rate: f64,
}

/// A path.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    pieces: Vec<Piece>,
    knots: Vec<f64>,
    length: f64,
    /// 1, or 0 of a turn on the spot.
    ahead: f64,
    start: Two,
}

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// The base there.
    pub pose: Planar,
    /// Turn by distance [rad/m].
    pub bend: f64,
    /// How that changes by distance [rad/m²].
    pub rate: f64,
}

/// The sharpest corner that a bend leads around \[rad\].
pub const SHARPEST: f64 = 2.6;

impl Path {
    /// Through these places \[m\] in straight lines, with bends that pass each corner at no more than `off` \[m\], > 0, and take no more
    /// than half of the lines that meet there.
    ///
    /// # Errors
    /// See [`PathError`].
    ///
    /// ```
    /// use mrroc_wheels::Path;
    /// use nalgebra::Vector2;
    /// let places = [Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.0), Vector2::new(1.0, 1.0)];
    /// let path = Path::through(&places, 0.05)?;
    /// let middle = path.at(0.5 * path.length()).pose;
    /// assert!(((middle.at() - places[1]).norm() - 0.05).abs() < 1e-9);
    /// # Ok::<(), mrroc_wheels::path::PathError>(())
    /// ```
    pub fn through(places: &[Vector2<f64>], off: f64) -> Result<Self, PathError> {
        if places.len() < 2 {
            return Err(PathError::TooFew);
        }
        for (i, leg) in places.windows(2).enumerate() {
            let length = (leg[1] - leg[0]).norm();
            if !(length > 1e-9 && length.is_finite()) {
                return Err(PathError::NoDistance(i + 2));
            }
        }
        let heading = |i: usize| {
            let leg = places[i + 1] - places[i];
            leg.y.atan2(leg.x)
        };
        let start = Planar { x: places[0].x, y: places[0].y, heading: heading(0) };
        let mut path = Self::starting(1.0);
        let (mut pose, mut before) = (start, 0.0);
        for i in 1..places.len() {
            let length = (places[i] - places[i - 1]).norm();
            let Some(next) = places.get(i + 1) else {
                path.add(&mut pose, length - before, 0.0, 0.0);
                break;
            };
            let phi = angle(heading(i) - heading(i - 1));
            if phi.abs() > SHARPEST {
                return Err(PathError::Sharp { at: i + 1, turn: phi, most: SHARPEST });
            }
            if phi.abs() < 1e-9 {
                path.add(&mut pose, length - before, 0.0, 0.0);
                before = 0.0;
                continue;
            }
            let (along, beside) = clothoid(phi.abs());
            let tangent = along + beside * (0.5 * phi.abs()).tan();
            let room = 0.5 * length.min((next - places[i]).norm());
            let each = (off * (0.5 * phi).cos() / beside).min(room / tangent);
            let rate = phi / (each * each);
            path.add(&mut pose, length - before - each * tangent, 0.0, 0.0);
            path.add(&mut pose, each, 0.0, rate);
            path.add(&mut pose, each, rate * each, -rate);
            before = each * tangent;
        }
        Ok(path)
    }

    /// A turn on the spot by an angle \[rad\].
    #[must_use]
    pub fn turn(at: Planar, by: f64) -> Self {
        let mut path = Self::starting(0.0);
        let mut pose = at;
        let lever = 0.5 * DiffDrive::TRACK;
        path.add(&mut pose, lever * by.abs(), by.signum() / lever, 0.0);
        path
    }

    fn starting(ahead: f64) -> Self {
        Self { pieces: Vec::new(), knots: Vec::new(), length: 0.0, ahead, start: Two::zeros() }
    }

    fn add(&mut self, pose: &mut Planar, length: f64, bend: f64, rate: f64) {
        if length <= 1e-12 && !self.pieces.is_empty() {
            return;
        }
        let piece = Piece { from: self.length, pose: *pose, bend, rate };
        *pose = piece.at(length, self.ahead).pose;
        self.knots.push(self.length);
        self.pieces.push(piece);
        self.length += length.max(0.0);
    }

    /// Its length \[m\].
    #[must_use]
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Whether it is a turn on the spot.
    #[must_use]
    pub fn is_turn(&self) -> bool {
        self.ahead == 0.0
    }

    /// The place at so much of its length \[m\]; beyond its ends, its ends.
    #[must_use]
    pub fn at(&self, s: f64) -> PathPoint {
        let s = s.clamp(0.0, self.length);
        let piece = &self.pieces[self.pieces.partition_point(|piece| piece.from <= s).max(1) - 1];
        piece.at(s - piece.from, self.ahead)
    }

    /// The same path, whose wheels stand at these angles at its beginning \[rad\].
    #[must_use]
    pub fn with_wheels(self, start: Two) -> Self {
        Self { start, ..self }
    }
}

impl Piece {
    fn at(&self, s: f64, ahead: f64) -> PathPoint {
        let heading = |s: f64| self.pose.heading + s * (self.bend + 0.5 * self.rate * s);
        let mut place = self.pose.at();
        if ahead > 0.0 {
            place += integral(|u| {
                let (sine, cosine) = heading(u * s).sin_cos();
                Vector2::new(cosine, sine)
            }) * s;
        }
        PathPoint {
            pose: Planar { x: place.x, y: place.y, heading: heading(s) },
            bend: self.bend + self.rate * s,
            rate: self.rate,
        }
    }
}

/// Angles of the wheels along it.
impl Parametric for Path {
    type Value = Two;

    fn range(&self) -> (f64, f64) {
        (0.0, self.length)
    }

    fn at(&self, u: f64) -> SplinePoint<Two> {
        let point = Path::at(self, u);
        let turned = point.pose.heading - self.pieces[0].pose.heading;
        SplinePoint {
            value: self.start + DiffDrive::wheels(self.ahead * u.clamp(0.0, self.length), turned),
            first: DiffDrive::wheels(self.ahead, point.bend),
            second: DiffDrive::wheels(0.0, point.rate),
        }
    }

    fn knots(&self) -> &[f64] {
        &self.knots
    }
}

/// Where a clothoid of length 1 ends that begins along x and turns by half of `phi` \[rad\]: along and beside.
fn clothoid(phi: f64) -> (f64, f64) {
    let end = integral(|u| {
        let (sine, cosine) = (0.5 * phi * u * u).sin_cos();
        Vector2::new(cosine, sine)
    });
    (end.x, end.y)
}

/// Over 0..1, by Gauss and Legendre with eight places: exact to 1e-13 for the bends here.
fn integral(f: impl Fn(f64) -> Vector2<f64>) -> Vector2<f64> {
    const PLACES: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_3),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
        (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
    ];
    PLACES.iter().map(|(place, weight)| (f(0.5 + 0.5 * place) + f(0.5 - 0.5 * place)) * (0.5 * weight)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the trapezium rule on a million places.
    fn slowly(phi: f64) -> Vector2<f64> {
        let count = 1_000_000;
        let mut sum = Vector2::zeros();
        for i in 0..=count {
            let u = f64::from(i) / f64::from(count);
            let weight = if i == 0 || i == count { 0.5 } else { 1.0 };
            sum += Vector2::new((0.5 * phi * u * u).cos(), (0.5 * phi * u * u).sin()) * weight;
        }
        sum / f64::from(count)
    }

    #[test]
    fn a_clothoid_ends_where_fresnels_integrals_say() {
        for phi in [0.3, core::f64::consts::FRAC_PI_2, SHARPEST] {
            let (along, beside) = clothoid(phi);
            assert!((Vector2::new(along, beside) - slowly(phi)).norm() < 1e-11, "{phi}");
        }
    }

    #[test]
    fn a_path_ends_at_its_last_place_with_a_bend_that_never_jumps() {
        let places = [[0.0, 0.0], [0.6, 0.0], [0.7, 0.5], [0.1, 0.6], [0.0, 0.2]].map(Vector2::from);
        let path = Path::through(&places, 0.03).expect("a path");
        let end = path.at(path.length()).pose;
        assert!((end.at() - places[4]).norm() < 1e-12, "{end:?}");
        let count = 20_000;
        let step = path.length() / f64::from(count);
        for i in 1..=count {
            let (a, b) = (path.at(f64::from(i - 1) * step), path.at(f64::from(i) * step));
            assert!(((b.pose.at() - a.pose.at()).norm() - step).abs() < 1e-3 * step);
            assert!((b.bend - a.bend).abs() <= (a.rate.abs().max(b.rate.abs()) + 1e-9) * step * 1.001);
            assert!((b.pose.heading - a.pose.heading - 0.5 * (a.bend + b.bend) * step).abs() < 1e-6);
        }
        // No corner is passed farther off than it may.
        for corner in &places[1..4] {
            let near = (0..=count).map(|i| (path.at(f64::from(i) * step).pose.at() - corner).norm());
            let near = near.fold(f64::INFINITY, f64::min);
            assert!(near < 0.03 + 1e-6, "{near}");
        }
    }

    #[test]
    fn places_that_make_no_path_are_told() {
        let places = |all: &[[f64; 2]]| all.iter().map(|at| Vector2::from(*at)).collect::<Vec<_>>();
        assert_eq!(Path::through(&places(&[[0.0, 0.0]]), 0.1), Err(PathError::TooFew));
        assert_eq!(Path::through(&places(&[[0.0, 0.0], [0.0, 0.0]]), 0.1), Err(PathError::NoDistance(2)));
        let back = Path::through(&places(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.1]]), 0.1);
        assert!(matches!(back, Err(PathError::Sharp { at: 2, .. })), "{back:?}");
    }
}
