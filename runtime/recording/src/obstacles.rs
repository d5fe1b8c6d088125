//! What stands in a cell, for 3D viewers: one `foxglove.SceneUpdate` at the start of a recording.
//!
//! It has a topic of its own, `/obstacles`: a viewer that jumps to a later time looks for the last message of each topic, and
//! of `/scene` that is a robot's.

use mrroc_core::link::Nanos;
use mrroc_core::nalgebra::Vector3;
use mrroc_core::observe::solid::{ObstacleLayout, Solid};
use mrroc_core::pose::Pose;
use serde_json::Value;

use super::entity::{Entity, update as scene_update};

const COLOUR: [f64; 3] = [0.55, 0.58, 0.62];
/// Arms behind an obstacle are still seen.
const PALE: f64 = 0.5;

/// Whether anything is drawn of an obstacle.
pub(super) fn is_drawn(obstacle: &ObstacleLayout) -> bool {
    let place = &obstacle.pose;
    let is_place = place.translation.vector.iter().chain(place.rotation.coords.iter()).all(|x| x.is_finite());
    is_place && obstacle.solid != Solid::HalfSpace
}

/// The picture of these obstacles at a date, in this frame.
pub(super) fn update(obstacles: &[ObstacleLayout], date: Nanos, frame: &str) -> Value {
    let entity = |obstacle: &ObstacleLayout| {
        let mut entity = Entity::of_colour(COLOUR).pale(PALE);
        draw(&mut entity, &obstacle.pose, &obstacle.solid);
        entity.json(date, frame, &obstacle.name)
    };
    scene_update(&obstacles.iter().map(entity).collect::<Vec<_>>())
}

#[allow(non_snake_case)]
fn draw(entity: &mut Entity, X_WO: &Pose, solid: &Solid) {
    match solid {
        Solid::Box { edges } => entity.cube(X_WO, *edges),
        Solid::Cylinder { radius, length } => entity.cylinder(X_WO, *radius, *length),
        Solid::Capsule { radius, length } => {
            let half = X_WO.rotation * Vector3::z() * (0.5 * length);
            let centre = X_WO.translation.vector;
            entity.capsule([centre - half, centre + half], *radius);
        }
        Solid::Ball { radius } => entity.ball(X_WO, *radius),
        Solid::HalfSpace => {}
        Solid::Points { points, radius } => {
            for point in points.iter() {
                entity.ball(&(X_WO * Pose::translation(point.x, point.y, point.z)), *radius);
            }
        }
        Solid::Several(parts) => parts.iter().for_each(|(X_OP, part)| draw(entity, &(X_WO * X_OP), part)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use serde_json::json;

    /// A quarter of a turn about y takes z to x.
    fn drawn(solid: Solid) -> Value {
        let pose = Pose::translation(1.0, 2.0, 3.0) * Pose::rotation(Vector3::y() * FRAC_PI_2);
        let update = update(&[ObstacleLayout { name: "post".to_owned(), pose, solid }], 0, "world");
        update["entities"][0].clone()
    }

    fn places(list: &Value) -> Vec<[f64; 3]> {
        let list = list.as_array().expect("a list");
        let of = |one: &Value| {
            ["x", "y", "z"].map(|axis| one["pose"]["position"][axis].as_f64().expect("a number"))
        };
        list.iter().map(of).collect()
    }

    #[test]
    fn every_solid_is_drawn_where_its_frame_is_and_as_large_as_it_is() {
        let cube = drawn(Solid::Box { edges: [0.1, 0.2, 0.3] });
        assert_eq!((&cube["id"], &cube["frame_id"]), (&json!("post"), &json!("world")));
        assert_eq!(cube["cubes"][0]["size"], json!({"x": 0.1, "y": 0.2, "z": 0.3}));
        assert_eq!(places(&cube["cubes"]), [[1.0, 2.0, 3.0]]);

        let cylinder = drawn(Solid::Cylinder { radius: 0.1, length: 0.6 });
        assert_eq!(cylinder["cylinders"][0]["size"], json!({"x": 0.2, "y": 0.2, "z": 0.6}));
        assert!(places(&cylinder["spheres"]).is_empty());

        let ball = drawn(Solid::Ball { radius: 0.1 });
        assert_eq!(ball["spheres"][0]["size"], json!({"x": 0.2, "y": 0.2, "z": 0.2}));

        let capsule = drawn(Solid::Capsule { radius: 0.1, length: 0.6 });
        assert_eq!(places(&capsule["spheres"]), [[0.7, 2.0, 3.0], [1.3, 2.0, 3.0]]);
        assert_eq!(places(&capsule["cylinders"]), [[1.0, 2.0, 3.0]]);

        let points = [Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.0, 0.5, 0.0)];
        let cloud = drawn(Solid::Points { points: points.into(), radius: 0.01 });
        assert_eq!(places(&cloud["spheres"]), [[1.5, 2.0, 3.0], [1.0, 2.5, 3.0]]);

        // The same two places, as parts.
        let parts = points.map(|p| (Pose::translation(p.x, p.y, p.z), Solid::Ball { radius: 0.01 }));
        assert_eq!(drawn(Solid::Several(parts.into())), cloud);
    }
}
