//! Square markers with a number each, as ArUco has them (Garrido-Jurado et al. 2014).
//!
//! A marker is a dark square on white, with a dark border and bits inside. Dark regions that have four corners are read as one: each bit where the homography from the square to the
//! corners says, and in all four turns.

use nalgebra::Vector2;

use crate::aggregation::chessboard::Grey;
use crate::aggregation::dark::dark_regions;
use crate::aggregation::homography::homography;

/// The dictionaries; the script that wrote them is `charuco.py` beside the tests of `mrroc-calibration`.
const MARKERS: &str = include_str!("markers.txt");

/// How many markers a dictionary may have.
const COUNTS: [usize; 4] = [50, 100, 250, 1000];

/// The mean around a pixel is that of a square with this share of the image's longer side.
const AROUND: [usize; 3] = [8, 20, 50];

/// Pixels of a marker at least, and of its sides.
const LEAST: usize = 60;
const SIDE: f64 = 8.0;

/// Of a region's pixels this share at least must lie between its four corners.
const SQUARE: f64 = 0.97;

/// Bits of a number, and cells of the border, that may be read wrongly.
const WRONG_BITS: u32 = 1;
const WRONG_BORDER: usize = 1;

/// Which numbers there are, and how they are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dictionary {
    /// Bits along a side: 4 to 7.
    side: usize,
    /// How many markers.
    count: usize,
}

impl Dictionary {
    /// That of one of OpenCV's names, such as `DICT_5X5_100`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let name = name.to_ascii_uppercase();
        let (size, count) = name.trim_start_matches("DICT_").split_once('_')?;
        let (side, other) = size.split_once('X')?;
        let (side, count): (usize, usize) = (side.parse().ok()?, count.parse().ok()?);
        let is_known = side.to_string() == other && (4..=7).contains(&side) && COUNTS.contains(&count);
        is_known.then_some(Self { side, count })
    }

    /// Its markers' bits, row by row, the last one lowest.
    fn markers(&self) -> Vec<u64> {
        let own = MARKERS.lines().find_map(|line| line.strip_prefix(&format!("{} ", self.side)));
        let words = own.unwrap_or_default().split(' ').take(self.count);
        words.filter_map(|word| u64::from_str_radix(word, 16).ok()).collect()
    }
}

/// A marker that is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marker {
    pub(super) number: usize,
    /// Its corners \[pixel\], from its own first one on, clockwise.
    pub(super) corners: [Vector2<f64>; 4],
}

/// All markers in an image, each number once.
pub(super) fn seen_markers(image: &Grey<'_>, dictionary: &Dictionary) -> Vec<Marker> {
    let known = dictionary.markers();
    let mut markers: Vec<Marker> = Vec::new();
    for around in AROUND {
        for region in dark_regions(image, image.width.max(image.height) / around) {
            let read =
                corners(image.width, &region).and_then(|corners| read(image, &corners, dictionary, &known));
            if let Some(marker) = read
                && markers.iter().all(|other| other.number != marker.number)
            {
                markers.push(marker);
            }
        }
    }
    markers
}

/// The corners of a region that has four, clockwise.
fn corners(width: usize, region: &[usize]) -> Option<[Vector2<f64>; 4]> {
    if region.len() < LEAST {
        return None;
    }
    let all: Vec<Vector2<f64>> =
        region.iter().map(|i| Vector2::new((i % width) as f64, (i / width) as f64)).collect();
    let middle = all.iter().sum::<Vector2<f64>>() / all.len() as f64;
    let most = |of: &dyn Fn(&Vector2<f64>) -> f64| {
        all.iter().max_by(|a, b| of(a).total_cmp(&of(b))).copied().unwrap_or(middle)
    };
    let a = most(&|at| (at - middle).norm());
    let c = most(&|at| (at - a).norm());
    let across = c - a;
    let b = most(&|at| -across.perp(&(at - a)));
    let d = most(&|at| across.perp(&(at - a)));
    // Half a pixel outwards: corners are those of pixels, and not their middles.
    let corners = [a, b, c, d].map(|corner| corner + (corner - middle).normalize() * 0.7);
    let sides = |i: usize| corners[(i + 1) % 4] - corners[i];
    if (0..4).any(|i| sides(i).norm() < SIDE || sides(i).perp(&sides((i + 1) % 4)) <= 0.0) {
        return None;
    }
    let is_in =
        |at: &&Vector2<f64>| (0..4).all(|i| sides(i).perp(&(*at - corners[i])) >= -1.5 * sides(i).norm());
    let share = all.iter().filter(is_in).count() as f64 / all.len() as f64;
    (share >= SQUARE).then_some(corners)
}

/// What is written between these corners.
fn read(
    image: &Grey<'_>,
    corners: &[Vector2<f64>; 4],
    dictionary: &Dictionary,
    known: &[u64],
) -> Option<Marker> {
    let (side, cells) = (dictionary.side, dictionary.side + 2);
    let size = cells as f64;
    let square = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]].map(Vector2::from);
    let plane = homography(&square, corners)?;
    let cell = |x: usize, y: usize| {
        let part = |k: usize| {
            let off = Vector2::new((k % 3) as f64, (k / 3) as f64) * 0.2 + Vector2::repeat(0.3);
            let there = plane * (Vector2::new(x as f64, y as f64) + off).push(1.0);
            image.at(&(there.xy() / there.z))
        };
        (0..9).map(part).sum::<f64>() / 9.0
    };
    let grey: Vec<f64> = (0..cells * cells).map(|i| cell(i % cells, i / cells)).collect();
    let (least, most) = grey.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), one| (a.min(*one), b.max(*one)));
    let is_white = |x: usize, y: usize| grey[y * cells + x] > 0.5 * (least + most);
    let at_border = |i: usize| [0, cells - 1].contains(&(i % cells)) || [0, cells - 1].contains(&(i / cells));
    let wrong = (0..cells * cells).filter(|i| at_border(*i) && is_white(i % cells, i / cells)).count();
    if wrong > WRONG_BORDER {
        return None;
    }
    for turn in 0..4 {
        let bit = |column: usize, row: usize| {
            // Begun at the corner of this number: to the right there is downwards here.
            let (mut x, mut y) = (column, row);
            for _ in 0..turn {
                (x, y) = (side - 1 - y, x);
            }
            u64::from(is_white(x + 1, y + 1))
        };
        let bits = (0..side * side).fold(0, |bits, i| bits << 1 | bit(i % side, i / side));
        // A large dictionary of small markers has no bit to spare.
        let most = if dictionary.side == 4 && dictionary.count == 1000 { 0 } else { WRONG_BITS };
        let nearest = known.iter().enumerate().min_by_key(|(_, own)| (*own ^ bits).count_ones());
        if let Some((number, own)) = nearest
            && (own ^ bits).count_ones() <= most
        {
            let corners = core::array::from_fn(|i| corners[(i + turn) % 4]);
            return Some(Marker { number, corners });
        }
    }
    None
}
