//! The masses of RNT's links, **assumed** as all of it is, and what they do to the actuators.
//!
//! The arm is an open tree of eight bodies whose loops are closed by the linkages. Its coordinates, each an elevation in the
//! arm's plane or an angle of the robot:
//!
//! ```text
//! s = (q1, theta2, theta3 - theta2, q4, q5, q6, rho, sigma - rho),      rod = 0.52 e(sigma)
//! ```
//!
//! With s(q) of the linkages, sdot = G qdot and sddot = G qddot + g, the equation of motion in the actuators' lengths is
//!
//! ```text
//! G^T M G qddot + G^T (M g + h) = tau
//! ```
//!
//! (Featherstone 2008, section 8.5). Bodies are balanced as [`Rnt::GRAVITY_MOMENT`] says of upper arm and forearm; rocker and
//! rod, which that leaves out, come on top. The actuators' own masses are left out.

use core::f64::consts::{FRAC_PI_2, PI};

use mrroc::pose::Pose;
use mrroc::robot::Load;
use nalgebra::{Matrix3, SMatrix, SVector, Translation3, UnitQuaternion, Vector2, Vector3};

use super::linkage::{CRANK, FOOT2, FOOT3, Foot, Linkage, ROCKER, ROD, TAIL, left};
use super::{A1, A2, A3, D1, D6, Rnt};
use crate::dynamics::{Dynamics, Equation, Segment, Tree};
use crate::models::vectors::Six;

/// Coordinates of the open tree.
pub(super) const OPEN: usize = 8;

/// Column, rocker, rod, upper arm, forearm \[kg\].
const MASSES: [f64; 5] = [80.0, 3.0, 2.0, 14.0, 10.0];
/// The bodies that q4, q5 and q6 turn \[kg\].
const WRIST: [f64; 3] = [3.0, 2.0, 0.5];
/// Centre of the first before the wrist's centre, and of the last behind it \[m\].
const BEFORE: f64 = 0.2;
const BEHIND: f64 = 0.06;

fn body(mass: f64, centre: Vector3<f64>, moments: [f64; 3]) -> Load {
    Load { mass, centre, inertia: Matrix3::from_diagonal(&Vector3::from(moments)) }
}

impl Rnt {
    /// The arm with its loops cut at the rod's end T and at the actuators: an open tree, written with all its links along x.
    pub(super) fn open_tree(&self) -> Option<Tree<OPEN>> {
        let [column, rocker, rod, upper, forearm] = MASSES;
        let [w4, w5, w6] = WRIST;
        let [of_upper, of_forearm] = Self::GRAVITY_MOMENT;
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let beyond = forearm + w4 + w5 + w6;
        let c2 = (of_upper - beyond * A2) / upper;
        let c3 = (of_forearm - w4 * (A3 - BEFORE) - (w5 + w6) * A3) / forearm;
        let shoulder = Vector3::new(A1, 0.0, D1);
        let none = Vector3::zeros();
        // An elevation turns about -y.
        let segments = vec![
            Segment::turning("column", None, 0, none, z).carrying(body(
                column,
                Vector3::new(0.0, 0.0, 0.4),
                [4.0, 4.0, 1.5],
            )),
            Segment::turning("rocker", Some(0), 6, shoulder, -y).carrying(body(
                rocker,
                x * (0.5 * ROCKER),
                [2e-3, 0.015, 0.015],
            )),
            Segment::turning("rod", Some(1), 7, x * ROCKER, -y).carrying(body(
                rod,
                x * (0.5 * ROD),
                [1e-3, 0.045, 0.045],
            )),
            Segment::turning("upper_arm", Some(0), 1, shoulder, -y).carrying(body(
                upper,
                x * c2,
                [0.1, 0.5, 0.5],
            )),
            Segment::turning("forearm", Some(3), 2, x * A2, -y).carrying(body(
                forearm,
                x * c3,
                [0.05, 0.4, 0.4],
            )),
            Segment::turning("wrist_4", Some(4), 3, x * A3, x).carrying(body(
                w4,
                x * -BEFORE,
                [0.01, 0.02, 0.02],
            )),
            Segment::turning("wrist_5", Some(5), 4, none, y).carrying(body(
                w5,
                x * (-w6 * BEHIND / w5),
                [4e-3, 5e-3, 5e-3],
            )),
            Segment::turning("flange_6", Some(6), 5, none, x).carrying(body(
                w6,
                x * BEHIND,
                [6e-4, 5e-4, 5e-4],
            )),
        ];
        let along = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
        Tree::new(self.base.X_WB, segments, Pose::from_parts(Translation3::new(D6, 0.0, 0.0), along)).ok()
    }
}

/// The tree as the linkages set it.
pub(super) struct Posture {
    /// s [rad].
    pub(super) s: SVector<f64, OPEN>,
    /// G = ds/dq [rad/rad, rad/m].
    pub(super) rates: SMatrix<f64, OPEN, 6>,
}

