//! Grids of dark circles in an image, for the calibration of a camera: symmetric ones, and asymmetric ones, in which every second row is shifted by half a step.
//!
//! In: a grey image, and how many circles the grid has. Out: where the middle of each is \[pixel\], to some hundredths of a pixel.
//!
//! What is darker than the mean around it, and has the shape of an ellipse, is a circle: its middle is the mean of its pixels, weighted by how dark they are. Circles are joined to
//! a lattice from one to its neighbours; then the lattice is turned until the grid that is wanted lies on it.
//!
//! The middle of the ellipse that a circle is seen as is not where the circle's middle is seen, if the board is tilted: by up to some tenths of a pixel. By how much follows from how
//! large the circles are, which their areas tell, and the homography from the board to the image: a circle `x^T C x = 0` is seen as `H^-T C H^-1` (Heikkila 2000).

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::chessboard::{Grey, NoBoard};
use super::dark::dark_regions;
use super::homography::homography;

/// How every second row of a grid lies beside the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Below each other.
    Straight,
    /// Shifted by half a step: OpenCV's asymmetric grid.
    Shifted,
}

/// A grid of dark circles on a bright board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circles {
    /// Circles in a row, and rows, each at least 2; as OpenCV counts them.
    pub count: [usize; 2],
    /// From one row to the next \[m\], > 0. In a row circles are as far from each other if rows are straight, and twice as far if they are shifted.
    pub step: f64,
    /// How rows lie.
    pub rows: Rows,
}

/// The mean around a pixel is that of a square with this share of the image's longer side, the first that finds a grid.
const AROUND: [usize; 3] = [8, 16, 32];

/// Pixels of a circle, at least.
const LEAST: usize = 16;

/// The area of an ellipse by that of its second moments is 1; so much is it off at most.
const ELLIPTIC: f64 = 0.12;

/// The longest axis of an ellipse, by the shortest, at most.
const SLENDER: f64 = 4.0;

/// The middle of an ellipse is so far from that of the circle at most \[pixel\]: what is more comes of a homography that is none.
const MOST_OFF: f64 = 3.0;

/// A neighbour is where the lattice foretells it, to this share of the step.
const NEAR: f64 = 0.3;

