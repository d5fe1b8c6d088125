//! Two views of a robot as SVG: from the side (x to the right, z up) and from above (x to the right, y up).

use std::collections::BTreeSet;
use std::fmt::Write;

use mrroc::Pose;
use mrroc_robots::Kinematics;
use nalgebra::{SVector, Vector3};

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
/// Largest coordinate that is drawn, either way \[m\].
const FARTHEST: f64 = 2.5;
/// Joint positions tried for the workspace.
const SAMPLES: usize = 3_000_000;
/// Margin around a view \[px\].
const MARGIN: f64 = 40.0;

/// A straight part of the robot.
pub struct Line {
    from: Vector3<f64>,
    to: Vector3<f64>,
    class: &'static str,
}

impl Line {
    pub fn link(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        Self { from, to, class: "link" }
    }

    pub fn actuator(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        Self { from, to, class: "actuator" }
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
    let mut state = 11_u64;
    let mut unit = || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..SAMPLES)
        .map(|_| SVector::<f64, N>::from_fn(|i, _| lower[i] + (upper[i] - lower[i]) * unit()))
        .filter(|q| robot.is_attainable(q))
        .map(|q| robot.forward(&q).translation.vector)
        .filter(|p| p.amax() < FARTHEST)
        .collect()
}

impl Scene {
    /// The drawing, with the cells of the planes through the flange that hold one of `positions`.
    pub fn svg(&self, positions: &[Vector3<f64>]) -> String {
        let scale = SCALE / self.size;
        let here = self.frames.last().map_or(Vector3::zeros(), |flange| flange.translation.vector);
        let (mut lower, mut upper) = (Vector3::zeros(), Vector3::zeros());
        for p in positions.iter().chain(self.lines.iter().flat_map(|line| [&line.from, &line.to])) {
            lower = lower.inf(p);
            upper = upper.sup(p);
        }
        // Space for a frame at every end.
        let around = Vector3::repeat(AXIS * self.size);
        (lower, upper) = (lower.inf(&(here - around)), upper.sup(&(here + around)));
        let (mut views, mut left, mut bottom) = (String::new(), MARGIN, 0.0_f64);
        for view in VIEWS {
            let [right, up, depth] = view.axes;
            let height = (upper[up] - lower[up]) * scale;
            let place = |p: &Vector3<f64>| {
                (left + (p[right] - lower[right]) * scale, 90.0 + (upper[up] - p[up]) * scale)
            };
            let in_slice =
                positions.iter().filter(|p| (p[depth] - here[depth]).abs() < 0.5 * THICKNESS * self.size);
            self.view(&mut views, view, in_slice, place, (lower, upper));
            let _ = writeln!(
                views,
                r#"<text x="{left:.1}" y="72">{}; slice at {} = {:.3} m</text>"#,
                view.name,
                ["x", "y", "z"][depth],
                here[depth]
            );
            left += (upper[right] - lower[right]) * scale + 2.0 * MARGIN;
            bottom = bottom.max(90.0 + height + MARGIN);
        }
        // Space for the lines above the views.
        let left = left.max(820.0);
        let style = "text{font:13px sans-serif}.cell{fill:#dbe9f6}.grid{stroke:#ccc;stroke-width:.5}\
            .link{stroke:#333;stroke-width:5;stroke-linecap:round}.actuator{stroke:#c60;stroke-width:4}\
            .joint{fill:#fff;stroke:#333;stroke-width:1.5}.x{stroke:#d00}.y{stroke:#090}.z{stroke:#00d}\
            .x,.y,.z{stroke-width:2}";
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{left:.0}\" height=\"{bottom:.0}\">\n<style>{style}</style>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{MARGIN}\" y=\"24\">{}</text>\n\
             <text x=\"{MARGIN}\" y=\"44\">{}; axes x red, y green, z blue; grid {} m; shaded: where the flange gets to</text>\n\
             {views}</svg>\n",
            self.title,
            self.measures,
            GRID * self.size
        )
    }

    fn view<'a>(
        &self,
        out: &mut String,
        view: View,
        slice: impl Iterator<Item = &'a Vector3<f64>>,
        place: impl Fn(&Vector3<f64>) -> (f64, f64),
        (lower, upper): (Vector3<f64>, Vector3<f64>),
    ) {
        let [right, up, _] = view.axes;
        let edge = CELL * self.size;
        let cell = |p: &Vector3<f64>| ((p[right] / edge).floor() as i64, (p[up] / edge).floor() as i64);
        let cells: BTreeSet<(i64, i64)> = slice.map(cell).collect();
        for (i, j) in cells {
            let mut corner = Vector3::zeros();
            (corner[right], corner[up]) = (i as f64 * edge, (j + 1) as f64 * edge);
            let ((x, y), size) = (place(&corner), edge * SCALE / self.size);
            let _ = writeln!(
                out,
                r#"<rect class="cell" x="{x:.1}" y="{y:.1}" width="{size:.1}" height="{size:.1}"/>"#
            );
        }
        let segment = |out: &mut String, class: &str, from: &Vector3<f64>, to: &Vector3<f64>| {
            let ((x1, y1), (x2, y2)) = (place(from), place(to));
            let _ = writeln!(
                out,
                r#"<line class="{class}" x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}"/>"#
            );
        };
        for (along, across) in [(right, up), (up, right)] {
            let grid = GRID * self.size;
            for k in (lower[along] / grid).ceil() as i32..=(upper[along] / grid).floor() as i32 {
                let (mut from, mut to) = (lower, upper);
                (from[along], to[along]) = (f64::from(k) * grid, f64::from(k) * grid);
                (from[across], to[across]) = (lower[across], upper[across]);
                segment(out, "grid", &from, &to);
                let (x, y) = place(&from);
                let _ = writeln!(
                    out,
                    r##"<text x="{x:.1}" y="{:.1}" fill="#999">{}</text>"##,
                    y + 12.0,
                    (f64::from(k) * grid * 100.0).round() / 100.0
                );
            }
        }
        for line in &self.lines {
            segment(out, line.class, &line.from, &line.to);
        }
        for frame in &self.frames {
            let origin = frame.translation.vector;
            let (x, y) = place(&origin);
            let _ = writeln!(out, r#"<circle class="joint" cx="{x:.1}" cy="{y:.1}" r="4"/>"#);
            for (class, axis) in [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())] {
                segment(out, class, &origin, &(origin + frame.rotation * axis * (AXIS * self.size)));
            }
        }
    }
}