impl Posture {
    /// `None` where the linkages cannot be closed.
    pub(super) fn at(q: &Six) -> Option<(Self, Linkage)> {
        let linkage = Linkage::of(q[1], q[2])?;
        let angle = |v: &Vector2<f64>| v.y.atan2(v.x);
        let (theta2, theta3) = (angle(&linkage.upper), angle(&linkage.forearm));
        // The rocker points backwards: its angle, 0 to a full turn, has no jump there.
        let (rho, sigma) = (PI + angle(&-linkage.rocker), angle(&linkage.rod));
        let s = [q[0], theta2, theta3 - theta2, q[3], q[4], q[5], rho, sigma - rho];
        let (upper, forearm_by_2, forearm_by_3) = linkage.rates(q[1], q[2]);
        let rocker = -q[2] / (FOOT3.distance * ROCKER * linkage.sines[1]);
        // Rod's speed: its end moves with the forearm's tail, its other one with the rocker.
        let across = left(&linkage.rod) / (ROD * ROD);
        let of_tail = |upper: f64, forearm: f64| {
            left(&linkage.upper) * (A2 * upper) - left(&linkage.forearm) * (TAIL * forearm)
        };
        let rod_by_2 = across.dot(&of_tail(upper, forearm_by_2));
        let rod_by_3 = across.dot(&(of_tail(0.0, forearm_by_3) - left(&linkage.rocker) * (ROCKER * rocker)));
        let mut rates = SMatrix::zeros();
        for i in [0, 3, 4, 5] {
            rates[(i, i)] = 1.0;
        }
        rates[(1, 1)] = upper;
        rates[(2, 1)] = forearm_by_2 - upper;
        rates[(2, 2)] = forearm_by_3;
        rates[(6, 2)] = rocker;
        rates[(7, 1)] = rod_by_2;
        rates[(7, 2)] = rod_by_3 - rocker;
        Some((Self { s: s.into(), rates }, linkage))
    }
}

/// g: the accelerations of the tree's coordinates [rad/s²] while the actuators' speeds do not change.
fn drift(linkage: &Linkage, q: &Six, velocity: &Six, sdot: &SVector<f64, OPEN>) -> SVector<f64, OPEN> {
    let (upper, forearm) = (sdot[1], sdot[1] + sdot[2]);
    let (rocker, rod) = (sdot[6], sdot[6] + sdot[7]);
    // Twice the derivative of the law of cosines.
    let crank = |foot: Foot, length: f64, q: f64, speed: f64, sine: f64, turned: f64| {
        let product = foot.distance * length;
        let cosine = (foot.distance * foot.distance + length * length - q * q) / (2.0 * product);
        (speed * speed - product * cosine * turned * turned) / (product * sine)
    };
    let upper_changes = crank(FOOT2, CRANK, q[1], velocity[1], linkage.sines[0], upper);
    let rocker_changes = -crank(FOOT3, ROCKER, q[2], velocity[2], linkage.sines[1], rocker);
    // The end of a link of this direction: its acceleration by length.
    let end = |direction: &Vector2<f64>, speed: f64, change: f64| {
        left(direction) * change - direction * (speed * speed)
    };
    // The rod keeps its length: rod . (T - R)'' + |(T - R)'|² = 0.
    let without = end(&linkage.upper, upper, upper_changes) * A2
        - end(&linkage.forearm, forearm, 0.0) * TAIL
        - end(&linkage.rocker, rocker, rocker_changes) * ROCKER;
    let across = left(&linkage.forearm) * TAIL;
    let forearm_changes = (linkage.rod.dot(&without) + ROD * ROD * rod * rod) / linkage.rod.dot(&across);
    let rod_changes = left(&linkage.rod).dot(&(without - across * forearm_changes)) / (ROD * ROD);
    let mut drift = SVector::zeros();
    drift[1] = upper_changes;
    drift[2] = forearm_changes - upper_changes;
    drift[6] = rocker_changes;
    drift[7] = rod_changes - rocker_changes;
    drift
}

/// RNT's dynamics in its own joints.
#[derive(Clone, Debug)]
pub(super) struct Closed(pub(super) Tree<OPEN>);

impl Dynamics<6> for Closed {
    /// Where the linkages cannot be closed (far outside the limits), NaN.
    fn equation(&self, q: &Six, velocity: &Six) -> Equation<6> {
        let Some((Posture { s, rates }, linkage)) = Posture::at(q) else {
            return Equation { mass: SMatrix::repeat(f64::NAN), bias: SVector::repeat(f64::NAN) };
        };
        let sdot = rates * velocity;
        let Equation { mass, bias } = self.0.equation(&s, &sdot);
        let forces = mass * drift(&linkage, q, velocity, &sdot) + bias;
        Equation { mass: rates.transpose() * mass * rates, bias: rates.transpose() * forces }
    }
}
