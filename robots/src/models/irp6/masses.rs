//! The masses of the IRp-6's links: **assumed**, none is public.
//!
//! Plausible for an arm of its size and balanced as its drives are loaded: with the springs of the real arm taken for
//! counterweights, the tree's weight loads lower and upper arm by [`Irp6::GRAVITY_MOMENT`] and no other joint. Bodies are written
//! where all joints are at 0: lower arm forwards (x), upper arm and wrist downwards (-z). Parallelograms and screws are
//! counted with the links; their inertia, where it does not turn with these, is left out.

use mrroc::pose::Pose;
use mrroc::robot::Load;
use nalgebra::{Matrix3, Translation3, UnitQuaternion, Vector3};

use super::arm::Irp6;
use super::five::Irp6FiveDof;
use super::links::Geometry;
use super::track::Irp6Track;
use crate::dynamics::{Segment, Tree};

/// Carriage of the track, with its motors \[kg\].
const CARRIAGE: f64 = 80.0;
/// Column, lower arm, upper arm \[kg\].
const COLUMN: f64 = 60.0;
const LOWER: f64 = 16.0;
const UPPER: f64 = 12.0;
/// T, V and N: the wrist \[kg\].
const WRIST: [f64; 3] = [2.5, 1.0, 0.5];
/// Where V's centre is beyond T \[m\].
const ROLL: f64 = 0.06;

fn body(mass: f64, centre: Vector3<f64>, moments: [f64; 3]) -> Load {
    Load { mass, centre, inertia: Matrix3::from_diagonal(&Vector3::from(moments)) }
}

/// Column, lower and upper arm from coordinate `first` on, and T without its body.
fn arm(segments: &mut Vec<Segment>, geometry: &Geometry, shoulder: Vector3<f64>, first: usize) {
    let Geometry { a2, a3, .. } = *geometry;
    let [lower_moment, upper_moment] = Irp6::GRAVITY_MOMENT;
    let wrist: f64 = WRIST.iter().sum();
    // What is missing of the moments: counterweights put the centres there.
    let of_lower = (lower_moment - (UPPER + wrist) * a2) / LOWER;
    let of_upper = (upper_moment - wrist * a3) / UPPER;
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let carrier = segments.len().checked_sub(1);
    let at = segments.len();
    segments.push(Segment::turning("column", carrier, first, shoulder, z).carrying(body(
        COLUMN,
        Vector3::new(-0.05, 0.0, -0.15),
        [1.5, 1.5, 1.0],
    )));
    segments.push(Segment::turning("lower_arm", Some(at), first + 1, Vector3::zeros(), y).carrying(body(
        LOWER,
        x * of_lower,
        [0.1, 0.8, 0.8],
    )));
    segments.push(Segment::turning("upper_arm", Some(at + 1), first + 2, x * a2, y).carrying(body(
        UPPER,
        z * -of_upper,
        [0.9, 0.9, 0.08],
    )));
    segments.push(Segment::turning("wrist_t", Some(at + 2), first + 3, z * -a3, y));
}

/// The six-joint arm from coordinate `first` on.
fn six(segments: &mut Vec<Segment>, geometry: &Geometry, first: usize) {
    let d5 = geometry.d5;
    let z = Vector3::z();
    arm(segments, geometry, Vector3::zeros(), first);
    let [t, v, n] = WRIST;
    // T balances V and N.
    let behind = (v * ROLL + n * d5) / t;
    let at = segments.len() - 1;
    segments[at].body = body(t, z * behind, [0.02, 0.02, 0.006]);
    segments.push(Segment::turning("wrist_v", Some(at), first + 4, Vector3::zeros(), -z).carrying(body(
        v,
        z * -ROLL,
        [4e-3, 4e-3, 1e-3],
    )));
    // At 0, N's axis is z_F = y.
    segments.push(
        Segment::turning("flange_n", Some(at + 1), first + 5, z * -d5, Vector3::y()).carrying(body(
            n,
            Vector3::zeros(),
            [4e-4, 6e-4, 4e-4],
        )),
    );
}

/// The turn of the flange where all joints are at 0.
fn flange(geometry: &Geometry) -> Pose {
    let pose = geometry.flange(&super::super::vectors::Six::zeros());
    Pose::from_parts(Translation3::identity(), pose.rotation)
}

impl Irp6 {
    /// The links of the arm.
    pub(super) fn bodies(geometry: &Geometry, base: Pose) -> Option<Tree<6>> {
        let mut segments = Vec::new();
        six(&mut segments, geometry, 0);
        Tree::new(base, segments, flange(geometry)).ok()
    }
}

impl Irp6Track {
    /// The carriage and the links of the arm on it.
    pub(super) fn bodies(geometry: &Geometry, base: Pose) -> Option<Tree<7>> {
        let carriage = Segment::sliding("carriage", None, 0, Vector3::zeros(), Vector3::y());
        let mut segments =
            vec![carriage.carrying(body(CARRIAGE, Vector3::new(-0.1, 0.0, -0.4), [6.0, 6.0, 4.0]))];
        six(&mut segments, geometry, 1);
        Tree::new(base, segments, flange(geometry)).ok()
    }
}

impl Irp6FiveDof {
    /// The links of the arm; T has the mass of N as well.
    pub(super) fn bodies(geometry: &Geometry, base: Pose) -> Option<Tree<5>> {
        let d6 = geometry.d5;
        let z = Vector3::z();
        let mut segments = Vec::new();
        arm(&mut segments, geometry, z * Self::D1, 0);
        let [t, v, n] = WRIST;
        let at = segments.len() - 1;
        segments[at].body = body(t + n, z * (v * 0.5 * d6 / (t + n)), [0.02, 0.02, 0.006]);
        segments.push(Segment::turning("wrist_v", Some(at), 4, Vector3::zeros(), -z).carrying(body(
            v,
            z * (-0.5 * d6),
            [2e-3, 2e-3, 1e-3],
        )));
        // At 0, x_F is forwards and z_F downwards.
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
        let tip = Pose::from_parts(Translation3::new(0.0, 0.0, -d6), turn);
        Tree::new(base, segments, tip).ok()
    }
}
