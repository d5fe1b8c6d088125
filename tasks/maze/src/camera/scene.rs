//! What the camera sees: the walls as boxes, where they truly stand, and the arm where it is in front of the camera.

use mrroc::pose::Pose;
use mrroc_map::{Wall, Walls};
use mrroc_robots::clearance::{Capsule, Outline as _};
use mrroc_robots::{Irp6, Six};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Point3, Vector3};

use super::eye::floor;
use crate::places::HEIGHT;

/// White walls ..
const WHITE: f64 = 0.8;
/// .. and a grey arm.
const GREY: f64 = 0.4;

/// A maze, and an arm at rest.
#[allow(non_snake_case)]
pub struct Overlooked {
    walls: Vec<Form>,
    X_FM: Pose,
    arm: Form,
}

impl Overlooked {
    /// These walls, at `X_WM`, and the arm with these joint positions.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(walls: &Walls, X_WM: &Pose, joints: &Six) -> Self {
        let mut capsules = Vec::new();
        Irp6::nominal().capsules(joints, &mut |capsule: Capsule| {
            let ends = capsule.ends.map(|end| floor().inverse_transform_point(&Point3::from(end)).coords);
            capsules.push(Piece::Capsule { ends, radius: capsule.radius });
        });
        let walls = apart(walls.boxes()).into_iter().map(|wall| {
            let corner = |at: &nalgebra::Vector2<f64>, z: f64| Vector3::new(at.x, at.y, z);
            Form::new([Piece::Block { lower: corner(&wall.lower, 0.0), upper: corner(&wall.upper, HEIGHT) }])
        });
        Self { walls: walls.collect(), X_FM: floor().inv_mul(X_WM), arm: Form::new(capsules) }
    }
}

/// The same walls in short pieces of which none lies in another: what a ray meets it meets once, and soon.
fn apart(boxes: &[Wall]) -> Vec<Wall> {
    let is_level = |wall: &&Wall| wall.upper.x - wall.lower.x >= wall.upper.y - wall.lower.y;
    let level: Vec<&Wall> = boxes.iter().filter(is_level).collect();
    let mut pieces = Vec::new();
    for wall in boxes {
        let axis = usize::from(!is_level(&wall));
        // An upright one goes on beyond those that it crosses.
        let mut cuts: Vec<[f64; 2]> = level
            .iter()
            .filter(|_| axis == 1)
            .filter(|other| other.lower.x < wall.upper.x && wall.lower.x < other.upper.x)
            .map(|other| [other.lower.y, other.upper.y])
            .filter(|cut| cut[0] < wall.upper.y && wall.lower.y < cut[1])
            .collect();
        cuts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        cuts.push([wall.upper[axis], wall.upper[axis]]);
        let mut from = wall.lower[axis];
        for [low, high] in cuts {
            let count = ((low - from) / SHORT).ceil();
            for i in 0..count.max(0.0) as u32 {
                let mut piece = *wall;
                piece.lower[axis] = from + (low - from) * f64::from(i) / count;
                piece.upper[axis] = from + (low - from) * f64::from(i + 1) / count;
                pieces.push(piece);
            }
            from = from.max(high);
        }
    }
    pieces
}

/// Length of a piece at most \[m\].
const SHORT: f64 = 0.03;

impl Scene for Overlooked {
    fn now(&self) -> f64 {
        0.0
    }

    fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
}

impl View for Overlooked {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        let still = |form, pose, reflectance| {
            let (velocity, angular_velocity) = (Vector3::zeros(), Vector3::zeros());
            Seen { form, pose, velocity, angular_velocity, reflectance }
        };
        for wall in &self.walls {
            visit(&still(wall, self.X_FM, WHITE));
        }
        visit(&still(&self.arm, Pose::identity(), GREY));
    }

    fn surface(&self, _: f64) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_map::{Layout, Place};

    #[test]
    fn pieces_of_walls_cover_what_the_walls_do_and_no_place_twice() {
        let walls = Walls::of(&Layout::random(16, 5), 0.025, 0.002);
        let pieces = apart(walls.boxes());
        let inside = |wall: &Wall, at: &Place| {
            (0..2).all(|i| wall.lower[i] - 1e-12 < at[i] && at[i] < wall.upper[i] - 1e-12)
        };
        for i in 0..400 {
            for j in 0..400 {
                let at = Place::new(-1.3e-3 + 1.013e-3 * f64::from(i), -1.3e-3 + 1.013e-3 * f64::from(j));
                let (whole, cut) = (
                    walls.boxes().iter().any(|wall| inside(wall, &at)),
                    pieces.iter().filter(|piece| inside(piece, &at)).count(),
                );
                assert_eq!(usize::from(whole), cut, "{at}");
            }
        }
    }
}
