//! A film of a walk: from the side, from above with the support polygon, and the margin over time.

use std::fmt::Write as _;

use mrroc::robot::Robot as _;
use nalgebra::{Vector2, Vector3};

use crate::ground::{Ground, Lane};
use crate::leg::Leg;
use crate::places::hip;
use crate::plant::trunk::EDGES;
use crate::seen::{RunMeasurements, Standing};
use crate::walk::LEAST;
use crate::walk::support::hull;

/// Colours of the left legs, of the right ones, of the ground's two lanes.
const LEFT: &str = "#2a6fb0";
const RIGHT: &str = "#c0692b";
const LANES: [&str; 2] = ["#c9dcec", "#ecd6c4"];
/// A picture of the film in so many that were kept: every tenth of a second.
const EVERY: usize = 5;
/// Where the three parts are drawn \[mm\]: the zero of the side view, the path from above, the margin's zero.
const SIDE: f64 = 720.0;
const ABOVE: f64 = 1130.0;
const CURVE: f64 = 1900.0;
/// What the margin's curve is drawn with [mm/m].
const TALL: f64 = 1800.0;

/// An SVG of a run over this ground, in millimetres; it repeats itself.
#[must_use]
pub fn film(seen: &RunMeasurements, ground: &Ground) -> String {
    let frames: Vec<&Standing> = seen.film.iter().step_by(EVERY).collect();
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return String::new() };
    let lasts = last.time - first.time;
    let (from, to) = (first.X_WT.translation.x - 0.6, last.X_WT.translation.x + 0.6);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{:.0} 0 {:.0} 2000\" font-family=\"sans-serif\" font-size=\"42\">\n\
         <title>four legs carry a trunk over steps</title>\n<rect x=\"{:.0}\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        1e3 * from,
        1e3 * (to - from),
        1e3 * from
    );
    for (lane, colour) in [(&ground.left, LANES[0]), (&ground.right, LANES[1])] {
        let _ = writeln!(
            svg,
            "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"0.7\"/>",
            profile(lane, from, to)
        );
    }
    edges(&mut svg, ground, [from, to]);
    let mut moving = Moving { svg, frames: &frames, lasts };
    let side = |at: &Vector3<f64>| (1e3 * at.x, SIDE - 1e3 * at.z);
    let above = |at: &Vector2<f64>| (1e3 * at.x, ABOVE - 1e3 * at.y);
    // The legs that are farther away first.
    for leg in [1, 3] {
        moving.line(RIGHT, |now| limbs(now, leg).iter().map(side).collect());
    }
    moving.shape("#8a8f98", 0.9, |now| trunk(now).iter().map(side).collect());
    for leg in [0, 2] {
        moving.line(LEFT, |now| limbs(now, leg).iter().map(side).collect());
    }
    moving.line("#222222", |now| {
        let low = now.feet.iter().map(|foot| foot.z).fold(f64::INFINITY, f64::min);
        [now.centre, Vector3::new(now.centre.x, now.centre.y, low)].iter().map(side).collect()
    });
    moving.discrete("#7bb274", |now| support(now).iter().map(above).collect());
    for leg in 0..4 {
        moving.dot(if leg % 2 == 0 { LEFT } else { RIGHT }, 16.0, |now| above(&now.feet[leg].xy()));
    }
    moving.dot("#222222", 12.0, |now| above(&now.centre.xy()));
    let wide = 1e3 * (to - from - 0.2);
    let at = |time: f64| 1e3 * from + 100.0 + wide * (time - first.time) / lasts;
    moving.line("#bbbbbb", |now| vec![(at(now.time), CURVE), (at(now.time), CURVE - 0.22 * TALL)]);
    let mut svg = moving.svg;
    curve(&mut svg, &seen.film, &at);
    let least = 1e3 * seen.margin;
    let _ = writeln!(
        svg,
        "<text x=\"{0:.0}\" y=\"60\">from the side: left legs blue, right legs orange, the centre of mass and its plumb line</text>\n\
         <text x=\"{0:.0}\" y=\"880\">from above: feet, support polygon, centre of mass</text>\n\
         <text x=\"{0:.0}\" y=\"1460\">static margin over time: {least:.1} mm at least; red: 20 mm</text>\n</svg>",
        1e3 * from + 60.0
    );
    svg
}

/// A picture whose parts move.
struct Moving<'a> {
    svg: String,
    frames: &'a [&'a Standing],
    lasts: f64,
}

type At = (f64, f64);

