//! Mazes in the text format of micromouse contests.
//!
//! ```text
//! o---o---o     posts `o`, four columns apart
//! | S     |     walls `---` and `|`, cells three columns wide
//! o   o---o
//! |     G |     `S` one cell, `G` the cells of the goal, which form a rectangle
//! o---o---o
//! ```
//!
//! In: text. Out: which walls there are, the start and the goal; or line and column of what is wrong.

use core::fmt;
use core::str::FromStr;

/// A maze of square cells. Cell `(0, 0)` is at the lower left, its column first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    columns: usize,
    rows: usize,
    /// By row of walls from below, `rows + 1` of them, each of `columns`.
    level: Vec<bool>,
    /// By row from below, each of `columns + 1`.
    upright: Vec<bool>,
    start: (usize, usize),
    goal: Goal,
}

/// The cells of the goal: a rectangle of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Goal {
    /// The cell at its lower left.
    pub lower: (usize, usize),
    /// The cell at its upper right.
    pub upper: (usize, usize),
}

/// What is wrong with a text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {what}")]
pub struct LayoutError {
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What was expected there, and what to do.
    pub what: String,
}

/// No maze has more cells along a side: contests have 32 at most.
pub const LARGEST: usize = 256;

/// A side of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// +x.
    Right,
    /// +y.
    Up,
    /// -x.
    Left,
    /// -y.
    Down,
}

impl Side {
    /// All four, counterclockwise.
    pub const ALL: [Self; 4] = [Self::Right, Self::Up, Self::Left, Self::Down];

    /// Turned counterclockwise by so many quarters.
    #[must_use]
    pub const fn turned(self, quarters: usize) -> Self {
        Self::ALL[(self as usize + quarters) % 4]
    }
}

impl Layout {
    /// A maze without walls inside, of 1 to [`LARGEST`] cells along each side.
    ///
    /// # Panics
    /// With sides, a start or a goal out of range.
    #[must_use]
    pub fn open(columns: usize, rows: usize, start: (usize, usize), goal: Goal) -> Self {
        assert!((1..=LARGEST).contains(&columns) && (1..=LARGEST).contains(&rows), "sides out of range");
        assert!(start.0 < columns && start.1 < rows, "the start is outside");
        assert!(goal.upper.0 < columns && goal.upper.1 < rows, "the goal is outside");
        let level = (0..(rows + 1) * columns).map(|i| i < columns || i >= rows * columns).collect();
        let upright =
            (0..rows * (columns + 1)).map(|i| (i % (columns + 1)).is_multiple_of(columns)).collect();
        Self { columns, rows, level, upright, start, goal }
    }

    /// Cells along x.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Cells along y.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// The cell of the start.
    #[must_use]
    pub const fn start(&self) -> (usize, usize) {
        self.start
    }

    /// The cells of the goal.
    #[must_use]
    pub const fn goal(&self) -> Goal {
        self.goal
    }

    /// Whether a level wall goes from the post `(x, y)` to `(x + 1, y)`.
    #[must_use]
    pub fn has_level(&self, x: usize, y: usize) -> bool {
        x < self.columns && y <= self.rows && self.level[y * self.columns + x]
    }

    /// Whether an upright wall goes from the post `(x, y)` to `(x, y + 1)`.
    #[must_use]
    pub fn has_upright(&self, x: usize, y: usize) -> bool {
        x <= self.columns && y < self.rows && self.upright[y * (self.columns + 1) + x]
    }

    /// Whether there is a wall at this side of a cell.
    #[must_use]
    pub fn has_wall(&self, (x, y): (usize, usize), side: Side) -> bool {
        match side {
            Side::Right => self.has_upright(x + 1, y),
            Side::Up => self.has_level(x, y + 1),
            Side::Left => self.has_upright(x, y),
            Side::Down => self.has_level(x, y),
        }
    }

    /// Puts a wall at this side of a cell, or takes it away.
    pub fn set_wall(&mut self, (x, y): (usize, usize), side: Side, there: bool) {
        let (columns, beside) = (self.columns, self.columns + 1);
        match side {
            Side::Right => self.upright[y * beside + x + 1] = there,
            Side::Up => self.level[(y + 1) * columns + x] = there,
            Side::Left => self.upright[y * beside + x] = there,
            Side::Down => self.level[y * columns + x] = there,
        }
    }

    /// The cell beyond this side, if it is in the maze.
    #[must_use]
    pub fn beyond(&self, (x, y): (usize, usize), side: Side) -> Option<(usize, usize)> {
        match side {
            Side::Right => (x + 1 < self.columns).then_some((x + 1, y)),
            Side::Up => (y + 1 < self.rows).then_some((x, y + 1)),
            Side::Left => x.checked_sub(1).map(|x| (x, y)),
            Side::Down => y.checked_sub(1).map(|y| (x, y)),
        }
    }

