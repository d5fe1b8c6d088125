//! Two views of a robot: from the side (x to the right, z up) and from above (x to the right, y up).

use std::collections::BTreeSet;

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc_pictures::svg::{Area, Look, Page, Svg, TextStyle, palette};
use mrroc_robots::Kinematics;
use nalgebra::{SVector, Vector2, Vector3};

/// Pixels per metre for an arm; ten times as many for a gripper. All lengths of the drawing scale with it.
const SCALE: f64 = 220.0;
/// Edge of a cell of the workspace slice \[m\].
const CELL: f64 = 0.03;
/// Thickness of the slice \[m\].
const THICKNESS: f64 = 0.08;
/// Distance of the lines of the grid \[m\].
const GRID: f64 = 0.5;
/// Length of the axes of a frame \[m\].
const AXIS: f64 = 0.1;
/// Largest coordinate that is drawn, in either direction \[m\].
const FARTHEST: f64 = 2.5;
/// Joint positions tried for the workspace.
const SAMPLES: usize = 3_000_000;
/// Margin around a view \[px\].
const MARGIN: f64 = 40.0;
/// Room above the views \[px\].
const HEADING: f64 = 90.0;

/// A straight part of the robot.
pub struct Line {
    from: Vector3<f64>,
    to: Vector3<f64>,
    look: Look,
}

impl Line {
    pub fn link(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        Self { from, to, look: Look::line(palette::INK, 5.0).round().class("link") }
    }

    pub fn actuator(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        Self { from, to, look: Look::line(palette::joint(1), 4.0).class("actuator") }
    }
}

/// What is drawn.
pub struct Scene {
    pub title: String,
    pub measures: String,
    pub lines: Vec<Line>,
    pub frames: Vec<Pose>,
    /// Size of the robot, as a multiple of an arm's: 1 or 0.1.
    pub size: f64,
}

/// The size of a robot with that reach \[m\].
pub fn size(reach: f64) -> f64 {
    if reach < 0.3 { 0.1 } else { 1.0 }
}

/// The coordinates that a view shows to the right and upwards, and the one across its slice.
#[derive(Clone, Copy)]
struct View {
    name: &'static str,
    axes: [usize; 3],
}

const VIEWS: [View; 2] =
    [View { name: "side: x, z [m]", axes: [0, 2, 1] }, View { name: "above: x, y [m]", axes: [0, 1, 2] }];

/// The workspace: positions of the flange for attainable joints, drawn evenly from their limits with a stated seed.
pub fn flange_positions<const N: usize, R: Kinematics<N>>(robot: &R) -> Vec<Vector3<f64>> {
    let (lower, upper) = (robot.limits().lower, robot.limits().upper);
    let mut random = Random::seeded(11);
    (0..SAMPLES)
        .map(|_| SVector::<f64, N>::from_fn(|i, _| random.between(lower[i], upper[i])))
        .filter(|q| robot.is_attainable(q))
        .map(|q| robot.forward(&q).translation.vector)
        .filter(|p| p.amax() < FARTHEST)
        .collect()
}

/// Where a view stands on the page, and what it shows.
struct Placed {
    view: View,
    /// The least and the greatest coordinates that it shows \[m\].
    lower: Vector3<f64>,
    upper: Vector3<f64>,
    /// Its left side \[px\].
    left: f64,
    /// [px/m]
    scale: f64,
}

impl Placed {
    fn at(&self, point: &Vector3<f64>) -> Vector2<f64> {
        let [right, up, _] = self.view.axes;
        let across = (point[right] - self.lower[right]) * self.scale;
        let down = (self.upper[up] - point[up]) * self.scale;
        Vector2::new(self.left + across, HEADING + down)
    }

    fn width(&self) -> f64 {
        let right = self.view.axes[0];
        (self.upper[right] - self.lower[right]) * self.scale
    }

    fn height(&self) -> f64 {
        let up = self.view.axes[1];
        (self.upper[up] - self.lower[up]) * self.scale
    }
}

