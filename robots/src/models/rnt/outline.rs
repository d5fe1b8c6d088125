//! The shape of RNT, whose arm, rod, rocker and actuators form closed loops.
//!
//! Its joints are lengths; what turns the links follows from the loops. The forearm's angle to the upper arm depends on the
//! angle `delta = theta2 - rho` between upper arm and rocker alone, and grows or falls with it as long as the rod does not
//! pass a dead centre: within `w2`, `w3` of now it is between its values at `delta +- (w2 + w3)`.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use nalgebra::{Vector2, Vector3};

use super::linkage::{CRANK, FOOT2, FOOT3, Foot, Linkage, ROCKER, ROD, TAIL};
use super::{A1, A2, Rnt};
use crate::models::shape::{Capsule, Link, Motion, Outline, frames, origin, turn};
use crate::models::vectors::Six;

/// Radius of the column \[m\] (assumed).
const COLUMN: f64 = 0.12;
/// Radii of upper arm, forearm and wrist \[m\] (assumed).
const ARM: [f64; 3] = [0.07, 0.06, 0.05];
/// Radius of the actuators and of the rod \[m\] (assumed).
const BARS: f64 = 0.04;
/// Frames that RNT shows where its linkages can be closed.
const FRAME_COUNT: usize = 8;
/// The motions, as bits: column; rocker; upper arm, forearm, and the wrist's three. What has ends on two links is moved by no
/// more than by the motions of both; the rocker's stands before the others, so that, seen from any link behind the column,
/// none of them counts as carried along by it.
const COLUMN_TURN: u32 = 1 << 0;
const ROCKING: u32 = 1 << 1;
const UPPER_ARM: u32 = 1 << 2;
const FOREARM: u32 = 1 << 3;
const WRIST: u32 = 0b11 << 4;
const FLANGE: u32 = 1 << 6;

/// Where an actuator is fixed to the column, in the frame of the column at the shoulder's height.
fn fixed_at(foot: Foot) -> Vector3<f64> {
    Vector3::new(A1 + foot.distance * foot.cosine, 0.0, foot.distance * foot.sine)
}

/// Largest turns of upper arm, forearm (against the upper arm) and rocker \[rad\], when the actuators' lengths change by at
/// most `change2`, `change3` \[m\].
fn turns(linkage: &Linkage, q2: f64, q3: f64, change2: f64, change3: f64) -> [f64; 3] {
    let w2 = by_length(FOOT2.distance, CRANK, q2, change2);
    let w3 = by_length(FOOT3.distance, ROCKER, q3, change3);
    let delta = linkage.rocker.perp(&linkage.upper).atan2(linkage.rocker.dot(&linkage.upper));
    let bends = [0.0, -w2 - w3, w2 + w3].map(|change| bend(delta + change));
    let forearm = match bends {
        [Some(now), Some(less), Some(more)] => (less - now).abs().max((more - now).abs()),
        _ => PI,
    };
    [w2, forearm, w3]
}

/// Angle of the forearm against the upper arm \[rad\] when that stands at `delta` against the rocker; `None` where the loop
/// cannot be closed, or is at a dead centre or beyond.
fn bend(delta: f64) -> Option<f64> {
    let rocker = Vector2::new(delta.cos(), -delta.sin());
    let between = Vector2::new(A2, 0.0) - rocker * ROCKER;
    let square = between.norm_squared();
    let along = (square + ROD * ROD - TAIL * TAIL) / (2.0 * square);
    let across = ROD * ROD / square - along * along;
    if across.is_nan() || across <= 0.0 {
        return None;
    }
    let rod = between * along + Vector2::new(-between.y, between.x) * across.sqrt();
    let forearm = between - rod;
    (rod.perp(&rocker) > 0.0).then(|| forearm.y.atan2(forearm.x))
}

/// Largest turn of a crank \[rad\] when the bar from a foot at `distance` that turns it is `length` long, give or take `change`
/// \[m\]; all that it can, where the bar could be too short or too long.
fn by_length(distance: f64, crank: f64, length: f64, change: f64) -> f64 {
    let at = |length: f64| {
        let cosine = (distance * distance + crank * crank - length * length) / (2.0 * distance * crank);
        if cosine.abs() <= 1.0 { cosine.acos() } else { f64::NAN }
    };
    let now = at(length);
    let less = (at(length - change) - now).abs();
    let more = (at(length + change) - now).abs();
    if less.is_nan() || more.is_nan() { PI } else { less.max(more) }
}

/// Column, radius 0.12 m, from the floor to the shoulder; upper arm 0.07 m; forearm with its tail 0.06 m; wrist 0.05 m; rod and
/// actuators 0.04 m. All within the linkage counts as joined.
impl Outline for Rnt {
    type Robot = Self;

    fn robot(&self) -> &Self {
        self
    }

    fn links(&self) -> Vec<Link> {
        let link = |name: &str, rank, moved_by| Link { name: name.into(), rank, moved_by };
        let upper = COLUMN_TURN | UPPER_ARM;
        vec![
            link("column", 0, COLUMN_TURN),
            link("shoulder actuator", 0, upper | ROCKING),
            link("elbow actuator", 0, COLUMN_TURN | ROCKING),
            link("upper arm", 1, upper),
            link("rod", 1, upper | FOREARM | ROCKING),
            link("forearm", 2, upper | FOREARM),
            link("wrist", 3, upper | FOREARM | WRIST),
        ]
    }

    fn capsules(&self, q: &Six, visit: &mut dyn FnMut(Capsule)) {
        let (frames, count) = frames(self, q);
        if count != FRAME_COUNT {
            return;
        }
        let [base, column, o, r, t, e, c, f] = frames.map(|frame| origin(&frame));
        let up = frames[1].rotation * Vector3::z();
        let fixed = |p: Vector3<f64>| column + frames[1].rotation * p;
        visit(Capsule::new(base + up * COLUMN, column - up * COLUMN, COLUMN));
        visit(Capsule::new(fixed(fixed_at(FOOT2)), o + (e - o) * (CRANK / A2), BARS));
        visit(Capsule::new(fixed(fixed_at(FOOT3)), r, BARS));
        visit(Capsule::new(o, e, ARM[0]));
        visit(Capsule::new(r, t, BARS));
        visit(Capsule::new(t, c, ARM[1]));
        visit(Capsule::new(c, f, ARM[2]));
    }

    fn motions(&self, q: &Six, distances: &Six, visit: &mut dyn FnMut(Motion)) {
        let (frames, count) = frames(self, q);
        let Some(linkage) = Linkage::of(q[1], q[2]).filter(|_| count == FRAME_COUNT) else { return };
        let [upper, forearm, rocker] = turns(&linkage, q[1], q[2], distances[1], distances[2]);
        let [shoulder, elbow, centre, flange]: [&Pose; 4] = [&frames[2], &frames[5], &frames[6], &frames[7]];
        visit(turn(&frames[1], Vector3::z(), distances[0]));
        visit(turn(shoulder, Vector3::y(), rocker));
        visit(turn(shoulder, Vector3::y(), upper));
        visit(turn(elbow, Vector3::y(), forearm));
        visit(turn(elbow, Vector3::x(), distances[3]));
        visit(Motion::Turn { point: origin(centre), axis: None, bound: distances[4] });
        visit(turn(flange, Vector3::z(), distances[5]));
    }

    fn flange_motions(&self) -> u32 {
        COLUMN_TURN | UPPER_ARM | FOREARM | WRIST | FLANGE
    }
}
