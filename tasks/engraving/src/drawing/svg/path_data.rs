//! Path data (`d`) into chains of exact pieces, one per subpath.

use crate::drawing::{EllipticalArc, Piece, Vec2};
use svgtypes::PathSegment;

/// The pen while path data is drawn.
#[derive(Default)]
struct Pen {
    at: Vec2,
    start: Vec2,
    /// The last control point of a curve, for the smooth commands.
    cubic: Option<Vec2>,
    quadratic: Option<Vec2>,
    chain: Vec<Piece>,
    chains: Vec<Vec<Piece>>,
    /// Pieces of the chains that are complete.
    lifted: usize,
}

/// The subpaths of path data, and where the data is wrong, if it is: a byte and a reason.
///
/// # Errors
/// The byte offset in the attribute and what svgtypes says of it.
///
/// Reading stops soon after `most` pieces: the caller counts them and refuses.
pub fn chains(data: &str, most: usize) -> Result<Vec<Vec<Piece>>, (usize, String)> {
    let mut pen = Pen::default();
    for segment in svgtypes::PathParser::from(data) {
        pen.draw(segment.map_err(|e| (error_offset(&e), e.to_string()))?);
        if pen.lifted + pen.chain.len() > most {
            break;
        }
    }
    pen.lift();
    Ok(pen.chains)
}

/// The byte offset that svgtypes reports.
fn error_offset(error: &svgtypes::Error) -> usize {
    let text = error.to_string();
    let digits = text.rsplit(' ').next().unwrap_or("");
    digits.trim_matches(|c: char| !c.is_ascii_digit()).parse::<usize>().unwrap_or(1).saturating_sub(1)
}

impl Pen {
    fn lift(&mut self) {
        if !self.chain.is_empty() {
            self.lifted += self.chain.len();
            self.chains.push(std::mem::take(&mut self.chain));
        }
    }

    fn to(&self, abs: bool, x: f64, y: f64) -> Vec2 {
        let p = Vec2::new(x, y);
        if abs { p } else { self.at + p }
    }

    fn line(&mut self, to: Vec2) {
        self.chain.push(Piece::Line { from: self.at, to });
        self.moved(to, None, None);
    }

    fn cubic(&mut self, b: Vec2, c: Vec2, to: Vec2) {
        self.chain.push(Piece::Cubic([self.at, b, c, to]));
        self.moved(to, Some(c), None);
    }

    fn quadratic(&mut self, b: Vec2, to: Vec2) {
        self.chain.push(Piece::quadratic(self.at, b, to));
        self.moved(to, None, Some(b));
    }

    fn moved(&mut self, to: Vec2, cubic: Option<Vec2>, quadratic: Option<Vec2>) {
        (self.at, self.cubic, self.quadratic) = (to, cubic, quadratic);
    }

    fn draw(&mut self, segment: PathSegment) {
        match segment {
            PathSegment::MoveTo { abs, x, y } => {
                self.lift();
                let to = self.to(abs, x, y);
                self.start = to;
                self.moved(to, None, None);
            }
            PathSegment::LineTo { abs, x, y } => self.line(self.to(abs, x, y)),
            PathSegment::HorizontalLineTo { abs, x } => {
                let x = if abs { x } else { self.at.x + x };
                self.line(Vec2::new(x, self.at.y));
            }
            PathSegment::VerticalLineTo { abs, y } => {
                let y = if abs { y } else { self.at.y + y };
                self.line(Vec2::new(self.at.x, y));
            }
            PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                self.cubic(self.to(abs, x1, y1), self.to(abs, x2, y2), self.to(abs, x, y));
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                let b = self.cubic.map_or(self.at, |c| self.at * 2.0 - c);
                self.cubic(b, self.to(abs, x2, y2), self.to(abs, x, y));
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                self.quadratic(self.to(abs, x1, y1), self.to(abs, x, y));
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                let b = self.quadratic.map_or(self.at, |c| self.at * 2.0 - c);
                self.quadratic(b, self.to(abs, x, y));
            }
            PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                let to = self.to(abs, x, y);
                let radii = Vec2::new(rx, ry);
                let turn = x_axis_rotation.to_radians();
                match EllipticalArc::from_endpoints(self.at, to, radii, turn, large_arc, sweep) {
                    Some(arc) => {
                        self.chain.push(Piece::Arc(arc));
                        self.moved(to, None, None);
                    }
                    None => self.line(to),
                }
            }
            PathSegment::ClosePath { .. } => {
                self.line(self.start);
                self.lift();
            }
        }
    }
}
