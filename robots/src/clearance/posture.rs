//! A robot of any kind as the clearance sees it: capsules where they are, and how far each may still get.

use std::sync::Arc;

use mrroc::fault::Name;
use mrroc::prelude::*;
use mrroc::robot::{JointKind, JointVector, Limits, MAX_JOINTS};
use nalgebra::{SVector, Vector3};

use super::stopping::{Pace, Stopping};
use crate::models::{Capsule, Chain, Link, Motion, Outline};

/// Joint positions or velocities of a robot of any kind, as the runtime passes them.
pub type Joints = [f64; MAX_JOINTS];

/// Where the joints of a robot are on a stretch of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Positions in the middle of the stretch [rad or m], which the robot passes.
    pub middle: Joints,
    /// By how much each joint is off them at most, either way [rad or m], >= 0.
    pub half: Joints,
}

/// The most motions that a robot's outline may have.
const MOTIONS: usize = 17;

/// An [`Outline`] without its type: joints are the first of eight numbers.
pub trait Shape: Send + Sync {
    /// As [`Outline::links`].
    fn links(&self) -> Vec<Link>;
    /// As [`Outline::capsules`].
    fn capsules(&self, q: &Joints, visit: &mut dyn FnMut(Capsule));
    /// As [`Outline::motions`].
    fn motions(&self, q: &Joints, distances: &Joints, visit: &mut dyn FnMut(Motion));
    /// As [`Outline::flange_motions`].
    fn flange_motions(&self) -> u32;
    /// As [`Outline::chain`].
    fn chain(&self) -> Option<Chain>;
    /// Pose of the flange in the world at `q` [rad or m].
    fn flange(&self, q: &Joints) -> Pose;
    /// The robot's limits; those beyond its joints are 0.
    fn limits(&self) -> Limits<SVector<f64, MAX_JOINTS>>;
    /// What kind each joint is, in their order.
    fn kinds(&self) -> Vec<JointKind>;
    /// Whether joints share limits, so that not every position within the limits is possible.
    fn is_coupled(&self) -> bool;
    /// Whether the position keeps the limits that joints share.
    fn is_possible(&self, q: &Joints) -> bool;
    /// The position that lies `part` (0 to 1 each) of the way between the limits; endless joints within a turn.
    fn between_limits(&self, part: &dyn Fn(usize) -> f64) -> Joints;
    /// The largest `v/a` of its joints, of which the slowest decides how long a stop of the cell takes.
    fn pace(&self, stopping: &Stopping, velocity: &Joints) -> Pace;
    /// How far each joint still moves in such a stop [rad or m].
    fn stopping_distances(&self, stopping: &Stopping, velocity: &Joints, cell: &Pace) -> Joints;
    /// How much of these distances each joint may go against its velocity [rad or m].
    fn backwards(&self, stopping: &Stopping, velocity: &Joints, distances: &Joints, cell: &Pace) -> Joints;
}

impl<O: Outline> Shape for O {
    fn links(&self) -> Vec<Link> {
        Outline::links(self)
    }

    fn capsules(&self, q: &Joints, visit: &mut dyn FnMut(Capsule)) {
        Outline::capsules(self, &JointVector::from_joints(|i| q[i]), visit);
    }

    fn motions(&self, q: &Joints, distances: &Joints, visit: &mut dyn FnMut(Motion)) {
        let joints = |values: &Joints| JointVector::from_joints(|i| values[i]);
        Outline::motions(self, &joints(q), &joints(distances), visit);
    }

    fn chain(&self) -> Option<Chain> {
        Outline::chain(self)
    }

    fn limits(&self) -> Limits<SVector<f64, MAX_JOINTS>> {
        let limits = self.robot().limits();
        let padded = |joints: &<O::Robot as Robot>::Joints| SVector::from(padded(joints));
        Limits {
            lower: padded(&limits.lower),
            upper: padded(&limits.upper),
            velocity: padded(&limits.velocity),
            acceleration: padded(&limits.acceleration),
            jerk: limits.jerk.as_ref().map(padded),
        }
    }

    fn kinds(&self) -> Vec<JointKind> {
        (0..<O::Robot as Robot>::Joints::LEN).map(|i| self.robot().joint(i)).collect()
    }

    fn is_coupled(&self) -> bool {
        !self.robot().coupled_limits().is_empty()
    }

    fn flange(&self, q: &Joints) -> Pose {
        self.robot().forward(&JointVector::from_joints(|i| q[i]))
    }

    fn flange_motions(&self) -> u32 {
        Outline::flange_motions(self)
    }

    fn pace(&self, stopping: &Stopping, velocity: &Joints) -> Pace {
        stopping.pace(self.robot().limits(), velocity)
    }

    fn stopping_distances(&self, stopping: &Stopping, velocity: &Joints, cell: &Pace) -> Joints {
        let stopping_distances: <O::Robot as Robot>::Joints =
            stopping.stopping_distances(self.robot().limits(), velocity, cell);
        padded(&stopping_distances)
    }

