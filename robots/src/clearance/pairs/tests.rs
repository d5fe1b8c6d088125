use std::sync::Arc;

use mrroc::fault::Name;
use mrroc::random::Random;
use nalgebra::Vector3;

use super::*;
use crate::Irp6;
use crate::models::Capsule;

#[test]
fn trees_leave_out_the_pairs_that_each_pair_alone_leaves_out_in_all_postures() {
    let mut arm = Placement::new(Name::new("arm").expect("a name"), Arc::new(Irp6::nominal()));
    let rank = arm.links.iter().map(|link| link.rank).max().expect("links") + 1;
    let mut random = Random::seeded(3);
    let tool = (0..100).map(|_| {
        let mut point = |size: f64| Vector3::from_fn(|_, _| random.within(size));
        let end = point(0.4);
        Capsule::new(end, end + point(0.05), 0.03)
    });
    let tool: Vec<Capsule> = tool.collect();
    arm.carry(&Link { name: "tool".into(), rank, moved_by: arm.shape().flange_motions() }, &tool);
    let mut robots = [arm];
    let mut groups = possible(&robots, 0);
    let pairs: Vec<Pair> =
        groups.iter().flat_map(|group| group.pairs(&robots)).map(|(pair, _)| pair).collect();
    assert!(pairs.len() > 200);
    // Whether each overlapped, was apart, and came near, in one posture.
    let mut seen = vec![[false; 3]; pairs.len()];
    let mut stood = 0;
    for sample in 1.. {
        let q = spread(&robots[0], sample);
        if !robots[0].shape().is_possible(&q) || !robots[0].stand(&q, None) {
            continue;
        }
        for (pair, seen) in pairs.iter().zip(&mut seen) {
            let Other::Limb(other) = pair.other else { panic!("no obstacles here") };
            let [one, other] =
                [pair.limb.link, other.link].map(|link| robots[0].capsule(link).expect("it stands"));
            let distance = one.gap(&other).distance;
            let now = [distance < 0.0, distance >= 0.0, distance <= NEVER_NEARER];
            seen.iter_mut().zip(now).for_each(|(seen, now)| *seen |= now);
        }
        stood += 1;
        if stood == POSTURES {
            break;
        }
    }
    leave_out_meaningless(&mut groups, &mut robots, &[]);
    let mut unchecked: Vec<(Pair, Unchecked)> =
        groups.iter().flat_map(|group| group.unchecked(&robots)).collect();
    unchecked.sort_by_key(|(pair, _)| *pair);
    let mut expected: Vec<(Pair, Unchecked)> = pairs
        .iter()
        .zip(&seen)
        .filter_map(|(pair, seen)| match seen {
            [true, false, _] => Some((*pair, Unchecked::AlwaysOverlap)),
            [_, true, false] => Some((*pair, Unchecked::NeverMeet)),
            _ => None,
        })
        .collect();
    expected.sort_by_key(|(pair, _)| *pair);
    assert_eq!(unchecked, expected);
    assert!(
        expected.len() > 20 && expected.len() + 20 < pairs.len(),
        "{} of {}",
        expected.len(),
        pairs.len()
    );
}