    /// The cell beyond this side, if no wall is between.
    #[must_use]
    pub fn next(&self, cell: (usize, usize), side: Side) -> Option<(usize, usize)> {
        self.beyond(cell, side).filter(|_| !self.has_wall(cell, side))
    }

    /// How many walls meet at a post.
    #[must_use]
    pub fn walls_at(&self, x: usize, y: usize) -> usize {
        let left = x.checked_sub(1).is_some_and(|x| self.has_level(x, y));
        let below = y.checked_sub(1).is_some_and(|y| self.has_upright(x, y));
        [self.has_level(x, y), self.has_upright(x, y), left, below].iter().filter(|wall| **wall).count()
    }
}

impl Goal {
    /// Whether a cell is of it.
    #[must_use]
    pub fn contains(&self, (x, y): (usize, usize)) -> bool {
        (self.lower.0..=self.upper.0).contains(&x) && (self.lower.1..=self.upper.1).contains(&y)
    }
}

impl FromStr for Layout {
    type Err = LayoutError;

    fn from_str(text: &str) -> Result<Self, LayoutError> {
        let wrong = |line: usize, column: usize, what: String| {
            Err(LayoutError { line: line + 1, column: column + 1, what })
        };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines: Vec<Vec<char>> = Vec::new();
        for line in text.lines().take(2 * LARGEST + 3) {
            lines.push(line.trim_end().chars().take(4 * LARGEST + 3).collect());
        }
        while lines.last().is_some_and(Vec::is_empty) {
            lines.pop();
        }
        let Some(first) = lines.first() else {
            return wrong(0, 0, "nothing here: a maze begins with a row of posts, as in `o---o---o`".into());
        };
        let width = first.len();
        if width < 5 || width % 4 != 1 {
            let what =
                format!("a row of {width} characters: posts `o` are four columns apart, as in `o---o---o`");
            return wrong(0, width.saturating_sub(1), what);
        }
        if lines.len() < 3 || lines.len().is_multiple_of(2) {
            let what = format!(
                "{} rows: rows of posts and of cells take turns, and posts are first and last",
                lines.len()
            );
            return wrong(lines.len() - 1, 0, what);
        }
        let (columns, rows) = ((width - 1) / 4, (lines.len() - 1) / 2);
        if columns > LARGEST || rows > LARGEST {
            return wrong(0, 0, format!("{columns} by {rows} cells: at most {LARGEST} along a side"));
        }
        let mut layout = Self::open(columns, rows, (0, 0), Goal { lower: (0, 0), upper: (0, 0) });
        let (mut start, mut goals) = (None, Vec::new());
        for (number, line) in lines.iter().enumerate() {
            if line.len() > width {
                return wrong(
                    number,
                    width,
                    format!("the row goes on after column {width}, where the first one ends"),
                );
            }
            let at = |column: usize| line.get(column).copied().unwrap_or(' ');
            let group = |column: usize| [at(column), at(column + 1), at(column + 2)];
            let of_posts = number % 2 == 0;
            let y = rows - number.div_ceil(2);
            for x in 0..=columns {
                let column = 4 * x;
                match (of_posts, at(column)) {
                    (true, 'o' | '+') => {}
                    (true, other) => {
                        return wrong(number, column, format!("`{other}` where a post `o` must be"));
                    }
                    (false, '|') => layout.upright[y * (columns + 1) + x] = true,
                    (false, ' ') => layout.upright[y * (columns + 1) + x] = false,
                    (false, other) => {
                        return wrong(
                            number,
                            column,
                            format!("`{other}` where a wall `|` or a blank must be"),
                        );
                    }
                }
                if x == columns {
                    break;
                }
                match (of_posts, group(column + 1)) {
                    (true, ['-', '-', '-']) => layout.level[y * columns + x] = true,
                    (true | false, [' ', ' ', ' ']) if of_posts => layout.level[y * columns + x] = false,
                    (true, _) => {
                        return wrong(
                            number,
                            column + 1,
                            "a wall is `---`, and an opening three blanks".into(),
                        );
                    }
                    (false, [' ', inside, ' ']) => match inside {
                        ' ' => {}
                        'S' | 's' if start.is_some() => {
                            return wrong(number, column + 2, "a second start `S`: a maze has one".into());
                        }
                        'S' | 's' => start = Some((x, y)),
                        'G' | 'g' => goals.push((x, y)),
                        other => {
                            let what = format!("`{other}` in a cell: it may hold `S` or `G`");
                            return wrong(number, column + 2, what);
                        }
                    },
                    (false, _) => {
                        return wrong(
                            number,
                            column + 1,
                            "a cell is three columns wide: `S` or `G` is in its middle".into(),
                        );
                    }
                }
            }
        }
        let end = lines.len() - 1;
        layout.start = match start {
            Some(start) => start,
            None => return wrong(end, 0, "no start: write `S` into a cell".into()),
        };
        let mut goal = match goals.first() {
            Some(&cell) => Goal { lower: cell, upper: cell },
            None => {
                return wrong(
                    end,
                    0,
                    "no goal: write `G` into a cell, or into several that form a rectangle".into(),
                );
            }
        };
        for &(x, y) in &goals {
            goal.lower = (goal.lower.0.min(x), goal.lower.1.min(y));
            goal.upper = (goal.upper.0.max(x), goal.upper.1.max(y));
        }
        let cells = (goal.upper.0 - goal.lower.0 + 1) * (goal.upper.1 - goal.lower.1 + 1);
        if cells != goals.len() {
            let what = format!("the {} cells `G` of the goal form no rectangle", goals.len());
            return wrong(end, 0, what);
        }
        layout.goal = goal;
        for x in 0..columns {
            for (y, line) in [(0, end), (rows, 0)] {
                if !layout.has_level(x, y) {
                    return wrong(
                        line,
                        4 * x + 1,
                        "the maze is open here: write `---`, its frame is closed".into(),
                    );
                }
            }
        }
        for y in 0..rows {
            for x in [0, columns] {
                if !layout.has_upright(x, y) {
                    let line = 2 * (rows - y) - 1;
                    return wrong(
                        line,
                        4 * x,
                        "the maze is open here: write `|`, its frame is closed".into(),
                    );
                }
            }
        }
        Ok(layout)
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for y in (0..=self.rows).rev() {
            for x in 0..self.columns {
                f.write_str(if self.has_level(x, y) { "o---" } else { "o   " })?;
            }
            f.write_str("o\n")?;
            let Some(y) = y.checked_sub(1) else { break };
            for x in 0..self.columns {
                f.write_str(if self.has_upright(x, y) { "|" } else { " " })?;
                f.write_str(match (x, y) {
                    cell if cell == self.start => " S ",
                    cell if self.goal.contains(cell) => " G ",
                    _ => "   ",
                })?;
            }
            f.write_str("|\n")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "o---o---o\n| S     |\no   o---o\n|     G |\no---o---o\n";

    #[test]
    fn a_maze_is_read_as_it_is_drawn_and_written_as_it_was_read() {
        let maze: Layout = SMALL.parse().expect("a maze");
        assert_eq!((maze.columns(), maze.rows(), maze.start()), (2, 2, (0, 1)));
        assert_eq!(maze.goal(), Goal { lower: (1, 0), upper: (1, 0) });
        assert!(maze.has_wall((1, 1), Side::Down) && maze.has_wall((1, 0), Side::Up));
        assert!(!maze.has_wall((0, 1), Side::Right) && !maze.has_wall((0, 0), Side::Right));
        assert_eq!(maze.next((0, 1), Side::Down), Some((0, 0)));
        assert_eq!(maze.next((1, 1), Side::Down), None);
        assert_eq!(maze.to_string(), SMALL);
        assert_eq!(SMALL.replace('\n', "\r\n").parse(), Ok(maze));
    }

    #[test]
    fn what_is_wrong_is_told_with_line_and_column() {
        for (text, line, column, said) in [
            ("", 1, 1, "nothing here"),
            ("o--o\n", 1, 4, "four columns apart"),
            ("o---o\n", 1, 1, "take turns"),
            ("o---o\n|   |\nx---o\n", 3, 1, "`x` where a post"),
            ("o---o\n|   |\no- -o\n", 3, 2, "a wall is `---`"),
            ("o---o\n|  S|\no---o\n", 2, 2, "in its middle"),
            ("o---o\n| Q |\no---o\n", 2, 3, "`Q` in a cell"),
            ("o---o\n| G |\no---o\n", 3, 1, "no start"),
            ("o---o\n| S |\no---o\n", 3, 1, "no goal"),
            ("o---o---o\n| S   S |\no---o---o\n", 2, 7, "a second start"),
            ("o---o---o\n| S   G |\no---o   o\n", 3, 6, "open here"),
            ("o---o---o\n| S   G\no---o---o\n", 2, 9, "open here"),
            ("o---o---o\n| S   G |  x\no---o---o\n", 2, 10, "goes on"),
            ("o---o---o---o\n| G   S   G |\no---o---o---o\n", 3, 1, "no rectangle"),
        ] {
            let error = text.parse::<Layout>().expect_err(text);
            assert_eq!((error.line, error.column), (line, column), "{text}\n{error}");
            assert!(error.what.contains(said), "{text}\n{error}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(text in "[o+|SG \\-\n]{0,200}") {
            drop(text.parse::<Layout>());
        }
    }
}