impl Circles {
    /// Where the middles are on the board \[m\], row by row; z points away from who looks at it.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> {
        let step = self.step;
        self.cells().map(move |[x, y]| Vector3::new(x as f64 * step, y as f64 * step, 0.0))
    }

    /// The same in steps.
    fn cells(&self) -> impl Iterator<Item = [i64; 2]> {
        let Self { count: [across, down], rows, .. } = *self;
        (0..down as i64).flat_map(move |j| {
            (0..across as i64).map(move |i| match rows {
                Rows::Straight => [i, j],
                Rows::Shifted => [2 * i + j % 2, j],
            })
        })
    }

    /// Whether a view tells which end of the grid is which: of one with shifted rows, and an odd number of them.
    #[must_use]
    pub const fn has_ends(&self) -> bool {
        matches!(self.rows, Rows::Shifted) && self.count[1] % 2 == 1
    }

    /// Where they are in an image \[pixel\], in the order of [`Circles::points`]; the middle of the first pixel is (0, 0).
    ///
    /// # Errors
    /// [`NoBoard`].
    pub fn seen(&self, image: &Grey<'_>) -> Result<Vec<Vector2<f64>>, NoBoard> {
        let mut why = NoBoard::Nothing;
        for around in AROUND {
            match self.arranged(&ellipses(image, image.width.max(image.height) / around)) {
                Ok(seen) => return Ok(seen),
                Err(NoBoard::Nothing) => {}
                Err(other) => why = other,
            }
        }
        Err(why)
    }

    /// The grid among the middles of circles, and of what else looks like one.
    fn arranged(&self, circles: &[Ellipse]) -> Result<Vec<Vector2<f64>>, NoBoard> {
        let middles: Vec<Vector2<f64>> = circles.iter().map(|circle| circle.middle).collect();
        let middles = &middles[..];
        let mut largest = 0;
        let wanted = self.count[0] * self.count[1];
        let mut begun = vec![false; middles.len()];
        for first in 0..middles.len() {
            if begun[first] {
                continue;
            }
            let lattice = lattice(middles, first);
            lattice.values().for_each(|i| begun[*i] = true);
            largest = largest.max(lattice.len());
            if let Some(order) = self.on(&lattice, middles) {
                let seen: Vec<Ellipse> = order.into_iter().map(|i| circles[i]).collect();
                return Ok(self.middles_of_circles(&seen));
            }
        }
        if largest < 4 {
            return Err(NoBoard::Nothing);
        }
        Err(NoBoard::Circles { found: largest, wanted })
    }

    /// The grid on a lattice that has it and nothing else; of several fits the one whose first circle is nearest to that of the image.
    fn on(&self, lattice: &BTreeMap<[i64; 2], usize>, middles: &[Vector2<f64>]) -> Option<Vec<usize>> {
        let cells: Vec<[i64; 2]> = self
            .cells()
            .map(|[x, y]| match self.rows {
                Rows::Straight => [x, y],
                // Along the diagonals, on which the next circles are.
                Rows::Shifted => [(x + y) / 2, (y - x).div_euclid(2)],
            })
            .collect();
        if lattice.len() != cells.len() {
            return None;
        }
        let least = |of: &mut dyn Iterator<Item = [i64; 2]>| {
            of.fold([i64::MAX; 2], |[a, b], [x, y]| [a.min(x), b.min(y)])
        };
        let start = least(&mut lattice.keys().copied());
        let mut best: Option<Vec<usize>> = None;
        // The lattice's directions may be any two that span it; the board is never seen in a mirror.
        for code in 0..81_i64 {
            let [a, b, c, d] = [code / 27, code / 9 % 3, code / 3 % 3, code % 3].map(|digit| digit - 1);
            if a * d - b * c != 1 {
                continue;
            }
            let turned: Vec<[i64; 2]> = cells.iter().map(|[x, y]| [a * x + b * y, c * x + d * y]).collect();
            let own = least(&mut turned.iter().copied());
            let shift = [start[0] - own[0], start[1] - own[1]];
            let places = turned.iter().map(|[x, y]| lattice.get(&[x + shift[0], y + shift[1]]).copied());
            let Some(order) = places.collect::<Option<Vec<usize>>>() else { continue };
            let first =
                |order: &[usize]| order.first().map_or(f64::INFINITY, |i| middles[*i].x + middles[*i].y);
            if best.as_deref().is_none_or(|best| first(&order) < first(best)) {
                best = Some(order);
            }
        }
        best
    }

    /// Where the circles' middles are seen, of which ellipses are.
    fn middles_of_circles(&self, seen: &[Ellipse]) -> Vec<Vector2<f64>> {
        let cells: Vec<Vector2<f64>> = self.cells().map(|[x, y]| Vector2::new(x as f64, y as f64)).collect();
        let middles = || seen.iter().map(|one| one.middle).collect::<Vec<_>>();
        let Some(plane) = homography(&cells, &middles()) else { return middles() };
        // By how much an area is larger in the image.
        let grows = |cell: &Vector2<f64>| {
            let depth = (plane * cell.push(1.0)).z;
            plane.determinant() / depth.powi(3)
        };
        let mut squares: Vec<f64> = cells
            .iter()
            .zip(seen)
            .map(|(cell, one)| one.area / grows(cell).abs() / core::f64::consts::PI)
            .collect();
        squares.sort_by(f64::total_cmp);
        let square = squares[squares.len() / 2];
        let off = |cell: &Vector2<f64>| -> Option<Vector2<f64>> {
            let [x, y] = [cell.x, cell.y];
            // The inverse of the circle's matrix, of which the pole of the line at infinity is the middle.
            let dual = Matrix3::new(square - x * x, -x * y, -x, -x * y, square - y * y, -y, -x, -y, -1.0);
            let ellipse = plane * dual * plane.transpose();
            let middle = ellipse.column(2).xy() / ellipse[(2, 2)];
            let truly = plane * cell.push(1.0);
            let off = truly.xy() / truly.z - middle;
            (off.norm() < MOST_OFF).then_some(off)
        };
        cells.iter().zip(seen).map(|(cell, one)| one.middle + off(cell).unwrap_or_default()).collect()
    }
}

/// A dark ellipse.
#[derive(Clone, Copy, Debug)]
struct Ellipse {
    middle: Vector2<f64>,
    /// \[pixel^2\]
    area: f64,
}

