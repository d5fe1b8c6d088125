//! The postures that the arms visit: clear of each other, and in sight of the theodolites.

use mrroc_robots::Six;

use crate::estimate::{Sight, Sighted, Sights};
use crate::random::Random;
use crate::scene::{ARMS, BALLS, BAR_SIGHTS, Scene, posture};

/// Of the six sights of an arm's balls by both theodolites so many must be free.
const SEEN: usize = 4;

/// Postures of both arms, as programs demand them \[rad\].
#[must_use]
pub fn visits(scene: &Scene, count: usize, seed: u64) -> Vec<[Six; ARMS]> {
    let mut random = Random(seed);
    let mut chosen = Vec::new();
    let mut both: [Six; ARMS] = core::array::from_fn(|arm| posture(arm, &mut random));
    while chosen.len() < count {
        // Whichever arm is not seen enough goes elsewhere.
        match (0..ARMS).find(|arm| seen(scene, *arm, &both).count() < SEEN) {
            Some(hidden) => both[hidden] = posture(hidden, &mut random),
            None => {
                chosen.push(both);
                both = core::array::from_fn(|arm| posture(arm, &mut random));
            }
        }
    }
    chosen
}

/// The sights of an arm's balls that no link blocks: theodolite and ball.
pub fn seen<'s>(
    scene: &'s Scene,
    arm: usize,
    both: &'s [Six; ARMS],
) -> impl Iterator<Item = (usize, usize)> + 's {
    let joints: [Six; ARMS] = core::array::from_fn(|arm| scene.joints(arm, &both[arm]));
    let all = (0..2).flat_map(|theodolite| (0..BALLS.len()).map(move |ball| (theodolite, ball)));
    all.filter(move |(theodolite, ball)| {
        scene.sees(*theodolite, &scene.ball(arm, *ball, &joints[arm]), &joints)
    })
}

/// What the theodolites would read if both arms came to rest exactly where they are told to, without a cell: for statistics over many seeds.
#[must_use]
pub fn without_a_cell(scene: &mut Scene, visits: &[[Six; ARMS]]) -> Sights {
    let mut measured = Sights::default();
    for both in visits {
        for arm in 0..ARMS {
            let joints = scene.come_to_rest(arm, &both[arm]);
            measured.postures[arm].push(both[arm]);
            let free: Vec<(usize, usize)> = seen(scene, arm, both).collect();
            for (theodolite, ball) in free {
                let point = scene.ball(arm, ball, &joints);
                let posture = measured.postures[arm].len() - 1;
                let read = scene.sight(theodolite, &point);
                measured.sights.push(Sight { theodolite, of: Sighted::Ball { arm, ball, posture }, read });
            }
        }
    }
    for end in 0..2 {
        for theodolite in 0..2 {
            let point = scene.ends[end];
            for _ in 0..BAR_SIGHTS {
                let read = scene.sight(theodolite, &point);
                measured.sights.push(Sight { theodolite, of: Sighted::End(end), read });
            }
        }
    }
    measured
}
