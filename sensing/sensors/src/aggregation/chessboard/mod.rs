//! The corners of a chessboard in an image, for the calibration of a camera.
//!
//! In: a grey image, and how many inner corners the board has. Out: where each of them is \[pixel\], to some hundredths of a pixel.
//!
//! A corner is a saddle of the grey values: dark and bright quarters around it. Saddles ([`saddles`](saddles)) are joined to a grid along the edges that
//! leave them ([`grid`](grid)), which alternate: what is bright to the left of an edge at one corner is bright to the left of it at the next one, where it
//! leaves in the opposite direction. Each corner is then moved to where the gradients around it point ([`refine`](refine)).

mod grey;
mod grid;
mod refine;
mod saddles;

use nalgebra::{Vector2, Vector3};

pub use grey::Grey;
use grey::Smooth;
pub use refine::refine;

/// A chessboard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Inner corners, where two dark squares meet: along x and along y of the board, each at least 2.
    pub corners: [usize; 2],
    /// The side of a square \[m\], > 0.
    pub square: f64,
}

/// Why no board was found in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoBoard {
    /// There is no grid of corners.
    #[error(
        "no chessboard is seen: light it evenly, keep a white rim around it, and hold it so that all of it is in the image"
    )]
    Nothing,
    /// The largest grid is another one.
    #[error(
        "{found} corners of a chessboard are seen, in a grid of {across} by {down}, and not {wanted}: count inner corners, where two dark squares meet, and keep all of the board in the image"
    )]
    Other {
        /// Corners seen.
        found: usize,
        /// In the longer direction.
        across: usize,
        /// In the other one.
        down: usize,
        /// Corners of the board.
        wanted: usize,
    },
    /// Too few markers of a ChArUco board are seen.
    #[error(
        "{found} markers of the board are seen, of {wanted}: compare the number of squares and the dictionary, light it evenly, and keep a white rim around it"
    )]
    Markers {
        /// Markers that are where a board has them.
        found: usize,
        /// Those of the board.
        wanted: usize,
    },
    /// A part of a ChArUco board is not in the image.
    #[error("a part of the board is not in the image: hold it so that all of its corners are")]
    Leaves,
    /// The largest grid of circles is another one.
    #[error(
        "{found} circles of a grid are seen together, and not {wanted}: count circles in a row, and rows (of OpenCV's asymmetric grid 4x11), and keep all of the board in the image"
    )]
    Circles {
        /// Circles seen.
        found: usize,
        /// Circles of the grid.
        wanted: usize,
    },
}

/// The longest side of an image in which corners are looked for first \[pixel\]: larger ones are halved until they are so small.
const COARSE: usize = 800;

/// A corner is refined in a window that reaches so far to the next corner, as a share of that distance; and at most [`WINDOW`] pixels.
const REACH: f64 = 0.3;
const WINDOW: usize = 11;

impl Board {
    /// Reads `9x6:25mm`: inner corners along both sides, and the side of a square.
    ///
    /// # Errors
    /// What to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let read = || {
            let (corners, square) = text.split_once(':')?;
            let (across, down) = corners.split_once('x')?;
            let (number, factor) = match square.strip_suffix("mm") {
                Some(number) => (number, 1e-3),
                None => (square.strip_suffix('m')?, 1.0),
            };
            let number: f64 = number.trim().parse().ok()?;
            let corners = [across.trim().parse().ok()?, down.trim().parse().ok()?];
            let sane = number > 0.0 && number.is_finite() && corners.iter().all(|n| (2..=200).contains(n));
            sane.then_some(Self { corners, square: number * factor })
        };
        read().ok_or_else(|| {
            format!(
                "`{text}` is no board\n help: write inner corners and the side of a square, such as 9x6:25mm"
            )
        })
    }

    /// Whether a view tells which end of the board is which: of one that has an even number of corners along one side and an odd one along the other.
    #[must_use]
    pub const fn has_ends(&self) -> bool {
        (self.corners[0] + self.corners[1]) % 2 == 1
    }

    /// Where the corners are on the board \[m\], row by row along x; z points away from who looks at it.
    pub fn points(&self) -> impl Iterator<Item = Vector3<f64>> {
        let Self { corners: [across, down], square } = *self;
        (0..down).flat_map(move |j| {
            (0..across).map(move |i| Vector3::new(i as f64 * square, j as f64 * square, 0.0))
        })
    }

    /// Where they are in an image \[pixel\], in the order of [`Board::points`]; the middle of the first pixel is (0, 0).
    ///
    /// The first corner is that at which the square at the board's own corner is dark, if the board [has ends](Board::has_ends); otherwise that nearest to
    /// the image's.
    ///
    /// # Errors
    /// [`NoBoard`].
    pub fn seen(&self, image: &Grey<'_>) -> Result<Vec<Vector2<f64>>, NoBoard> {
        let mut level = Smooth::of(image);
        let (mut levels, mut scale) = (Vec::new(), 1.0_f64);
        while level.width.max(level.height) > COARSE {
            let half = level.halved();
            levels.push((level, scale));
            (level, scale) = (half, scale * 2.0);
        }
        levels.push((level, scale));
        let mut why = NoBoard::Nothing;
        for (level, scale) in levels.iter().rev() {
            match grid::seen(self, level) {
                Ok(coarse) => {
                    let fine = |at: &Vector2<f64>| at * *scale + Vector2::repeat(0.5 * (scale - 1.0));
                    let coarse: Vec<Vector2<f64>> = coarse.iter().map(fine).collect();
                    return Ok(self.refined(image, &coarse));
                }
                Err(NoBoard::Nothing) => {}
                Err(other) => why = other,
            }
        }
        Err(why)
    }

    fn refined(&self, image: &Grey<'_>, coarse: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        let [across, down] = self.corners;
        let one = |index: usize| {
            let (i, j) = (index % across, index / across);
            let apart = |other: usize| (coarse[other] - coarse[index]).norm();
            let sides = [
                (i > 0).then(|| apart(index - 1)),
                (i + 1 < across).then(|| apart(index + 1)),
                (j > 0).then(|| apart(index - across)),
                (j + 1 < down).then(|| apart(index + across)),
            ];
            let least = sides.into_iter().flatten().fold(f64::INFINITY, f64::min);
            refine(image, &coarse[index], ((REACH * least) as usize).clamp(2, WINDOW))
        };
        (0..coarse.len()).map(one).collect()
    }
}