/// The circles that a lattice reaches from one of them, by their places in it.
fn lattice(middles: &[Vector2<f64>], first: usize) -> BTreeMap<[i64; 2], usize> {
    let mut lattice = BTreeMap::from([([0, 0], first)]);
    let mut near: Vec<(f64, Vector2<f64>)> =
        middles.iter().map(|at| at - middles[first]).map(|offset| (offset.norm(), offset)).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, right)) = near.get(1).copied() else { return lattice };
    // The nearest one that lies in another direction, counted as down from it.
    let aside = |offset: &Vector2<f64>| right.perp(offset) / (right.norm() * offset.norm());
    let Some((_, down)) = near.iter().skip(2).take(7).find(|(_, offset)| aside(offset).abs() > 0.5).copied()
    else {
        return lattice;
    };
    let down = if aside(&down) < 0.0 { -down } else { down };
    let mut used = vec![false; middles.len()];
    used[first] = true;
    let mut open = VecDeque::from([([0, 0], Matrix2::from_columns(&[right, down]))]);
    while let Some((place, axes)) = open.pop_front() {
        let Some(at) = lattice.get(&place).map(|i: &usize| middles[*i]) else { continue };
        for by in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
            let next = [place[0] + by[0], place[1] + by[1]];
            if lattice.contains_key(&next) {
                continue;
            }
            let step = axes * Vector2::new(by[0] as f64, by[1] as f64);
            let free = middles.iter().enumerate().filter(|(i, _)| !used[*i]);
            let far = |one: &Vector2<f64>| (one - at - step).norm();
            let nearest = free.map(|(i, one)| (far(one), i)).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, i)) = nearest.filter(|(far, _)| *far < NEAR * step.norm()) else { continue };
            used[i] = true;
            lattice.insert(next, i);
            // The step changes from circle to circle where the board is seen askew.
            let own = (middles[i] - at) * (by[0] + by[1]) as f64;
            let mut there = axes;
            there.column_mut(usize::from(by[0] == 0)).copy_from(&own);
            open.push_back((next, there));
        }
    }
    lattice
}

/// All dark ellipses.
fn ellipses(image: &Grey<'_>, around: usize) -> Vec<Ellipse> {
    dark_regions(image, around).iter().filter_map(|pixels| ellipse(image, pixels)).collect()
}