    fn backwards(&self, stopping: &Stopping, velocity: &Joints, distances: &Joints, cell: &Pace) -> Joints {
        let distances: <O::Robot as Robot>::Joints = JointVector::from_joints(|i| distances[i]);
        padded(&stopping.backwards(self.robot().limits(), velocity, &distances, cell))
    }

    fn between_limits(&self, part: &dyn Fn(usize) -> f64) -> Joints {
        const TURN: f64 = core::f64::consts::PI;
        let limits = self.robot().limits();
        let q: <O::Robot as Robot>::Joints = JointVector::from_joints(|i| {
            let mut lower = limits.lower[i];
            let mut upper = limits.upper[i];
            if self.robot().joint(i) == JointKind::Revolute && lower < -TURN && upper > TURN {
                lower = -TURN;
                upper = TURN;
            }
            lower + (upper - lower) * part(i)
        });
        padded(&q)
    }

    fn is_possible(&self, q: &Joints) -> bool {
        let q = JointVector::from_joints(|i| q[i]);
        self.robot().check_coupled(&q, &q, 1.0).is_ok()
    }
}

fn padded<J: JointVector>(joints: &J) -> Joints {
    let mut all = [0.0; MAX_JOINTS];
    for (place, value) in all.iter_mut().zip(joints.as_slice()) {
        *place = *value;
    }
    all
}

/// A capsule where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) capsule: Capsule,
    pub(super) centre: Vector3<f64>,
    pub(super) around: f64,
    /// How far any of its points may still get \[m\] by the motions from the `i`th on.
    pub(super) travel: [f64; MOTIONS + 1],
}

impl Placed {
    pub(super) fn new(capsule: Capsule) -> Self {
        let (centre, around) = capsule.ball();
        Self { capsule, centre, around, travel: [0.0; MOTIONS + 1] }
    }
}

/// How far any point of a link's capsule may get \[m\] by the motions from the `i`th on.
pub(super) fn travel(link: &Link, capsule: &Capsule, motions: &[Motion]) -> [f64; MOTIONS + 1] {
    let mut travel = [0.0; MOTIONS + 1];
    // Seen from now, the last joint moves first; those before carry on what it did.
    for (i, motion) in motions.iter().enumerate().take(MOTIONS).rev() {
        let moved = travel[i + 1];
        let is_moved = link.moved_by >> i & 1 == 1;
        travel[i] = moved + if is_moved { motion.travel(capsule, moved) } else { 0.0 };
    }
    travel
}

/// A robot, what it carries, and where it is.
#[derive(Clone)]
pub(super) struct Placement {
    pub(super) name: Name,
    shape: Arc<dyn Shape>,
    /// The robot's own links, then what it carries.
    pub(super) links: Vec<Link>,
    own: usize,
    /// Capsules in the flange's frame.
    carried: Vec<Capsule>,
    pub(super) placed: Vec<Placed>,
    motions: Vec<Motion>,
}

impl Placement {
    pub(super) fn new(name: Name, shape: Arc<dyn Shape>) -> Self {
        let links = shape.links();
        let own = links.len();
        let placed = Vec::with_capacity(own);
        Self { name, shape, links, own, carried: Vec::new(), placed, motions: Vec::with_capacity(MOTIONS) }
    }

    /// Number of the robot's own links.
    pub(super) const fn own(&self) -> usize {
        self.own
    }

    pub(super) fn shape(&self) -> &Arc<dyn Shape> {
        &self.shape
    }

    /// What it carries, in the flange's frame.
    pub(super) fn carried(&self) -> &[Capsule] {
        &self.carried
    }

    /// Fixes a capsule, given in F, to the flange.
    pub(super) fn carry(&mut self, link: Link, capsule: Capsule) {
        self.links.push(link);
        self.carried.push(capsule);
        self.placed.reserve(self.links.len() - self.placed.len());
    }

    /// Takes away what is carried under this name; whether there was any.
    pub(super) fn drop_carried(&mut self, name: &str) -> bool {
        let before = self.carried.len();
        for i in (self.own..self.links.len()).rev() {
            if &*self.links[i].name == name {
                self.links.remove(i);
                self.carried.remove(i - self.own);
            }
        }
        self.carried.len() != before
    }

