//! Errors of balls at postures that were not used, as arrows: by the design in the base that fits it best, and by the calibration.

use mrroc::robot::Robot;
use mrroc_pictures::svg::palette::{GREY, INK, robot};
use mrroc_pictures::svg::{Area, Look, Page, Svg, TextStyle};
use mrroc_robots::{Irp6, Six};
use nalgebra::{Point3, Vector2, Vector3};

use crate::estimate::{Estimate, bending, fitted};
use crate::scene::{ARMS, BALLS, Scene};

use super::{MARGIN, View, WIDTH, heading};

/// An arrow: from where a ball is, and how far it is from where it is believed to be \[m\].
type Error = (Vector3<f64>, Vector3<f64>);

/// Errors of the first ball of both arms at these postures, from above and from the side, before and after.
#[must_use]
pub fn errors(estimate: &Estimate, scene: &mut Scene, postures: &[Vec<Six>; ARMS]) -> String {
    let believed = crate::scene::believed_bases();
    let mut all: [Vec<(usize, Error)>; 2] = [Vec::new(), Vec::new()];
    for (arm, postures) in postures.iter().enumerate() {
        let mut pairs = Vec::new();
        for q in postures {
            let joints = scene.come_to_rest(arm, q);
            let truly = scene.ball(arm, 0, &joints);
            let nominal = Irp6::nominal().with_base(believed[arm]);
            pairs.push(((nominal.forward(q) * Point3::from(BALLS[0])).coords, truly));
            let frame = estimate.problem.frame_of(estimate.balls[arm][0]);
            let bent = bending(q, scene.payload[arm]);
            let (found, _) = estimate.fit.place_loaded(estimate.arms[arm], q.as_slice(), &bent, frame);
            all[1].push((arm, (truly, truly - found.translation.vector)));
        }
        let before = fitted(&pairs);
        all[0].extend(pairs.iter().zip(before).map(|(pair, off)| (arm, (pair.1, off))));
    }
    let half = 0.5 * (WIDTH - 3.0 * MARGIN);
    Page::new("Errors before and after", WIDTH, 1020.0).draw(|svg| {
        let below = "where a ball is at postures that were not used, and how far that is from where it is believed to be; 'before': the design, each base where that fits best";
        heading(svg, "Errors before and after", below);
        for (row, (errors, (name, scale))) in all.iter().zip([("before", 20.0), ("after", 3000.0)]).enumerate() {
            let squares: f64 = errors.iter().map(|(_, (_, off))| off.norm_squared()).sum();
            let rms = 1e3 * (squares / errors.len() as f64).sqrt();
            for (column, (from, up)) in [("above", 1), ("the side", 2)].into_iter().enumerate() {
                let area = Area {
                    x: MARGIN + column as f64 * (half + MARGIN),
                    y: 110.0 + row as f64 * 460.0,
                    width: half,
                    height: 380.0,
                };
                let title = format!("{name}, from {from}: {rms:.3} mm rms; arrows x {scale}");
                svg.text(Vector2::new(area.x, area.y - 12.0), TextStyle::new(14.0, INK).bold(), &title);
                let view = View::new(area, 1.05, up, [-0.5, 1.5]);
                view.axes.draw_grid(svg);
                view.axes.draw_labels_below(svg);
                for (arm, (at, off)) in errors {
                    arrow(svg, view.at(at), view.at(&(at + off * scale)), *arm);
                }
            }
        }
        svg.text(Vector2::new(WIDTH - MARGIN, 1005.0), TextStyle::new(12.0, GREY).end(), "m");
    })
}

fn arrow(svg: &mut Svg, from: Vector2<f64>, to: Vector2<f64>, arm: usize) {
    let look = Look::line(robot(arm), 1.0);
    svg.circle(from, 1.2, Look::filled(robot(arm)));
    svg.line(from, to, look);
    let along = to - from;
    if along.norm() > 3.0 {
        let back = along.normalize() * 4.0;
        let side = Vector2::new(-back.y, back.x) * 0.5;
        svg.path(&[[to - back + side, to, to - back - side]], look.no_fill());
    }
}