/// The ellipse that these dark pixels are; `None` of what is none.
fn ellipse(image: &Grey<'_>, pixels: &[usize]) -> Option<Ellipse> {
    if pixels.len() < LEAST {
        return None;
    }
    let width = image.width;
    let n = pixels.len() as f64;
    let place = |i: &usize| Vector2::new((i % width) as f64, (i / width) as f64);
    let mean = pixels.iter().map(place).sum::<Vector2<f64>>() / n;
    let moments: Matrix2<f64> =
        pixels.iter().map(|i| place(i) - mean).map(|off| off * off.transpose()).sum::<Matrix2<f64>>() / n;
    let squares = moments.symmetric_eigenvalues();
    let (long, short) = (squares.max().sqrt(), squares.min().max(0.0).sqrt());
    // Of a filled ellipse the area is 4 pi times the root of the moments' determinant.
    let filled = n / (4.0 * core::f64::consts::PI * long * short);
    if (filled - 1.0).abs() > ELLIPTIC || long > SLENDER * short {
        return None;
    }
    // All of the blurred edge counts: an ellipse that is three pixels larger on all sides, on the brightness around it.
    let shape = moments.try_inverse()?;
    let reach = 2.0 * long + 5.0;
    let grown = |off: &Vector2<f64>, by: f64| {
        let distance = (shape * off).dot(off).sqrt();
        // Along this direction the edge is where the distance is 2.
        distance <= 2.0 * (1.0 + by * distance / (2.0 * off.norm().max(1e-9)))
    };
    let (mut inner, mut ring, mut dark) = (Vec::new(), (0.0, 0.0), (0.0, 0.0));
    let range = |middle: f64, most: usize| {
        let from = (middle - reach).floor().max(0.0) as usize;
        from..((middle + reach).ceil() as usize + 1).min(most)
    };
    for y in range(mean.y, image.height) {
        for x in range(mean.x, width) {
            let at = Vector2::new(x as f64, y as f64);
            let grey = f64::from(image.pixels[y * width + x]);
            if grown(&(at - mean), 2.0) {
                inner.push((at, grey));
                // Half of its size, without the edge.
                if (shape * (at - mean)).dot(&(at - mean)) < 1.0 {
                    dark = (dark.0 + grey, dark.1 + 1.0);
                }
            } else if grown(&(at - mean), 4.0) {
                ring = (ring.0 + grey, ring.1 + 1.0);
            }
        }
    }
    let bright = (ring.1 > 0.0).then(|| ring.0 / ring.1)?;
    let weights = inner.iter().map(|(at, grey)| (at, bright - grey));
    let (sum, weight) = weights.fold((Vector2::zeros(), 0.0), |(sum, all), (at, w)| (sum + at * w, all + w));
    let contrast = (dark.1 > 0.0).then(|| bright - dark.0 / dark.1)?;
    (weight > 0.0 && contrast > 0.0).then(|| Ellipse { middle: sum / weight, area: weight / contrast })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    const FOCAL: f64 = 500.0;
    const SIZE: [usize; 2] = [640, 480];

    /// A photo of a grid of circles with a radius, and where their middles are in it: each pixel is the mean of 64 points of the board.
    fn photo(circles: &Circles, radius: f64, turn: [f64; 3], far: f64) -> (Vec<u8>, Vec<Vector2<f64>>) {
        let turn = Rotation3::from_scaled_axis(Vector3::from(turn));
        let points: Vec<Vector3<f64>> = circles.points().collect();
        let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let place = Vector3::new(0.0, 0.0, far) - turn * middle;
        let centre = Vector2::new(320.0, 240.0);
        let truth =
            points.iter().map(|point| turn * point + place).map(|at| at.xy() * (FOCAL / at.z) + centre);
        let truth: Vec<Vector2<f64>> = truth.collect();
        let rim = middle.xy() + Vector2::repeat(2.5 * circles.step);
        let back = turn.inverse();
        let own = back * place;
        // Where the board is that a point of the image shows.
        let on = |at: Vector2<f64>| {
            let ray = back * ((at - centre) / FOCAL).push(1.0);
            (ray * (own.z / ray.z) - own).xy()
        };
        let grey = |on: Vector2<f64>, near: &[Vector2<f64>]| {
            let aside = on - middle.xy();
            if aside.x.abs() > rim.x || aside.y.abs() > rim.y {
                90.0
            } else if near.iter().any(|point| (point - on).norm() < radius) {
                30.0
            } else {
                220.0
            }
        };
        let mut near = Vec::new();
        let pixel = |i: usize| {
            let at = Vector2::new((i % SIZE[0]) as f64, (i / SIZE[0]) as f64);
            let part =
                |k: usize| Vector2::new((k % 8) as f64, (k / 8) as f64) / 8.0 - Vector2::repeat(3.5 / 8.0);
            // A pixel shows less than half a step of the board: it has points of no other circle than the nearest ones.
            let shown = on(at);
            near.clear();
            near.extend(points.iter().map(Vector3::xy).filter(|point| (point - shown).norm() < circles.step));
            ((0..64).map(|k| grey(on(at + part(k)), &near)).sum::<f64>() / 64.0).round() as u8
        };
        ((0..SIZE[0] * SIZE[1]).map(pixel).collect(), truth)
    }

    fn off(circles: &Circles, image: &[u8], truth: &[Vector2<f64>]) -> f64 {
        let seen = circles.seen(&Grey::new(SIZE[0], SIZE[1], image).expect("an image"));
        let seen = seen.unwrap_or_else(|why| panic!("{why}"));
        seen.iter().zip(truth).map(|(own, truth)| (own - truth).norm()).fold(0.0, f64::max)
    }

    #[test]
    fn middles_of_circles_are_seen_where_they_are_though_ellipses_have_others() {
        let straight = Circles { count: [7, 6], step: 0.025, rows: Rows::Straight };
        let shifted = Circles { count: [4, 11], step: 0.02, rows: Rows::Shifted };
        assert!(shifted.has_ends() && !straight.has_ends());
        for (circles, radius) in [(straight, 0.008), (shifted, 0.0075)] {
            // The order is that of the board: a quarter turn to either side leaves the first circle of straight rows nearest to the image's first corner.
            for (turn, far) in [([0.0, 0.0, 0.1], 0.35), ([0.6, 0.0, -0.2], 0.33), ([-0.3, 0.55, 0.1], 0.36)]
            {
                let (image, truth) = photo(&circles, radius, turn, far);
                let off = off(&circles, &image, &truth);
                // Without the correction it is up to 0.15 pixels.
                assert!(off < 0.04, "{circles:?} {turn:?}: {off}");
            }
        }
        // Shifted rows tell the board's ends apart, however it is turned.
        let (image, truth) = photo(&shifted, 0.0075, [0.2, 0.3, 2.5], 0.36);
        assert!(off(&shifted, &image, &truth) < 0.04);
    }

    #[test]
    fn a_grid_that_leaves_the_image_or_has_other_circles_is_told() {
        let circles = Circles { count: [7, 6], step: 0.025, rows: Rows::Straight };
        let (image, _) = photo(&circles, 0.008, [0.0, 0.0, 0.1], 0.35);
        let grey = Grey::new(SIZE[0], SIZE[1], &image).expect("an image");
        let larger = Circles { count: [8, 6], ..circles };
        assert_eq!(larger.seen(&grey), Err(NoBoard::Circles { found: 42, wanted: 48 }));
        let white = vec![200; SIZE[0] * SIZE[1]];
        let nothing = Grey::new(SIZE[0], SIZE[1], &white).expect("an image");
        assert_eq!(circles.seen(&nothing), Err(NoBoard::Nothing));
    }
}
