//! The postures that the arms visit: clear of each other, in sight of the theodolites, and those that tell most.

use mrroc::random::Random;
use mrroc_calibration::{Aim, Noise, Problem, choose, evaluate};
use mrroc_robots::Six;

use crate::estimate::{Sight, Sighted, Sights, Stated};
use crate::scene::{ARMS, BALLS, BAR_SIGHTS, BARS, MUTUAL_SIGHTS, PAYLOAD, Scene, posture, wide_posture};

/// Of the six sights of an arm's balls by both theodolites so many must be free.
const SEEN: usize = 4;

/// So many places of each arm are aimed at when postures are chosen.
const AIMS: usize = 40;

/// What is visited: postures of both arms, as programs demand them \[rad\], and what hangs on both then \[kg\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The postures.
    pub both: [Six; ARMS],
    /// The mass.
    pub payload: f64,
}

/// Visits to postures as they come: as far as is known with arms clear of each other and in sight; every second one with a payload.
#[must_use]
pub fn drawn(count: usize, seed: u64) -> Vec<Visit> {
    visible(count, seed, posture)
}

/// The same to postures that tell much, to choose from.
#[must_use]
pub fn candidates(count: usize, seed: u64) -> Vec<Visit> {
    visible(count, seed, wide_posture)
}

fn visible(count: usize, seed: u64, draw: impl Fn(usize, &mut Random) -> Six) -> Vec<Visit> {
    let scene = Scene::believed();
    let mut random = Random::seeded(seed);
    let mut found = Vec::new();
    let mut both: [Six; ARMS] = core::array::from_fn(|arm| draw(arm, &mut random));
    while found.len() < count {
        // Whichever arm is not seen enough goes elsewhere.
        match (0..ARMS).find(|arm| seen(&scene, *arm, &both).count() < SEEN) {
            Some(hidden) => both[hidden] = draw(hidden, &mut random),
            None => {
                let payload = if found.len() % 2 == 0 { 0.0 } else { PAYLOAD };
                found.push(Visit { both, payload });
                both = core::array::from_fn(|arm| draw(arm, &mut random));
            }
        }
    }
    found
}

/// Of so many candidates `of` the `count` after which the least is unsure of the bases, and of where the balls are anywhere; those with a payload
/// come last.
#[must_use]
pub fn chosen(count: usize, of: usize, seed: u64) -> Vec<Visit> {
    let all = candidates(of, seed);
    let Planned { problem, candidates, aims } = Planned::new(&all, seed);
    let chosen = choose(&problem, &candidates, &aims, count).candidates;
    let mut chosen: Vec<Visit> = chosen.into_iter().map(|i| all[i]).collect();
    chosen.sort_by(|a, b| a.payload.total_cmp(&b.payload));
    chosen
}

/// How sure bases and balls would be after visits: the root mean square of their standard deviations \[m\].
#[must_use]
pub fn foreseen(visits: &[Visit], seed: u64) -> f64 {
    let Planned { problem, candidates, aims } = Planned::new(visits, seed);
    let all: Vec<usize> = (0..candidates.len()).collect();
    evaluate(&problem, &candidates, &aims, &all).left.last().copied().unwrap_or(f64::INFINITY)
}

/// What would be measured.
struct Planned {
    problem: Problem,
    candidates: Vec<Vec<usize>>,
    aims: Vec<Aim>,
}

impl Planned {
    fn new(visits: &[Visit], seed: u64) -> Self {
        let mut scene = Scene::believed();
        let planned = without_a_cell(&mut scene, visits);
        // The mean of two sets in both faces, and what centring adds at 3 m.
        let mut stated = Stated::new(Noise::Known(vec![7e-6; 2]));
        stated.measured(&planned);
        let mut candidates = vec![Vec::new(); visits.len()];
        for (i, sight) in planned.sights.iter().enumerate() {
            if let Sighted::Ball { posture, .. } = sight.of {
                candidates[posture].push(i);
            }
        }
        let mut random = Random::seeded(seed ^ 0xa1a5);
        let [left, right] = stated.arms.map(|arm| stated.problem.base_of(arm));
        let mut aims = Vec::new();
        for _ in 0..AIMS {
            aims.push(Aim::Between(left, right));
            for (arm, id) in stated.arms.into_iter().enumerate() {
                let q = posture(arm, &mut random).as_slice().to_vec();
                aims.push(Aim::Place(id, q, stated.balls[arm][0]));
            }
        }
        Self { problem: stated.problem, candidates, aims }
    }
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
pub fn without_a_cell(scene: &mut Scene, visits: &[Visit]) -> Sights {
    let mut measured = Sights::default();
    for Visit { both, payload } in visits {
        scene.payload = [*payload; ARMS];
        for arm in 0..ARMS {
            let joints = scene.come_to_rest(arm, &both[arm]);
            measured.postures[arm].push(both[arm]);
            measured.payloads[arm].push(scene.payload[arm]);
            let free: Vec<(usize, usize)> = seen(scene, arm, both).collect();
            for (theodolite, ball) in free {
                let point = scene.ball(arm, ball, &joints);
                let posture = measured.postures[arm].len() - 1;
                let read = scene.sight(theodolite, &point);
                measured.sights.push(Sight { theodolite, of: Sighted::Ball { arm, ball, posture }, read });
            }
        }
    }
    for theodolite in 0..2 {
        for bar in 0..BARS {
            for end in 0..2 {
                let point = scene.ends[bar][end];
                for _ in 0..BAR_SIGHTS {
                    let read = scene.sight(theodolite, &point);
                    measured.sights.push(Sight { theodolite, of: Sighted::End { bar, end }, read });
                }
            }
        }
        let other = scene.theodolites[1 - theodolite].place.translation.vector;
        for _ in 0..MUTUAL_SIGHTS {
            let read = scene.sight(theodolite, &other);
            measured.sights.push(Sight { theodolite, of: Sighted::Other, read });
        }
    }
    scene.payload = [0.0; ARMS];
    measured
}
