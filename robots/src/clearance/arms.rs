//! The shapes of the arms of this crate.
//!
//! Lengths are those of the kinematics. **Radii are assumed**: no drawings of the covers are public; they were chosen to
//! hold the links, drives and cables of arms of this size. Scale them, or write an own [`Outline`], for a real cell.
//! The gripper is part of an arm's tool, the conveyor an obstacle.

use mrroc::{Pose, Robot};
use nalgebra::Vector3;

use super::capsule::Capsule;
use super::outline::{Link, Motion, Outline};
use crate::irp6::{Irp6, Six};
use crate::irp6_five::{Five, Irp6FiveDof};
use crate::irp6_track::{Irp6Track, Seven};
use crate::polycrank::Polycrank;

/// Radius of the IRp-6's postument \[m\] (assumed).
const POSTUMENT: f64 = 0.15;
/// Radii of the IRp-6's lower arm, upper arm and wrist \[m\] (assumed).
const IRP6_RADII: [f64; 3] = [0.09, 0.08, 0.06];
/// From the shoulder of the IRp-6 down to the floor \[m\] (MRROC++: d1).
const SHOULDER_HEIGHT: f64 = Irp6FiveDof::D1;

/// The most frames that an arm shows.
const FRAMES: usize = 8;

/// The frames that a robot shows at `q`, from base to flange, and how many they are.
pub(crate) fn frames<R: Robot>(robot: &R, q: &R::Joints) -> ([Pose; FRAMES], usize) {
    let (mut frames, mut count) = ([Pose::identity(); FRAMES], 0);
    robot.frames(q, &mut |frame| {
        if let Some(place) = frames.get_mut(count) {
            *place = *frame;
        }
        count += 1;
    });
    (frames, count)
}

/// Origin of a frame \[m\].
pub(crate) fn origin(frame: &Pose) -> Vector3<f64> {
    frame.translation.vector
}

/// A turn about an axis of a frame, through its origin.
pub(crate) fn turn(frame: &Pose, axis: Vector3<f64>, way: f64) -> Motion {
    Motion::Turn { point: origin(frame), axis: Some(frame.rotation * axis), way }
}

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
fn irp6_motions(frames: &[Pose], way: [f64; 5], visit: &mut dyn FnMut(Motion)) {
    visit(turn(&frames[0], Vector3::z(), way[0]));
    visit(turn(&frames[0], Vector3::y(), way[1]));
    visit(turn(&frames[1], Vector3::y(), way[2]));
    visit(turn(&frames[2], Vector3::y(), way[3]));
    visit(turn(&frames[2], Vector3::x(), way[4]));
}

/// The links of an IRp-6 behind so many other motions. Rolling about d5 moves nothing of the wrist.
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

    fn motions(&self, q: &Six, way: &Six, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        irp6_motions(&frames[1..], core::array::from_fn(|i| way[i]), visit);
        visit(turn(&frames[5], Vector3::z(), way[5]));
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

    fn motions(&self, q: &Five, way: &Five, visit: &mut dyn FnMut(Motion)) {
        irp6_motions(&frames(self, q).0[1..], core::array::from_fn(|i| way[i]), visit);
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

    fn motions(&self, q: &Seven, way: &Seven, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        visit(Motion::Slide { way: way[0] });
        irp6_motions(&frames[2..], core::array::from_fn(|i| way[i + 1]), visit);
        visit(turn(&frames[6], Vector3::z(), way[6]));
    }
}

/// Column of Polycrank: radius \[m\] (assumed).
const COLUMN: f64 = 0.10;
/// Radius of the cranks and shafts about upright axes \[m\] (assumed): two cranks are 0.152 m apart in height.
const UPRIGHT: f64 = 0.05;
/// Radius of the cranks and shafts about level axes \[m\] (assumed): two cranks are 0.116 m apart.
const LEVEL: f64 = 0.04;
/// Distance of a joint's frame from the one before, along the joint's axis \[m\]: the rows `d`.
const SHAFTS: [f64; 7] = [0.925 + 0.220, 0.152, 0.335, 0.120, 0.116, 0.060, 0.043];
/// The links of Polycrank with their ranks and how many joints move them. A shaft lies on its joint's axis, which does
/// not move it. The ranks of what is joined differ by 1 at most; the wrist is so short that a tool is beside all of it.
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

    fn motions(&self, q: &Seven, way: &Seven, visit: &mut dyn FnMut(Motion)) {
        let (frames, _) = frames(self, q);
        for i in 0..7 {
            visit(turn(&frames[i], Vector3::z(), way[i]));
        }
    }
}
