//! The path of a tool, coloured by its speed, with arrows in its direction.
//!
//! In: a motion's tool positions and speeds, a projection. Out: lines of one colour each, as few points as look the same.

use nalgebra::Vector2;

use crate::history::History;
use crate::projection::{Extent, Projection};
use crate::sample::Sample;
use crate::stick::Motion;
use crate::svg::palette::{self, WHITE};
use crate::svg::{Colour, Look, Svg, thinned, thinning};

/// How many speeds a path tells apart.
pub(crate) const LEVELS: usize = 12;

/// The colour of a level of speed, 0 to [`LEVELS`] - 1.
pub(crate) fn level_colour(level: usize) -> Colour {
    palette::speed(level as f64 / (LEVELS - 1) as f64)
}

/// Where a tool was, and how fast.
#[derive(Clone, Debug)]
pub(crate) struct ToolPath {
    /// Speeds of the tool at each sample [m/s], at least 0.
    speeds: Vec<f64>,
    /// Length of the path in all servo periods \[m\].
    pub length: f64,
    /// Speed level of the path from each sample to the next.
    levels: Vec<usize>,
}

impl ToolPath {
    /// Of the samples of a history; levels come with [`coloured`](Self::coloured).
    pub fn of(history: &History, samples: &[&Sample]) -> ToolPath {
        let speed = |sample: &&Sample| sample.rates.as_ref().map_or(0.0, |rates| rates.tool);
        let speeds: Vec<f64> = samples.iter().map(speed).collect();
        ToolPath { levels: vec![0; speeds.len()], speeds, length: history.path_length() }
    }

    /// With speed levels up to `fastest` [m/s], > 0. A level is left only for a speed well beyond it.
    #[must_use]
    pub fn coloured(mut self, fastest: f64) -> ToolPath {
        let mut level = 0_usize;
        for (kept, speed) in self.levels.iter_mut().zip(&self.speeds) {
            let place = (speed / fastest).clamp(0.0, 1.0) * (LEVELS - 1) as f64;
            if (place - level as f64).abs() > 0.7 {
                level = place.round() as usize;
            }
            *kept = level;
        }
        self
    }

    /// Draws the path, `width` \[px\] wide, in about `most` points.
    pub fn draw(&self, svg: &mut Svg, motion: &Motion, on: &Projection, width: f64, most: usize) {
        let points: Vec<Vector2<f64>> = motion.tool.iter().map(|point| on.at(*point)).collect();
        if points.len() < 2 {
            return;
        }
        let mut runs: Vec<(usize, Vec<Vector2<f64>>)> = Vec::new();
        for (pair, level) in points.windows(2).zip(&self.levels) {
            match runs.last_mut() {
                Some((last, run)) if last == level => run.push(pair[1]),
                Some(_) | None => runs.push((*level, pair.to_vec())),
            }
        }
        let mut tolerance = thinning::FINE;
        let lines = loop {
            let lines: Vec<_> = runs.iter().map(|(level, run)| (level, thinned(run, tolerance))).collect();
            if lines.iter().map(|(_, line)| line.len()).sum::<usize>() <= most || tolerance > 3.0 {
                break lines;
            }
            tolerance *= 2.0;
        };
        svg.group(Look::new().class("path").no_fill().width(width).round(), |svg| {
            for level in 0..LEVELS {
                let same: Vec<_> = lines.iter().filter(|(l, _)| **l == level).map(|(_, line)| line).collect();
                svg.path(&same, Look::new().stroke(level_colour(level)));
            }
        });
    }

    /// Draws arrows beside the path, at the right hand of who goes along it, so that there and back are told apart: at most
    /// `most`, and one at least on a path that is seen.
    pub fn arrows(&self, svg: &mut Svg, motion: &Motion, on: &Projection, size: f64, most: u32) {
        let points: Vec<Vector2<f64>> = motion.tool.iter().map(|point| on.at(*point)).collect();
        let length: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        if length < 3.0 * size {
            return;
        }
        // What goes round and round in a small place has room for few.
        let extent = Extent::of(points.iter().copied()).size().norm();
        let room = (0.25 * extent / size).clamp(1.0, f64::from(most));
        let count = (length / (14.0 * size)).round().clamp(1.0, room.floor());
        let mut next = 0.5 * length / count;
        let mut travelled = 0.0;
        for i in 1..points.len() {
            travelled += (points[i] - points[i - 1]).norm();
            if travelled < next {
                continue;
            }
            next += length / count;
            // The direction over a few pixels: of one sample it would be noise.
            let far = |j: &usize| (points[*j] - points[i]).norm() > size;
            let from = (0..i).rev().find(far).unwrap_or(0);
            let Some(direction) = (points[i] - points[from]).try_normalize(1e-3) else { continue };
            let side = Vector2::new(-direction.y, direction.x);
            // The page's y points down.
            let beside = points[i] + side * (1.4 * size);
            let tip = beside + direction * size;
            let back = beside - direction * (0.6 * size);
            let triangle = [tip, back + side * (0.75 * size), back - side * (0.75 * size)];
            let look = Look::filled(level_colour(self.levels[i])).stroke(WHITE).width(0.8);
            svg.polygon(&triangle, look);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::View;
    use crate::svg::Area;
    use mrroc::robot::{JointKind, Robot};
    use mrroc_robots::{Irp6, Six};

    /// An arm whose column turns at a steady 1 rad/s: the path is an arc about the column, by the forward kinematics.
    #[test]
    fn a_path_runs_from_the_first_to_the_last_pose_and_is_as_long_as_its_arc() {
        let arm = Irp6::nominal();
        let at = |angle: f64| Six::new(angle, -1.57, 0.16, -0.16, 4.71, 0.0);
        let mut history = History::new("arm", "irp6", &[JointKind::Revolute; 6]);
        for i in 0..=500 {
            let time = f64::from(i) * 2e-3;
            let q = at(time);
            let mut links = Vec::new();
            arm.frames(&q, &mut |frame| links.push(frame.translation.vector));
            history.add(Sample {
                time,
                demanded: q.as_slice().to_vec(),
                measured: q.as_slice().to_vec(),
                links,
                tool: arm.forward(&q),
                rates: None,
            });
        }
        let [first, last] = [0.0, 1.0].map(|angle| arm.forward(&at(angle)).translation.vector);
        let radius = first.xy().norm();
        let samples = history.samples();
        let path = ToolPath::of(&history, &samples).coloured(radius);
        assert!((path.length - radius).abs() < 1e-3 && (history.tool_speed - radius).abs() < 1e-3);
        let area = Area { x: 0.0, y: 0.0, width: 400.0, height: 400.0 };
        let on =
            Projection::new(View::above(), &Extent::of([first.xy(), last.xy()].into_iter()), area, 300.0);
        let mut svg = Svg::new(1);
        path.draw(&mut svg, &Motion::of(&history, 0.05), &on, 2.0, 1000);
        let written = [first, last].map(|point| svg.points(&[on.at(point)]).to_string());
        let text = svg.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let strokes: Vec<&str> = document.descendants().filter_map(|node| node.attribute("d")).collect();
        // At rest the first sample has no speed: its colour, and then that of full speed.
        assert_eq!(strokes.len(), 2);
        assert!(strokes[0].starts_with(&format!("M{}", written[0])), "{strokes:?}");
        assert!(strokes[1].ends_with(&written[1]), "{strokes:?}");
    }
}
