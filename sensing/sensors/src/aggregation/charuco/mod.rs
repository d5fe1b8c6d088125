//! ChArUco boards in an image, for the calibration of a camera: chessboards with a marker in each white square.
//!
//! In: a grey image, how many squares the board has, and from which dictionary its markers are. Out: where its inner corners are \[pixel\], to some hundredths of a pixel. Unlike a
//! chessboard it tells how it is turned, and a part of its markers may be hidden.
//!
//! Markers ([`markers`](markers)) tell about where the corners between them are; each corner is then moved to where the gradients around it point, in a window that does not reach
//! the next marker.

mod markers;

use nalgebra::{Vector2, Vector3};

pub use markers::Dictionary;
use markers::{Marker, seen_markers};

use super::chessboard::{Grey, NoBoard, refine};
use super::homography::homography;

/// A ChArUco board, as OpenCV makes it since 4.6; and as it did before, if most of the markers say so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charuco {
    /// Squares along x and along y of the board, each at least 3.
    pub squares: [usize; 2],
    /// The side of a square \[m\], > 0.
    pub square: f64,
    /// The side of a marker \[m\], > 0, smaller than that of a square.
    pub marker: f64,
    /// From which its markers are, beginning with the first.
    pub dictionary: Dictionary,
}

/// Of the markers of a board so many must be seen, as a share.
const SEEN: f64 = 0.4;

/// A corner is foretold from so many of the nearest markers.
const NEAREST: usize = 4;

/// A marker that is farther from where the others foretell it than this share of its side is none of the board.
const BESIDE: f64 = 0.3;

/// Corners are refined in a window that reaches so far to the next marker, as a share of the distance, and at most so many pixels.
const REACH: f64 = 0.7;
const WINDOW: f64 = 11.0;

/// In the image and not at its rim \[pixel\].
const RIM: f64 = 3.0;

impl Charuco {
    /// Where the inner corners are on the board \[m\], row by row along x, from the board's own corner; z points away from who looks at it.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> {
        let Self { squares: [across, down], square, .. } = *self;
        (1..down).flat_map(move |j| {
            (1..across).map(move |i| Vector3::new(i as f64 * square, j as f64 * square, 0.0))
        })
    }

    /// Where they are in an image \[pixel\], in the same order; the middle of the first pixel is (0, 0). All of them must be in it, though markers may be hidden.
    ///
    /// # Errors
    /// [`NoBoard`].
    pub fn seen(&self, image: &Grey<'_>) -> Result<Vec<Vector2<f64>>, NoBoard> {
        let markers = seen_markers(image, &self.dictionary);
        let fits = [false, true].map(|is_old| self.on_board(&markers, is_old));
        let fit = fits.into_iter().max_by_key(Vec::len).unwrap_or_default();
        let wanted = self.places(false).count();
        let is_enough = fit.len() >= 3 && fit.len() as f64 >= SEEN * wanted as f64;
        if !is_enough {
            return Err(NoBoard::Markers { found: fit.len(), wanted });
        }
        let near = |point: &Vector2<f64>| -> Option<Vector2<f64>> {
            let mut order: Vec<&OnBoard> = fit.iter().collect();
            let far = |one: &OnBoard| (one.corners.iter().sum::<Vector2<f64>>() / 4.0 - point).norm();
            order.sort_by(|a, b| far(a).total_cmp(&far(b)));
            let nearest = &order[..NEAREST.min(order.len())];
            let from: Vec<Vector2<f64>> = nearest.iter().flat_map(|one| one.corners).collect();
            let to: Vec<Vector2<f64>> = nearest.iter().flat_map(|one| one.seen).collect();
            let there = homography(&from, &to)? * point.push(1.0);
            Some(there.xy() / there.z)
        };
        let margin = 0.5 * (self.square - self.marker);
        let [w, h] = [image.width, image.height].map(|side| side as f64 - 1.0 - RIM);
        let corner = |point: Vector3<f64>| -> Option<Vector2<f64>> {
            let point = point.xy();
            let at = near(&point)?;
            let sides = [Vector2::x(), Vector2::y()].map(|axis| near(&(point + margin * axis)));
            let reach = sides.into_iter().map(|side| side.map_or(0.0, |side| (side - at).norm()));
            let window = (REACH * reach.fold(f64::INFINITY, f64::min)).clamp(2.0, WINDOW) as usize;
            let is_in = (RIM..=w).contains(&at.x) && (RIM..=h).contains(&at.y);
            is_in.then(|| refine(image, &at, window))
        };
        let corners: Option<Vec<Vector2<f64>>> = self.points().map(corner).collect();
        corners.ok_or(NoBoard::Leaves)
    }

    /// The squares with markers, in the order of their numbers. Boards of OpenCV before 4.6 with an even number of rows begin with a marker in the first square.
    fn places(&self, is_old: bool) -> impl Iterator<Item = [usize; 2]> {
        let [across, down] = self.squares;
        let first = usize::from(!(is_old && down % 2 == 0));
        (0..down)
            .flat_map(move |y| (0..across).map(move |x| [x, y]))
            .filter(move |[x, y]| (x + y) % 2 == first)
    }

    /// The markers that may be on such a board, all where the others say.
    fn on_board(&self, markers: &[Marker], is_old: bool) -> Vec<OnBoard> {
        let places: Vec<[usize; 2]> = self.places(is_old).collect();
        let margin = 0.5 * (self.square - self.marker);
        let place = |marker: &Marker| -> Option<OnBoard> {
            let [x, y] = *places.get(marker.number)?;
            let first = Vector2::new(x as f64, y as f64) * self.square + Vector2::repeat(margin);
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let corners = corners.map(|corner| first + self.marker * Vector2::from(corner));
            Some(OnBoard { corners, seen: marker.corners })
        };
        let mut fit: Vec<OnBoard> = markers.iter().filter_map(place).collect();
        // The one that is farthest off is left out, until none is: a number that was read wrongly.
        while fit.len() >= 2 {
            let from: Vec<Vector2<f64>> = fit.iter().flat_map(|one| one.corners).collect();
            let to: Vec<Vector2<f64>> = fit.iter().flat_map(|one| one.seen).collect();
            let Some(plane) = homography(&from, &to) else { return Vec::new() };
            let off = |one: &OnBoard| {
                let side = (one.seen[1] - one.seen[0]).norm().max((one.seen[2] - one.seen[1]).norm());
                let all = one.corners.iter().zip(&one.seen).map(|(corner, seen)| {
                    let there = plane * corner.push(1.0);
                    (there.xy() / there.z - seen).norm()
                });
                all.fold(0.0, f64::max) / side
            };
            let worst = fit.iter().map(off).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((i, off)) if off > BESIDE => drop(fit.swap_remove(i)),
                _ => break,
            }
        }
        fit
    }
}

/// A marker whose place on the board is known.
#[derive(Clone, Copy, Debug)]
struct OnBoard {
    /// On the board \[m\].
    corners: [Vector2<f64>; 4],
    /// In the image \[pixel\].
    seen: [Vector2<f64>; 4],
}