impl Moving<'_> {
    fn line(&mut self, colour: &str, points: impl Fn(&Standing) -> Vec<At>) {
        let look = format!(
            "polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"14\" stroke-linejoin=\"round\" stroke-linecap=\"round\""
        );
        self.animate(&look, "polyline", "linear", points);
    }

    fn shape(&mut self, colour: &str, opacity: f64, points: impl Fn(&Standing) -> Vec<At>) {
        self.animate(
            &format!("polygon fill=\"{colour}\" fill-opacity=\"{opacity}\""),
            "polygon",
            "linear",
            points,
        );
    }

    fn discrete(&mut self, colour: &str, points: impl Fn(&Standing) -> Vec<At>) {
        let look =
            format!("polygon fill=\"{colour}\" fill-opacity=\"0.5\" stroke=\"{colour}\" stroke-width=\"4\"");
        self.animate(&look, "polygon", "discrete", points);
    }

    /// What stands still shows the walk in its middle.
    fn animate(&mut self, look: &str, name: &str, mode: &str, points: impl Fn(&Standing) -> Vec<At>) {
        let text = |now: &Standing| {
            let points = points(now);
            points.iter().map(|(x, y)| format!("{x:.0},{y:.0}")).collect::<Vec<_>>().join(" ")
        };
        let values: Vec<String> = self.frames.iter().map(|now| text(now)).collect();
        let _ = writeln!(
            self.svg,
            "<{look} points=\"{}\"><animate attributeName=\"points\" calcMode=\"{mode}\" dur=\"{:.1}s\" repeatCount=\"indefinite\" values=\"{}\"/></{name}>",
            values[values.len() / 2],
            self.lasts,
            values.join(";")
        );
    }

    fn dot(&mut self, colour: &str, radius: f64, place: impl Fn(&Standing) -> At) {
        let places: Vec<At> = self.frames.iter().map(|now| place(now)).collect();
        let middle = places[places.len() / 2];
        let values = |of: fn(&At) -> f64| {
            places.iter().map(|at| format!("{:.0}", of(at))).collect::<Vec<_>>().join(";")
        };
        let _ = write!(
            self.svg,
            "<circle r=\"{radius}\" fill=\"{colour}\" cx=\"{:.0}\" cy=\"{:.0}\">",
            middle.0, middle.1
        );
        for (name, values) in [("cx", values(|at| at.0)), ("cy", values(|at| at.1))] {
            let _ = write!(
                self.svg,
                "<animate attributeName=\"{name}\" dur=\"{:.1}s\" repeatCount=\"indefinite\" values=\"{values}\"/>",
                self.lasts
            );
        }
        self.svg.push_str("</circle>\n");
    }
}

/// The outline of a lane from the side.
fn profile(lane: &Lane, from: f64, to: f64) -> String {
    let mut points = vec![(from, lane.height(from))];
    for (edge, heights) in lane.edges.iter().zip(lane.heights.windows(2)).filter(|(edge, _)| **edge < to) {
        points.extend([(*edge, heights[0]), (*edge, heights[1])]);
    }
    points.extend([(to, lane.height(to)), (to, -0.05), (from, -0.05)]);
    let text: Vec<String> =
        points.iter().map(|(x, z)| format!("{:.0},{:.0}", 1e3 * x, SIDE - 1e3 * z)).collect();
    text.join(" ")
}

/// The edges of both lanes from above.
fn edges(svg: &mut String, ground: &Ground, [from, to]: [f64; 2]) {
    for (lane, colour, side) in [(&ground.left, LANES[0], 1.0), (&ground.right, LANES[1], -1.0)] {
        let steps = lane.edges.iter().zip(lane.heights.windows(2));
        for (x, _) in
            steps.filter(|(x, heights)| (from..to).contains(*x) && (heights[1] - heights[0]).abs() > 0.01)
        {
            let _ = writeln!(
                svg,
                "<line x1=\"{0:.0}\" y1=\"{1:.0}\" x2=\"{0:.0}\" y2=\"{2:.0}\" stroke=\"{colour}\" stroke-width=\"8\"/>",
                1e3 * x,
                ABOVE,
                ABOVE - side * 260.0
            );
        }
    }
}

/// Hip, pitch axis, knee, foot of a leg \[m, W\].
fn limbs(now: &Standing, leg: usize) -> Vec<Vector3<f64>> {
    let mut points = Vec::with_capacity(4);
    Leg::at(hip(leg)).frames(&now.q[leg], &mut |frame| points.push((now.X_WT * frame).translation.vector));
    points
}

/// The trunk's outline from the side \[m, W\].
fn trunk(now: &Standing) -> Vec<Vector3<f64>> {
    let [x, _, z] = EDGES.map(|edge| 0.5 * edge);
    let corners = [(-x, -z), (x, -z), (x, z), (-x, z)];
    corners.iter().map(|(x, z)| now.X_WT.transform_point(&[*x, 0.0, *z].into()).coords).collect()
}

/// Four corners of the support polygon, the last one repeated \[m, W\].
fn support(now: &Standing) -> Vec<Vector2<f64>> {
    let feet: Vec<Vector2<f64>> =
        (0..4).filter(|leg| now.bears(*leg)).map(|leg| now.feet[leg].xy()).collect();
    let (corners, count) = hull(&feet);
    let last = count.max(1) - 1;
    (0..4).map(|i| corners[i.min(last)]).collect()
}

/// The margin over time, at most 0.22 m of it.
fn curve(svg: &mut String, film: &[Standing], at: &dyn Fn(f64) -> f64) {
    let (from, to) =
        (film.first().map_or(0.0, |now| at(now.time)), film.last().map_or(0.0, |now| at(now.time)));
    let points: Vec<String> = film
        .iter()
        .map(|now| format!("{:.0},{:.0}", at(now.time), CURVE - TALL * now.margin().clamp(0.0, 0.22)))
        .collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#222222\" stroke-width=\"5\"/>\n\
         <line x1=\"{from:.0}\" y1=\"{CURVE}\" x2=\"{to:.0}\" y2=\"{CURVE}\" stroke=\"#888888\" stroke-width=\"3\"/>\n\
         <line x1=\"{from:.0}\" y1=\"{1:.0}\" x2=\"{to:.0}\" y2=\"{1:.0}\" stroke=\"#c03a2b\" stroke-width=\"5\"/>",
        points.join(" "),
        CURVE - TALL * LEAST
    );
}
