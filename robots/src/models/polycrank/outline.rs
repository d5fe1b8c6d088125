//! The shape of Polycrank.

use nalgebra::Vector3;

use super::Polycrank;
use crate::models::shape::{Capsule, Link, Motion, Outline, frames, origin, turn};
use crate::models::vectors::Seven;

/// Column of Polycrank: radius \[m\] (assumed).
const COLUMN: f64 = 0.10;
/// Radius of the cranks and shafts about upright axes \[m\] (assumed): two cranks are 0.152 m apart in height.
const UPRIGHT: f64 = 0.05;
/// Radius of the cranks and shafts about level axes \[m\] (assumed): two cranks are 0.116 m apart.
const LEVEL: f64 = 0.04;
/// Distance of a joint's frame from the one before, along the joint's axis \[m\]: the rows `d`.
const SHAFTS: [f64; 7] = [0.925 + 0.220, 0.152, 0.335, 0.120, 0.116, 0.060, 0.043];
/// The links of Polycrank with their ranks and how many joints move them. A shaft lies on its joint's axis, which does
/// not move it. Ranks of links that are joined differ by 1 at most; the wrist is so short that a tool is close to all its links.
const POLYCRANK: [(&str, u32, u32); 11] = [
    ("column", 0, 0),
    ("crank 1", 1, 1),
    ("shaft 2", 2, 1),
    ("crank 2", 3, 2),
    ("shaft 3", 4, 2),
    ("shaft 4", 5, 3),
    ("crank 4", 6, 4),
    ("shaft 5", 7, 4),
    ("crank 5", 8, 5),
    ("shaft 6", 8, 5),
    ("tip", 8, 6),
];

/// Column, radius 0.10 m, from the floor up to the first crank; cranks and shafts about upright axes 0.05 m, about level axes
/// 0.04 m.
impl Outline for Polycrank {
    type Robot = Self;

    fn robot(&self) -> &Self {
        self
    }

    fn links(&self) -> Vec<Link> {
        POLYCRANK.map(|(name, rank, joints)| Link::new(name, rank, joints)).to_vec()
    }

    fn capsules(&self, q: &Seven, visit: &mut dyn FnMut(Capsule)) {
        let (frames, _) = frames(self, q);
        let base = origin(&frames[0]);
        // Where the shaft of joint i ends and its crank begins.
        let top = |i: usize| origin(&frames[i]) + frames[i].rotation * Vector3::z() * SHAFTS[i];
        let end = |i: usize| origin(&frames[i + 1]);
        let up = (top(0) - base) / SHAFTS[0];
        visit(Capsule::new(base + up * COLUMN, top(0) - up * COLUMN, COLUMN));
        visit(Capsule::new(top(0), end(0), UPRIGHT));
        visit(Capsule::new(end(0), top(1), UPRIGHT));
        visit(Capsule::new(top(1), end(1), UPRIGHT));
        visit(Capsule::new(end(1), top(2), UPRIGHT));
        visit(Capsule::new(end(2), top(3), LEVEL));
        visit(Capsule::new(top(3), end(3), LEVEL));
        visit(Capsule::new(end(3), top(4), LEVEL));
        visit(Capsule::new(top(4), end(4), LEVEL));
        visit(Capsule::new(end(4), top(5), LEVEL));
        visit(Capsule::new(end(5), top(6), LEVEL));
    }

    fn motions(&self, q: &Seven, distances: &Seven, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        for i in 0..7 {
            visit(turn(&frames[i], Vector3::z(), distances[i]));
        }
    }
}
