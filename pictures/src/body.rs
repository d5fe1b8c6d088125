//! A robot on the page: links as a thick line, joints as dots, the gripper as a thinner line.
//!
//! In: poses and a projection. Out: lines at rest, or lines whose points are animated. Joints of a moving line are its
//! markers, so that they move along; their size is in units of its width.

use nalgebra::Vector3;

use crate::playback::Playback;
use crate::projection::Projection;

use crate::stick::{Motion, Stick};
use crate::svg::palette::WHITE;
use crate::svg::{Colour, Look, Svg};
use crate::tool_path::ToolPath;

/// A robot as it is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Actor<'a> {
    pub name: &'a str,
    pub colour: Colour,
    pub motion: Motion,
    pub path: ToolPath,
}

/// How large a robot is drawn \[px\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    pub link: f64,
    pub joint: f64,
    pub path: f64,
    pub arrow: f64,
    /// The most arrows of a path.
    pub arrows: u32,
    /// Points of a path.
    pub most: usize,
}

impl Pen {
    /// Thinner, down to a half, for robots of `length` \[px\] that are smaller than `usual`.
    pub fn fitting(self, length: f64, usual: f64) -> Pen {
        let share = (length / usual).clamp(0.5, 1.0);
        let [link, joint, path, arrow] =
            [self.link, self.joint, self.path, self.arrow].map(|size| share * size);
        Pen { link, joint, path, arrow, ..self }
    }
}

/// A robot at rest.
pub(crate) fn still(svg: &mut Svg, on: &Projection, stick: &Stick, colour: Colour, pen: Pen) {
    let [links, gripper] = [&stick.links[..], &stick.gripper]
        .map(|points| points.iter().map(|point| on.at(*point)).collect::<Vec<_>>());
    svg.group(Look::new().no_fill().stroke(colour).round(), |svg| {
        svg.polyline(&links, Look::new().class("links").width(pen.link));
        svg.polyline(&gripper, Look::new().width(0.5 * pen.link));
        if let ([joints @ .., _], true) = (&links[..], pen.joint > 0.0) {
            for joint in joints {
                svg.circle(*joint, pen.joint, Look::filled(WHITE).width(0.3 * pen.link));
            }
        }
    });
}

/// A robot in motion.
pub(crate) fn moving(svg: &mut Svg, on: &Projection, actor: &Actor<'_>, playback: &Playback, pen: Pen) {
    let sticks: Vec<Stick> = playback.times().filter_map(|time| actor.motion.at(time)).collect();
    let Some(first) = sticks.first() else { return };
    let rests = sticks.iter().all(|stick| stick.distance(first) < 1e-5);
    let part = |svg: &mut Svg, of: &dyn Fn(&Stick) -> &[Vector3<f64>], width: f64, joints: &str| {
        let points = |svg: &Svg, stick: &Stick| {
            let points: Vec<_> = of(stick).iter().map(|point| on.at(*point)).collect();
            svg.points(&points).to_string()
        };
        let look = svg.attributes(Look::new().stroke(actor.colour).width(width));
        let attributes = format!("{look}{joints} points=\"{}\"", points(svg, first));
        svg.containing("polyline", format_args!("{attributes}"), |svg| {
            if !rests {
                let places = sticks.iter().map(|stick| points(svg, stick)).collect();
                playback.animate(svg, "points", places);
            }
        });
    };
    svg.group(Look::new().no_fill().round(), |svg| {
        let joints = " marker-start=\"url(#joint)\" marker-mid=\"url(#joint)\"";
        part(svg, &|stick| &stick.links, pen.link, joints);
        part(svg, &|stick| &stick.gripper, 0.5 * pen.link, "");
    });
}