impl Scene {
    /// The drawing, with the cells of the planes through the flange that hold one of `positions`.
    pub fn svg(&self, positions: &[Vector3<f64>]) -> String {
        let here = self.flange();
        let mut lower = Vector3::zeros();
        let mut upper = Vector3::zeros();
        for p in positions.iter().chain(self.lines.iter().flat_map(|line| [&line.from, &line.to])) {
            lower = lower.inf(p);
            upper = upper.sup(p);
        }
        // Space for a frame at every end.
        let around = Vector3::repeat(AXIS * self.size);
        lower = lower.inf(&(here - around));
        upper = upper.sup(&(here + around));
        let scale = SCALE / self.size;
        let [side, above] = VIEWS.map(|view| Placed { view, lower, upper, left: MARGIN, scale });
        let above = Placed { left: MARGIN + side.width() + 2.0 * MARGIN, ..above };
        let views = [side, above];
        // Room for the lines above the views.
        let width = (views[1].left + views[1].width() + 2.0 * MARGIN).max(820.0);
        let height = HEADING + views[0].height().max(views[1].height()) + MARGIN;
        let legend = format!(
            "{}; axes x red, y green, z blue; grid {} m; shaded: where the flange gets to",
            self.measures,
            GRID * self.size
        );
        Page::new(&self.title, width.round(), height.round()).draw(|svg| {
            let style = TextStyle::new(13.0, palette::INK);
            svg.text(Vector2::new(MARGIN, 24.0), style, &self.title);
            svg.text(Vector2::new(MARGIN, 44.0), style, &legend);
            for view in &views {
                self.draw(svg, view, positions);
                let depth = view.view.axes[2];
                let slice = ["x", "y", "z"][depth];
                let text = format!("{}; slice at {slice} = {:.3} m", view.view.name, here[depth]);
                svg.text(Vector2::new(view.left, 72.0), style, &text);
            }
        })
    }

    /// Where the flange is \[m\].
    fn flange(&self) -> Vector3<f64> {
        self.frames.last().map_or(Vector3::zeros(), |flange| flange.translation.vector)
    }

    fn draw(&self, svg: &mut Svg, on: &Placed, positions: &[Vector3<f64>]) {
        self.draw_slice(svg, on, positions);
        self.draw_grid(svg, on);
        for line in &self.lines {
            svg.line(on.at(&line.from), on.at(&line.to), line.look);
        }
        for frame in &self.frames {
            let origin = frame.translation.vector;
            let joint = Look::filled(palette::WHITE).stroke(palette::INK).width(1.5).class("joint");
            svg.circle(on.at(&origin), 4.0, joint);
            for (axis, colour) in [Vector3::x(), Vector3::y(), Vector3::z()].iter().zip(palette::FRAME) {
                let tip = origin + frame.rotation * axis * (AXIS * self.size);
                svg.line(on.at(&origin), on.at(&tip), Look::line(colour, 2.0));
            }
        }
    }

    /// The cells of the plane through the flange that hold a position.
    fn draw_slice(&self, svg: &mut Svg, on: &Placed, positions: &[Vector3<f64>]) {
        let [right, up, depth] = on.view.axes;
        let here = self.flange();
        let slice = positions.iter().filter(|p| (p[depth] - here[depth]).abs() < 0.5 * THICKNESS * self.size);
        let edge = CELL * self.size;
        let cell = |p: &Vector3<f64>| ((p[right] / edge).floor() as i64, (p[up] / edge).floor() as i64);
        let cells: BTreeSet<(i64, i64)> = slice.map(cell).collect();
        svg.group(Look::filled(palette::REGION), |svg| {
            for (i, j) in cells {
                let mut corner = Vector3::zeros();
                corner[right] = i as f64 * edge;
                corner[up] = (j + 1) as f64 * edge;
                let at = on.at(&corner);
                let area = Area { x: at.x, y: at.y, width: edge * on.scale, height: edge * on.scale };
                svg.rectangle(area, 0.0, Look::new().class("cell"));
            }
        });
    }

    /// Lines at round coordinates, and the coordinates.
    fn draw_grid(&self, svg: &mut Svg, on: &Placed) {
        let [right, up, _] = on.view.axes;
        let grid = GRID * self.size;
        for along in [right, up] {
            let first = (on.lower[along] / grid).ceil() as i32;
            let last = (on.upper[along] / grid).floor() as i32;
            for k in first..=last {
                let mut from = on.lower;
                let mut to = on.upper;
                from[along] = f64::from(k) * grid;
                to[along] = f64::from(k) * grid;
                svg.line(on.at(&from), on.at(&to), Look::line(palette::RULE, 0.5).class("grid"));
                let label = ((f64::from(k) * grid * 100.0).round() / 100.0).to_string();
                let below = on.at(&from) + Vector2::new(0.0, 12.0);
                svg.text(below, TextStyle::new(11.0, palette::GREY), &label);
            }
        }
    }
}
