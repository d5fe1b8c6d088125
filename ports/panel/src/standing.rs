//! What stands in the cell, as a page draws it.
//!
//! In: the solids of the layout. Out: JSON, for each its name, its pose and its form; those whose place is no number, and half
//! spaces, are left out.

use mrroc_core::observe::solid::{ObstacleLayout, Solid};
use mrroc_core::pose::Pose;
use serde_json::{Value, json};

use crate::values::{is_pose, numbers, rounded};

/// The solids of a cell.
pub fn obstacles(layout: &[ObstacleLayout]) -> Value {
    layout.iter().filter(|obstacle| is_pose(&obstacle.pose)).flat_map(obstacle).collect()
}

/// What is drawn of an obstacle; of several solids each, under the name of the obstacle.
fn obstacle(obstacle: &ObstacleLayout) -> Vec<Value> {
    let mut shown = match &obstacle.solid {
        Solid::Box { edges } => json!({"form": "box", "edges": edges}),
        Solid::Cylinder { radius, length } => json!({"form": "cylinder", "radius": radius, "length": length}),
        Solid::Capsule { radius, length } => json!({"form": "capsule", "radius": radius, "length": length}),
        Solid::Ball { radius } => json!({"form": "ball", "radius": radius}),
        Solid::HalfSpace => return Vec::new(),
        Solid::Points { points, radius } => {
            let points: Vec<f64> =
                points.iter().flat_map(|point| point.iter().map(|x| rounded(*x))).collect();
            json!({"form": "points", "points": points, "radius": radius})
        }
        Solid::Several(parts) => {
            let part = |(place, solid): &(Pose, Solid)| {
                let pose = obstacle.pose * place;
                self::obstacle(&ObstacleLayout { name: obstacle.name.clone(), pose, solid: solid.clone() })
            };
            return parts.iter().flat_map(part).collect();
        }
    };
    shown["name"] = json!(obstacle.name);
    shown["pose"] = json!(numbers(&obstacle.pose));
    vec![shown]
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::nalgebra::Vector3;

    #[test]
    fn a_page_is_told_the_form_and_the_place_of_what_stands_in_the_cell() {
        let of = |name: &str, x: f64, solid: Solid| ObstacleLayout {
            name: name.to_owned(),
            pose: Pose::translation(x, 0.0, 0.5),
            solid,
        };
        let points = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)];
        let told = obstacles(&[
            of("bench", 1.0, Solid::Box { edges: [0.1, 0.2, 0.3] }),
            of("nowhere", f64::NAN, Solid::Ball { radius: 0.1 }),
            of("scan", 0.0, Solid::Points { points: points.into(), radius: 0.01 }),
        ]);
        let place = |x: f64| json!(numbers(&Pose::translation(x, 0.0, 0.5)));
        let bench = json!({"form": "box", "edges": [0.1, 0.2, 0.3], "name": "bench", "pose": place(1.0)});
        let scan = json!({
            "form": "points", "points": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "radius": 0.01, "name": "scan", "pose": place(0.0),
        });
        assert_eq!(told, json!([bench, scan]));
        // A part 1 m away in a frame that stands at x = 0 is a solid at x = 1.
        let parts = [(Pose::translation(1.0, 0.0, 0.0), Solid::Box { edges: [0.1, 0.2, 0.3] })];
        assert_eq!(obstacles(&[of("bench", 0.0, Solid::Several(parts.into()))]), json!([bench]));
    }
}