    /// Stands the robot at `q`, its joints moving by at most `distances` more; whether it can stand there.
    #[allow(non_snake_case)]
    pub(super) fn stand(&mut self, q: &Joints, distances: Option<&Joints>) -> bool {
        let Self { shape, links, own, carried, placed, motions, .. } = self;
        placed.clear();
        shape.capsules(q, &mut |capsule| {
            if placed.len() < *own {
                placed.push(Placed::new(capsule));
            }
        });
        if placed.len() != *own {
            return false;
        }
        if !carried.is_empty() {
            let X_WF = shape.flange(q);
            placed.extend(carried.iter().map(|capsule| Placed::new(capsule.moved(&X_WF))));
        }
        if let Some(distances) = distances {
            motions.clear();
            shape.motions(q, distances, &mut |motion| {
                if motions.len() < MOTIONS {
                    motions.push(motion);
                }
            });
            for (link, placed) in links.iter().zip(placed.iter_mut()) {
                placed.travel = travel(link, &placed.capsule, motions);
            }
        }
        placed.iter().all(|placed| placed.around.is_finite() && placed.centre.sum().is_finite())
            && placed.iter().all(|placed| placed.travel[0].is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Irp6, Irp6FiveDof, Irp6Track, Polycrank, Rnt, Serial, SerialOutline};
    use nalgebra::Point3;
    use proptest::prelude::*;

    /// An arm read from a file of `tests/reference/urdf`, with stout links.
    fn read<const N: usize>(text: &str, ends: [&str; 2], base: Pose) -> Arc<dyn Shape> {
        let builder = Serial::<N>::from_urdf(text, ends[0], ends[1]).unwrap();
        let robot = builder.with_acceleration(nalgebra::SVector::repeat(0.5)).unwrap();
        Arc::new(SerialOutline::new(robot.with_base(base), 0.05))
    }

    fn arms() -> Vec<Placement> {
        let base = Pose::new(Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.2, 0.4, -1.0));
        let shapes: [Arc<dyn Shape>; 7] = [
            Arc::new(Irp6::nominal().with_base(base)),
            Arc::new(Irp6FiveDof::nominal().with_base(base)),
            Arc::new(Irp6Track::nominal().with_base(base)),
            Arc::new(Rnt::new().with_base(base)),
            Arc::new(Polycrank::new().with_base(base)),
            read::<4>(include_str!("../../tests/reference/urdf/gantry.urdf"), ["bed", "tool"], base),
            read::<4>(include_str!("../../tests/reference/urdf/palletiser.urdf"), ["base", "tool"], base),
        ];
        shapes.map(|shape| Placement::new(Name::new("arm").unwrap(), shape)).into_iter().collect()
    }

    proptest! {
        /// Wherever the joints go within their distances, no end of a capsule gets farther than its travel, and no two links of one
        /// robot nearer than by the travels of the motions between.
        #[test]
        fn no_end_of_a_link_gets_farther_than_its_travel(
            part in proptest::array::uniform8(0.05..0.95_f64),
            distances in proptest::array::uniform8(0.0..0.5_f64),
            to in proptest::array::uniform8(-1.0..1.0_f64),
        ) {
            for mut arm in arms() {
                arm.carry(
                    Link { name: "tool".into(), rank: 9, moved_by: arm.shape().flange_motions() },
                    Capsule::new(Vector3::new(0.0, 0.0, 0.1), Vector3::new(0.1, -0.05, 0.25), 0.03),
                );
                let q = arm.shape().between_limits(&|i| part[i]);
                // Lengths of RNT's actuators change by a tenth of what angles do.
                let is_rnt = &*arm.links[0].name == "column" && arm.own() == 7;
                let is_short = |i: usize| is_rnt && (i == 1 || i == 2);
                let distances: Joints = core::array::from_fn(|i| if is_short(i) { 0.1 * distances[i] } else { distances[i] });
                let moved: Joints = core::array::from_fn(|i| q[i] + distances[i] * to[i]);
                if !arm.stand(&moved, None) {
                    continue;
                }
                let after: Vec<Capsule> = arm.placed.iter().map(|placed| placed.capsule).collect();
                if !arm.stand(&q, Some(&distances)) {
                    continue;
                }
                for ((link, placed), after) in arm.links.iter().zip(&arm.placed).zip(&after) {
                    for (end, there) in placed.capsule.ends.iter().zip(&after.ends) {
                        prop_assert!((end - there).norm() <= placed.travel[0] + 1e-9, "{}", link.name);
                    }
                }
                // Pairs that are checked.
                let n = arm.links.len();
                for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
                    let apart = arm.links[a].moved_by ^ arm.links[b].moved_by;
                    if apart == 0 || arm.links[a].rank.abs_diff(arm.links[b].rank) < 2 { continue }
                    let since = apart.trailing_zeros() as usize;
                    let (one, other) = (&arm.placed[a], &arm.placed[b]);
                    let before = one.capsule.gap(&other.capsule).distance;
                    let now = after[a].gap(&after[b]).distance;
                    let bound = one.travel[since] + other.travel[since];
                    prop_assert!(now >= before - bound - 1e-9, "{} {}", arm.links[a].name, arm.links[b].name);
                }
            }
        }
    }

    #[test]
    fn what_is_carried_hangs_on_the_flange() {
        for mut arm in arms() {
            let q = arm.shape().between_limits(&|i| 0.3 + 0.05 * i as f64);
            let end = Vector3::new(0.0, 0.1, 0.2);
            arm.carry(Link::new("tool", 9, 16), Capsule::new(Vector3::zeros(), end, 0.03));
            assert!(arm.stand(&q, None));
            let flange = arm.shape().flange(&q);
            let tool = arm.placed.last().unwrap().capsule;
            assert!((tool.ends[0] - flange.translation.vector).amax() < 1e-14);
            assert!((tool.ends[1] - (flange * Point3::from(end)).coords).amax() < 1e-14);
            assert!(arm.drop_carried("tool"));
            assert!(!arm.drop_carried("tool"));
        }
    }
}
