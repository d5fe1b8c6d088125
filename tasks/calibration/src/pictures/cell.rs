//! The cell from above and from the side: arms, theodolites, where the bar was laid, and lines of sight of one visit.

use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, RULE, robot};
use mrroc_pictures::svg::{Area, Look, Page, Svg, TextStyle};
use mrroc_robots::Six;
use mrroc_robots::models::{Capsule, Outline};
use nalgebra::Vector2;

use crate::scene::{ARMS, BALLS, NAMES, Scene};
use crate::visits::Visit;

use super::{MARGIN, View, WIDTH, heading};

/// The scene with its arms where a visit takes them.
#[must_use]
pub fn cell(scene: &Scene, visit: &Visit) -> String {
    let joints: [Six; ARMS] = core::array::from_fn(|arm| scene.joints(arm, &visit.both[arm]));
    let half = 0.5 * (WIDTH - 3.0 * MARGIN);
    Page::new("Two arms and two theodolites", WIDTH, 600.0).draw(|svg| {
        let below = "lines of sight to the balls of both arms in one posture; dashed: a link is in the way; grey: places of the scale bar";
        heading(svg, "The cell", below);
        let views = [("from above", 1, [-1.0, 3.0]), ("from the side", 2, [-1.0, 2.0])];
        for (i, (name, up, range)) in views.into_iter().enumerate() {
            let area = Area { x: MARGIN + i as f64 * (half + MARGIN), y: 110.0, width: half, height: 430.0 };
            svg.text(Vector2::new(area.x, 98.0), TextStyle::new(14.0, INK).bold(), name);
            let view = View::new(area, 1.05, up, range);
            view.axes.draw_grid(svg);
            view.axes.draw_labels_below(svg);
            draw(svg, &view, scene, &joints);
        }
        svg.text(Vector2::new(WIDTH - MARGIN, 585.0), TextStyle::new(12.0, GREY).end(), "m");
    })
}

fn draw(svg: &mut Svg, view: &View, scene: &Scene, joints: &[Six; ARMS]) {
    for ends in scene.ends {
        svg.line(view.at(&ends[0]), view.at(&ends[1]), Look::line(RULE, 5.0).round());
    }
    let scale = view.axes.at(1.0, 0.0).x - view.axes.at(0.0, 0.0).x;
    for (arm, joints) in joints.iter().enumerate() {
        Outline::capsules(&scene.arms[arm], joints, &mut |capsule: Capsule| {
            let [from, to] = capsule.ends.map(|end| view.at(&end));
            let look = Look::line(robot(arm), (2.0 * scale * capsule.radius).max(2.0)).round();
            svg.line(from, to, look.stroke_opacity(0.35));
        });
    }
    for (which, theodolite) in scene.theodolites.iter().enumerate() {
        let eye = theodolite.place.translation.vector;
        for (arm, own) in joints.iter().enumerate() {
            for ball in 0..BALLS.len() {
                let point = scene.ball(arm, ball, own);
                let look = if scene.sees(which, &point, joints) {
                    Look::line(INK, 0.8)
                } else {
                    Look::line(HIGHLIGHT, 0.8).dashed(4.0, 3.0)
                };
                svg.line(view.at(&eye), view.at(&point), look);
                svg.circle(view.at(&point), 3.0, Look::filled(robot(arm)));
            }
        }
        svg.circle(view.at(&eye), 7.0, Look::filled(INK));
        let label = view.at(&eye) + Vector2::new(0.0, -12.0);
        svg.text(label, TextStyle::new(12.0, INK).middle(), ["north", "south"][which]);
    }
    for (arm, name) in NAMES.into_iter().enumerate() {
        let mut base = None;
        mrroc::robot::Robot::frames(&scene.arms[arm], &joints[arm], &mut |frame| {
            base.get_or_insert(frame.translation.vector);
        });
        let place = view.at(&base.unwrap_or_default()) + Vector2::new(0.0, 34.0);
        svg.text(place, TextStyle::new(12.0, robot(arm)).middle().bold(), name);
    }
}
