//! Arms around a table with boxes, who reach across each other: random problems by their seed.
//!
//! The table is cut into sectors, from the place of one arm to that of the next. At the start the flange of an arm is above the sector to
//! one of its sides, at the goal above that to the other; so the arms want the same places, and two that face each other change sides. Each
//! arm could do so if it were alone: where an arm finds no path among the boxes, another goal is drawn.

use core::f64::consts::TAU;
use core::ops::Range;

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_planning::Planner;
use mrroc_robots::SerialOutline;
use mrroc_robots::clearance::{Clearance, Obstacle, Outline};
use nalgebra::{SVector, Vector3};

use super::models::{seven_quick_axes, six_axes, stopping};

/// From the middle of the table to the base of an arm \[m\].
const BASE: f64 = 0.65;
/// The nearest and the farthest from the middle that flanges begin and end \[m\].
const FLANGE: [f64; 2] = [0.1, 0.45];
/// The lowest and the highest that they do \[m\].
const HEIGHT: [f64; 2] = [0.1, 0.5];
/// How many boxes stand on the table.
const BOXES: usize = 6;
/// What the arms keep apart \[m\].
pub(crate) const MARGIN: f64 = 0.02;
/// What they have more at the start and at the goal, for stops that begin there \[m\].
const MORE: f64 = 0.005;
/// The effort by which each arm alone must find a path.
const ALONE: u64 = 50_000;
/// The farthest from 0 that joints begin and end [rad].
const TURN: f64 = 0.5 * TAU;

/// The arms of tests that stand around the table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// Six axes each.
    Six,
    /// Seven axes each.
    Seven,
}

impl Kind {
    /// A table with so many of them, at most four.
    pub(crate) fn table(self, arms: usize) -> Table {
        match self {
            Kind::Six => Table::new(&six_axes(Pose::identity()), arms),
            Kind::Seven => Table::new(&seven_quick_axes(Pose::identity()), arms),
        }
    }
}

/// Draws a random position, and tells where the flange is then, seen from the base.
type Draw = Box<dyn Fn(&mut Random) -> (Vec<f64>, Pose)>;

/// Arms of one kind around a table.
pub(crate) struct Table {
    arms: usize,
    drawn: Draw,
    /// The first arm, the first two, and so on; each arm alone; all of them. Their boxes are not where a problem has them.
    first: Vec<Clearance>,
    alone: Vec<Clearance>,
    all: Clearance,
}

/// Arms, and where they move.
pub(crate) struct Problem {
    pub(crate) clearance: Clearance,
    pub(crate) start: Vec<f64>,
    pub(crate) goal: Vec<f64>,
}

impl Table {
    /// So many arms, at most four, of a shape whose base is at the origin and whose first link stands on the table.
    pub(crate) fn new<const N: usize>(outline: &SerialOutline<N>, arms: usize) -> Self {
        let world = |of: Range<usize>, margin: f64| {
            let mut builder =
                Clearance::with_margin(margin).obstacle("table", Obstacle::table(-0.02)).expect("a table");
            for name in names() {
                let elsewhere = Pose::translation(0.0, 0.0, 100.0);
                let body = Obstacle::Box { X_WO: elsewhere, half: Vector3::repeat(0.1) };
                builder = builder.obstacle(&name, body).expect("a box");
            }
            for arm in of {
                let (name, foot) = (format!("arm{arm}"), outline.links()[0].name.clone());
                builder = builder.robot(&name, outline.clone().with_base(base(arm, arms))).expect("an arm");
                builder = builder.ignore((&name, &foot), ("table", "table"));
            }
            builder.build(stopping()).expect("a clearance")
        };
        let robot = outline.robot().clone();
        let drawn = move |random: &mut Random| {
            let limits = robot.limits();
            let q = SVector::<f64, N>::from_fn(|j, _| {
                random.between(limits.lower[j].max(-TURN), limits.upper[j].min(TURN))
            });
            (q.as_slice().to_vec(), robot.forward(&q))
        };
        Table {
            arms,
            drawn: Box::new(drawn),
            first: (0..arms).map(|arm| world(0..arm + 1, MARGIN + MORE)).collect(),
            alone: (0..arms).map(|arm| world(arm..arm + 1, MARGIN + MORE)).collect(),
            all: world(0..arms, MARGIN),
        }
    }

