//! The patterns by which cameras are calibrated: a chessboard, a grid of circles, or a ChArUco board.

use core::fmt;

use nalgebra::{Vector2, Vector3};

use super::charuco::{Charuco, Dictionary};
use super::chessboard::{Board, Grey, NoBoard};
use super::circles::{Circles, Rows};

/// A board with a pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// A chessboard: its inner corners.
    Chessboard(Board),
    /// A grid of circles: their middles.
    Circles(Circles),
    /// A ChArUco board: its inner corners.
    Charuco(Charuco),
}

impl From<&Charuco> for Pattern {
    fn from(charuco: &Charuco) -> Self {
        Self::Charuco(*charuco)
    }
}

impl From<&Board> for Pattern {
    fn from(board: &Board) -> Self {
        Self::Chessboard(*board)
    }
}

impl From<&Circles> for Pattern {
    fn from(circles: &Circles) -> Self {
        Self::Circles(*circles)
    }
}

impl From<&Pattern> for Pattern {
    fn from(pattern: &Pattern) -> Self {
        *pattern
    }
}

impl Pattern {
    /// Reads `9x6:25mm` (a chessboard), `circles:7x6:25mm`, `asymmetric-circles:4x11:20mm`, or `charuco:8x6:30mm:22mm:DICT_5X5_100`.
    ///
    /// # Errors
    /// What to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let of = |rest: &str, rows: Rows| {
            // Written as a chessboard is.
            let Board { corners, square } = Board::parse(rest).ok()?;
            Some(Self::Circles(Circles { count: corners, step: square, rows }))
        };
        let read = match text.split_once(':') {
            Some(("circles", rest)) => of(rest, Rows::Straight),
            Some(("asymmetric-circles", rest)) => of(rest, Rows::Shifted),
            Some(("charuco", rest)) => charuco(rest),
            _ => Board::parse(text).ok().map(Self::Chessboard),
        };
        read.ok_or_else(|| {
            format!(
                "`{text}` is no board\n help: write the inner corners of a chessboard and the side of a square, such as 9x6:25mm; or circles in a row, rows, and from one row to the next, such as \
                 circles:7x6:25mm, or asymmetric-circles:4x11:20mm if every second row is shifted; or the squares of a ChArUco board, the sides of a square and of a marker, and the dictionary: \
                 charuco:8x6:30mm:22mm:DICT_5X5_100"
            )
        })
    }

    /// Where its points are on the board \[m\]; z points away from who looks at it.
    #[must_use]
    pub fn points(&self) -> Vec<Vector3<f64>> {
        match self {
            Self::Chessboard(board) => board.points().collect(),
            Self::Circles(circles) => circles.points().collect(),
            Self::Charuco(charuco) => charuco.points().collect(),
        }
    }

    /// Where they are in an image \[pixel\], in the same order.
    ///
    /// # Errors
    /// [`NoBoard`].
    pub fn seen(&self, image: &Grey<'_>) -> Result<Vec<Vector2<f64>>, NoBoard> {
        match self {
            Self::Chessboard(board) => board.seen(image),
            Self::Circles(circles) => circles.seen(image),
            Self::Charuco(charuco) => charuco.seen(image),
        }
    }

    /// Whether a view tells which end of it is which.
    #[must_use]
    pub const fn has_ends(&self) -> bool {
        match self {
            Self::Chessboard(board) => board.has_ends(),
            Self::Circles(circles) => circles.has_ends(),
            Self::Charuco(_) => true,
        }
    }

    /// Its points along x and along y; of shifted rows those of each row.
    #[must_use]
    pub const fn count(&self) -> [usize; 2] {
        match self {
            Self::Chessboard(board) => board.corners,
            Self::Circles(circles) => circles.count,
            Self::Charuco(charuco) => [charuco.squares[0] - 1, charuco.squares[1] - 1],
        }
    }

    /// The side of a square, or from one row of circles to the next \[m\].
    #[must_use]
    pub const fn step(&self) -> f64 {
        match self {
            Self::Chessboard(board) => board.square,
            Self::Circles(circles) => circles.step,
            Self::Charuco(charuco) => charuco.square,
        }
    }

    /// The same pattern in another size.
    #[must_use]
    pub fn with_step(self, step: f64) -> Self {
        match self {
            Self::Chessboard(board) => Self::Chessboard(Board { square: step, ..board }),
            Self::Circles(circles) => Self::Circles(Circles { step, ..circles }),
            Self::Charuco(charuco) => {
                let marker = charuco.marker * step / charuco.square;
                Self::Charuco(Charuco { square: step, marker, ..charuco })
            }
        }
    }

    /// What its step is called.
    #[must_use]
    pub const fn step_name(&self) -> &'static str {
        match self {
            Self::Chessboard(_) | Self::Charuco(_) => "a square of the board",
            Self::Circles(_) => "a step from row to row of the board",
        }
    }
}

/// Such as `8x6:30mm:22mm:DICT_5X5_100`.
fn charuco(text: &str) -> Option<Pattern> {
    let (rest, name) = text.rsplit_once(':')?;
    let (squares, marker) = rest.rsplit_once(':')?;
    let Board { corners, square } = Board::parse(squares).ok()?;
    // Written as a board of any size is.
    let Board { square: marker, .. } = Board::parse(&format!("3x3:{marker}")).ok()?;
    let sane = marker < square && corners.iter().all(|count| *count >= 3);
    let dictionary = Dictionary::named(name)?;
    sane.then_some(Pattern::Charuco(Charuco { squares: corners, square, marker, dictionary }))
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [across, down] = self.count();
        match self {
            Self::Chessboard(_) => write!(f, "{across} x {down} corners"),
            Self::Charuco(_) => write!(f, "{across} x {down} corners between markers"),
            Self::Circles(Circles { rows: Rows::Straight, .. }) => write!(f, "{across} x {down} circles"),
            Self::Circles(Circles { rows: Rows::Shifted, .. }) => {
                write!(f, "{across} x {down} circles in shifted rows")
            }
        }
    }
}
