//! The shape of the IRp-6 and its variants.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::arm::Irp6;
use super::five::Irp6FiveDof;
use super::track::Irp6Track;
use crate::models::shape::{Capsule, Link, Motion, Outline, frames, origin, turn};
use crate::models::vectors::{Five, Seven, Six};

/// Radius of the IRp-6's postument \[m\] (assumed).
const POSTUMENT: f64 = 0.15;
/// Radii of the IRp-6's lower arm, upper arm and wrist \[m\] (assumed).
const IRP6_RADII: [f64; 3] = [0.09, 0.08, 0.06];
/// From the shoulder of the IRp-6 down to the floor \[m\] (MRROC++: d1).
const SHOULDER_HEIGHT: f64 = Irp6FiveDof::D1;

/// Visits the capsules of an IRp-6 whose shoulder, elbow, T and end of d5 these frames are.
fn irp6_capsules(frames: &[Pose], visit: &mut dyn FnMut(Capsule)) {
    let [shoulder, elbow, t, end] = [0, 1, 2, 3].map(|i| origin(&frames[i]));
    let z = frames[0].rotation * Vector3::z();
    visit(Capsule::new(shoulder - z * POSTUMENT, shoulder - z * (SHOULDER_HEIGHT - POSTUMENT), POSTUMENT));
    visit(Capsule::new(shoulder, elbow, IRP6_RADII[0]));
    visit(Capsule::new(elbow, t, IRP6_RADII[1]));
    visit(Capsule::new(t, end, IRP6_RADII[2]));
}

/// Visits the motions of an IRp-6's first five joints.
fn irp6_motions(frames: &[Pose], distances: [f64; 5], visit: &mut dyn FnMut(Motion)) {
    visit(turn(&frames[0], Vector3::z(), distances[0]));
    visit(turn(&frames[0], Vector3::y(), distances[1]));
    visit(turn(&frames[1], Vector3::y(), distances[2]));
    visit(turn(&frames[2], Vector3::y(), distances[3]));
    visit(turn(&frames[2], Vector3::x(), distances[4]));
}

/// The links of an IRp-6 whose base is moved by the first `before` motions. Rolling about d5 does not move the wrist's
/// capsule.
fn irp6_links(before: u32) -> Vec<Link> {
    vec![
        Link::new("postument", 0, before),
        Link::new("lower arm", 1, before + 2),
        Link::new("upper arm", 2, before + 3),
        Link::new("wrist", 3, before + 4),
    ]
}

/// Postument, radius 0.15 m, from the shoulder 0.7 m down to the floor; lower arm 0.09 m; upper arm 0.08 m; wrist 0.06 m.
impl Outline for Irp6 {
    type Robot = Self;

    fn robot(&self) -> &Self {
        self
    }

    fn links(&self) -> Vec<Link> {
        irp6_links(0)
    }

    fn capsules(&self, q: &Six, visit: &mut dyn FnMut(Capsule)) {
        irp6_capsules(&frames(self, q).0[1..], visit);
    }

    fn motions(&self, q: &Six, distances: &Six, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        irp6_motions(&frames[1..], core::array::from_fn(|i| distances[i]), visit);
        visit(turn(&frames[5], Vector3::z(), distances[5]));
    }
}

/// As of [`Irp6`]; its base stands on the floor.
impl Outline for Irp6FiveDof {
    type Robot = Self;

    fn robot(&self) -> &Self {
        self
    }

    fn links(&self) -> Vec<Link> {
        irp6_links(0)
    }

    fn capsules(&self, q: &Five, visit: &mut dyn FnMut(Capsule)) {
        irp6_capsules(&frames(self, q).0[1..], visit);
    }

    fn motions(&self, q: &Five, distances: &Five, visit: &mut dyn FnMut(Motion)) {
        irp6_motions(&frames(self, q).0[1..], core::array::from_fn(|i| distances[i]), visit);
    }
}

/// As of [`Irp6`]; the postument stands on the carriage. The track itself is an obstacle of the cell.
impl Outline for Irp6Track {
    type Robot = Self;

    fn robot(&self) -> &Self {
        self
    }

    fn links(&self) -> Vec<Link> {
        irp6_links(1)
    }

    fn capsules(&self, q: &Seven, visit: &mut dyn FnMut(Capsule)) {
        irp6_capsules(&frames(self, q).0[2..], visit);
    }

    fn motions(&self, q: &Seven, distances: &Seven, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        visit(Motion::Slide { bound: distances[0] });
        irp6_motions(&frames[2..], core::array::from_fn(|i| distances[i + 1]), visit);
        visit(turn(&frames[6], Vector3::z(), distances[6]));
    }
}