    /// The problem of a seed.
    pub(crate) fn problem(&self, seed: u64) -> Problem {
        let arms = self.arms;
        let mut random = Random::seeded(seed);
        let boxes = boxes(arms, &mut random);
        let among = |world: &Clearance| {
            let mut world = world.clone();
            for (name, body) in names().zip(&boxes) {
                world.replace_obstacle(&name, body.clone()).expect("a box");
            }
            world
        };
        let planner = |world: &Clearance| Planner::new(among(world)).expect("a planner");
        // Postures are drawn arm by arm.
        let mut worlds: Vec<Planner> = self.first.iter().map(planner).collect();
        let mut alone: Vec<Planner> =
            self.alone.iter().map(|world| planner(world).with_effort(ALONE)).collect();
        let turns: Vec<f64> = (0..arms).map(|_| if random.unit() < 0.5 { -1.0 } else { 1.0 }).collect();
        let others: Vec<f64> = turns.iter().map(|turn| -turn).collect();
        let start = self.posture(&mut worlds, &turns, &mut random, |_, _| true);
        let goal = self.posture(&mut worlds, &others, &mut random, |arm, q| {
            alone[arm].find_first(&start[arm], &[q.to_vec()]).is_ok()
        });
        Problem { clearance: among(&self.all), start: start.concat(), goal: goal.concat() }
    }

    /// Clear positions of all arms, each above the sector to the side of it that is told: 1.0 is that to the next arm.
    #[allow(non_snake_case)]
    fn posture(
        &self,
        worlds: &mut [Planner],
        sides: &[f64],
        random: &mut Random,
        mut is_wanted: impl FnMut(usize, &[f64]) -> bool,
    ) -> Vec<Vec<f64>> {
        let arms = self.arms;
        loop {
            let mut all: Vec<Vec<f64>> = Vec::new();
            for (arm, side) in sides.iter().enumerate() {
                let found = (0..20_000).find_map(|_| {
                    let (q, X_BF) = (self.drawn)(random);
                    let flange = (base(arm, arms) * X_BF).translation.vector;
                    all.push(q);
                    let q = all.concat();
                    let is_clear = is_above(&flange, angle(arm, arms), *side, TAU / arms as f64)
                        && worlds[arm].find_first(&q, std::slice::from_ref(&q)).is_ok();
                    let q = all.pop().expect("just pushed");
                    (is_clear && is_wanted(arm, &q)).then_some(q)
                });
                match found {
                    Some(q) => all.push(q),
                    None => break,
                }
            }
            // Where the others leave an arm no room, all are drawn again.
            if all.len() == arms {
                return all;
            }
        }
    }
}

fn names() -> impl Iterator<Item = String> {
    (0..BOXES).map(|i| format!("box {i}"))
}

/// Where an arm stands: at the edge of the table, its x axis to the middle.
fn base(arm: usize, arms: usize) -> Pose {
    let angle = angle(arm, arms);
    Pose::new(Vector3::new(angle.cos(), angle.sin(), 0.0) * BASE, Vector3::z() * (angle + 0.5 * TAU))
}

fn angle(arm: usize, arms: usize) -> f64 {
    TAU * arm as f64 / arms as f64
}

fn boxes(arms: usize, random: &mut Random) -> Vec<Obstacle> {
    let mut boxes = Vec::new();
    while boxes.len() < BOXES {
        let at = Vector3::new(random.within(0.6), random.within(0.6), 0.0);
        let half =
            Vector3::new(random.between(0.03, 0.08), random.between(0.03, 0.08), random.between(0.05, 0.18));
        let turned = Pose::new(at + Vector3::z() * half.z, Vector3::z() * random.within(0.25 * TAU));
        if (0..arms).all(|arm| (base(arm, arms).translation.vector - at).norm() > 0.3) {
            boxes.push(Obstacle::Box { X_WO: turned, half });
        }
    }
    boxes
}

/// Whether a flange is above the sector to one side of the place of an arm.
fn is_above(flange: &Vector3<f64>, angle: f64, side: f64, sector: f64) -> bool {
    let (distance, off) = (flange.xy().norm(), flange.y.atan2(flange.x) - angle);
    let turned = (side * off).rem_euclid(TAU);
    (FLANGE[0]..FLANGE[1]).contains(&distance)
        && (HEIGHT[0]..HEIGHT[1]).contains(&flange.z)
        && (0.0..sector).contains(&turned)
}
