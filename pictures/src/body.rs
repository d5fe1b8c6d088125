//! A robot on the page: links as a thick line, joints as dots, the gripper as a thinner line.
//!
//! In: poses and a projection. Out: lines at rest, or lines whose points are animated. Joints of a moving line are its
//! markers, so that they move along; their size is in units of its width.

use nalgebra::Vector3;

use crate::marks::circle;
use crate::playback::Playback;
use crate::projection::Projection;
use crate::scene::Actor;
use crate::stick::Stick;
use crate::svg::{Points, Px, Svg};

/// How large a robot is drawn \[px\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    pub link: f64,
    pub joint: f64,
    pub way: f64,
    pub arrow: f64,
    /// The most arrows of a way.
    pub arrows: u32,
    /// Points of a way.
    pub most: usize,
}

impl Pen {
    /// Thinner, down to a half, for robots of `length` \[px\] that are smaller than `usual`.
    pub fn fitting(self, length: f64, usual: f64) -> Pen {
        let share = (length / usual).clamp(0.5, 1.0);
        let [link, joint, way, arrow] =
            [self.link, self.joint, self.way, self.arrow].map(|size| share * size);
        Pen { link, joint, way, arrow, ..self }
    }
}

/// A robot at rest.
pub(crate) fn still(svg: &mut Svg, on: &Projection, stick: &Stick, colour: &str, pen: Pen) {
    let [links, gripper] = [&stick.links[..], &stick.gripper]
        .map(|points| points.iter().map(|point| on.at(*point)).collect::<Vec<_>>());
    svg.group(
        "g",
        format_args!("fill=\"none\" stroke=\"{colour}\" stroke-linecap=\"round\" stroke-linejoin=\"round\""),
        |svg| {
            svg.element(
                "polyline",
                format_args!(
                    "class=\"links\" stroke-width=\"{}\" points=\"{}\"",
                    Px(pen.link),
                    Points(&links)
                ),
            );
            svg.element(
                "polyline",
                format_args!("stroke-width=\"{}\" points=\"{}\"", Px(0.5 * pen.link), Points(&gripper)),
            );
            if let ([joints @ .., _], true) = (&links[..], pen.joint > 0.0) {
                for joint in joints {
                    circle(
                        svg,
                        *joint,
                        pen.joint,
                        format_args!("fill=\"#fff\" stroke-width=\"{}\"", Px(0.3 * pen.link)),
                    );
                }
            }
        },
    );
}

/// A robot on its way.
pub(crate) fn moving(svg: &mut Svg, on: &Projection, actor: &Actor<'_>, playback: &Playback, pen: Pen) {
    let sticks: Vec<Stick> = playback.times().filter_map(|time| actor.motion.at(time)).collect();
    let Some(first) = sticks.first() else { return };
    let points = |of: &dyn Fn(&Stick) -> &[Vector3<f64>], stick: &Stick| {
        let points: Vec<_> = of(stick).iter().map(|point| on.at(*point)).collect();
        Points(&points).to_string()
    };
    let still = sticks.iter().all(|stick| stick.distance(first) < 1e-5);
    let colour = actor.colour;
    let part =
        |svg: &mut Svg, of: &dyn Fn(&Stick) -> &[Vector3<f64>], width: f64, colour: &str, joints: &str| {
            svg.group(
                "polyline",
                format_args!(
                    "stroke=\"{colour}\" stroke-width=\"{}\"{joints} points=\"{}\"",
                    Px(width),
                    points(of, first)
                ),
                |svg| {
                    if !still {
                        playback.animate(svg, "points", sticks.iter().map(|stick| points(of, stick)));
                    }
                },
            );
        };
    svg.group("g", format_args!("fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\""), |svg| {
        let joints = " marker-start=\"url(#joint)\" marker-mid=\"url(#joint)\"";
        part(svg, &|stick| &stick.links, pen.link, colour, joints);
        part(svg, &|stick| &stick.gripper, 0.5 * pen.link, colour, "");
    });
}
