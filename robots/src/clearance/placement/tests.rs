//! What a robot is where it stands, and what moves it at most.

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
        read::<4>(include_str!("../../../tests/reference/urdf/gantry.urdf"), ["bed", "tool"], base),
        read::<4>(include_str!("../../../tests/reference/urdf/palletiser.urdf"), ["base", "tool"], base),
    ];
    shapes.map(|shape| Placement::new(Name::new("arm").unwrap(), shape)).into_iter().collect()
}

/// The capsules of all links where an arm stands.
fn placed(arm: &mut Placement) -> Vec<Placed> {
    (0..arm.links.len()).map(|link| *arm.place(arm.part_of(link), arm.leaf(link))).collect()
}

/// Takes the robots' joints, at parts of their ranges, by `to` of `distances` elsewhere.
fn check_travels(part: [f64; 8], distances: [f64; 8], to: [f64; 8]) {
    for mut arm in arms() {
        let tool = Link { name: "tool".into(), rank: 9, moved_by: arm.shape().flange_motions() };
        let rod = Capsule::new(Vector3::new(0.0, 0.0, 0.1), Vector3::new(0.1, -0.05, 0.25), 0.03);
        arm.carry(&tool, &[rod]);
        let q = arm.shape().between_limits(&|i| part[i]);
        // Lengths of RNT's actuators change by a tenth of what angles do.
        let is_rnt = &*arm.links[0].name == "column" && arm.own() == 7;
        let is_short = |i: usize| is_rnt && (i == 1 || i == 2);
        let distances: Joints =
            core::array::from_fn(|i| if is_short(i) { 0.1 * distances[i] } else { distances[i] });
        let moved: Joints = core::array::from_fn(|i| q[i] + distances[i] * to[i]);
        if !arm.stand(&moved, None) {
            continue;
        }
        let after: Vec<Capsule> = placed(&mut arm).iter().map(|placed| placed.capsule).collect();
        if !arm.stand(&q, Some(&distances)) {
            continue;
        }
        let now = placed(&mut arm);
        for ((link, placed), after) in arm.links.iter().zip(&now).zip(&after) {
            for (end, there) in placed.capsule.ends.iter().zip(&after.ends) {
                assert!((end - there).norm() <= placed.travel[0] + 1e-9, "{}", link.name);
            }
        }
        // Pairs that are checked.
        let n = arm.links.len();
        for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
            let apart = arm.links[a].moved_by ^ arm.links[b].moved_by;
            if apart == 0 || arm.links[a].rank.abs_diff(arm.links[b].rank) < 2 {
                continue;
            }
            let since = apart.trailing_zeros() as usize;
            let (one, other) = (&now[a], &now[b]);
            let before = one.capsule.gap(&other.capsule).distance;
            let moved = after[a].gap(&after[b]).distance;
            let bound = one.travel[since] + other.travel[since];
            assert!(moved >= before - bound - 1e-9, "{} {}", arm.links[a].name, arm.links[b].name);
        }
    }
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
        check_travels(part, distances, to);
    }
}

/// The first slide of the gantry makes link 0 shorter and moves link 2, whose length another slide changes.
#[test]
fn bars_between_slides_get_no_nearer_than_by_their_travels() {
    let part = [0.05, 0.36, 0.59, 0.05, 0.05, 0.05, 0.05, 0.05];
    check_travels(part, [0.47, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [-1.0; 8]);
}

#[test]
fn what_is_carried_hangs_on_the_flange() {
    for mut arm in arms() {
        let q = arm.shape().between_limits(&|i| 0.3 + 0.05 * i as f64);
        let end = Vector3::new(0.0, 0.1, 0.2);
        arm.carry(&Link::new("tool", 9, 16), &[Capsule::new(Vector3::zeros(), end, 0.03)]);
        assert!(arm.stand(&q, None));
        let flange = arm.shape().flange(&q);
        let tool = arm.capsule(arm.links.len() - 1).unwrap();
        assert!((tool.ends[0] - flange.translation.vector).amax() < 1e-14);
        assert!((tool.ends[1] - (flange * Point3::from(end)).coords).amax() < 1e-14);
        assert!(arm.drop_carried("tool"));
        assert!(!arm.drop_carried("tool"));
    }
}
