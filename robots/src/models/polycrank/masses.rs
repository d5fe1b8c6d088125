//! The masses of Polycrank's links: **assumed**, none is public.
//!
//! Balanced as its drives are loaded: the weight of the arm with level axes loads joints 4 to 6 by
//! [`Polycrank::GRAVITY_MOMENT`], and joint 7 not at all.

use mrroc::pose::Pose;
use mrroc::robot::{Load, Robot};
use nalgebra::{Matrix3, Translation3, Vector3};

use super::{A1, A2, L, Polycrank};
use crate::dynamics::{Segment, Tree};
use crate::models::vectors::Seven;

/// Masses of the links \[kg\].
const MASSES: [f64; 7] = [12.0, 8.0, 6.0, 3.0, 2.0, 2.0, 0.5];
/// Where the centre of the last link is on the tool's axis \[m\].
const LAST: f64 = 0.02;

fn body(mass: f64, centre: Vector3<f64>, moments: [f64; 3]) -> Load {
    Load { mass, centre, inertia: Matrix3::from_diagonal(&Vector3::from(moments)) }
}

impl Polycrank {
    /// The links, written where all joints are at 0: all cranks along x, level axes along -y.
    pub(super) fn bodies(&self) -> Option<Tree<7>> {
        let [m1, m2, m3, m4, m5, m6, m7] = MASSES;
        let [g4, g5, g6] = Self::GRAVITY_MOMENT;
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        // Counterweights put the centres where the moments are those of the drives' loads.
        let c4 = (g4 - (m5 + m6 + m7) * L) / m4;
        let c5 = (g5 - (m6 + m7) * L) / m5;
        let c6 = g6 / m6;
        let segments = vec![
            Segment::turning("crank_1", None, 0, z * (0.925 + 0.220), z).carrying(body(
                m1,
                x * (0.5 * A1),
                [0.05, 0.15, 0.15],
            )),
            Segment::turning("crank_2", Some(0), 1, Vector3::new(A1, 0.0, 0.152), z).carrying(body(
                m2,
                x * (0.5 * A2),
                [0.03, 0.06, 0.06],
            )),
            Segment::turning("shaft_3", Some(1), 2, Vector3::new(A2, 0.0, 0.335), z).carrying(body(
                m3,
                Vector3::new(0.0, -0.05, -0.1),
                [0.05, 0.05, 0.01],
            )),
            Segment::turning("crank_4", Some(2), 3, Vector3::zeros(), -y).carrying(body(
                m4,
                Vector3::new(c4, -0.120, 0.0),
                [4e-3, 0.02, 0.02],
            )),
            Segment::turning("crank_5", Some(3), 4, Vector3::new(L, -0.120, 0.0), -y).carrying(body(
                m5,
                Vector3::new(c5, -0.116, 0.0),
                [2e-3, 0.012, 0.012],
            )),
            // Above its joint what the last link is below it.
            Segment::turning("wrist_6", Some(4), 5, Vector3::new(L, -0.116, 0.0), -y).carrying(body(
                m6,
                Vector3::new(c6, -0.060, m7 * LAST / m6),
                [2e-3, 2e-3, 2e-3],
            )),
            Segment::turning("flange_7", Some(5), 6, y * -0.060, -z).carrying(body(
                m7,
                z * -LAST,
                [3e-4, 3e-4, 2e-4],
            )),
        ];
        let at_zero = Self::new().forward(&Seven::zeros());
        let tip = Pose::from_parts(Translation3::new(0.0, 0.0, -super::TIP), at_zero.rotation);
        Tree::new(self.base.X_WB, segments, tip).ok()
    }
}
