//! The behaviours of the book's page about reactive programs. Shown there word for word.

use mrroc::sensor::SensorImage;
use mrroc_generators::rehearsal::rehearse_with;
// ANCHOR: behaviours
use mrroc::generator::{Generator, Motion};
use mrroc::prelude::*;
use mrroc_generators::combinators::{Arbitrate, Blind, Sequence};
use mrroc_generators::generators::{Sleep, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::Irp6;

/// A laser scanner beside the arm.
struct Scanner;

impl Sensor for Scanner {
    const KIND: &'static str = "scanner";
    type Reading = Person;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Person {
    distance: f64, // [m]
}

// When a behaviour begins, and when it ends: not at the same distance, so that noise does not hand the arm to and fro.
fn near(v: &Reading<(Scanner,)>) -> bool {
    v.0.reading().is_some_and(|person| person.distance < 1.0)
}

fn far(v: &Reading<(Scanner,)>) -> bool {
    v.0.reading().is_some_and(|person| person.distance > 1.2)
}

fn very_near(v: &Reading<(Scanner,)>) -> bool {
    v.0.reading().is_some_and(|person| person.distance < 0.5)
}

fn not_so_near(v: &Reading<(Scanner,)>) -> bool {
    v.0.reading().is_some_and(|person| person.distance > 0.7)
}

/// By priority: home if somebody is very near, else stand if somebody is near, else on to the goal.
fn behaviours(
    home: Pose,
    goal: Pose,
) -> impl Generator<Robots = Irp6, Language = Motion, Sensors = (Scanner,), Order = ()> {
    let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    // One that is to give the arm back goes on until then.
    let forever = || Sleep::lasting(f64::INFINITY);
    let retreat = move || Blind::new(Sequence::of(StraightLine::to(home, limits), forever()));
    let stand = move || Blind::new(forever());
    let go = move || Blind::new(StraightLine::to(goal, limits));
    // What runs is braked on its path within 0.1 s before another one takes over.
    let usual = move || Arbitrate::of(stand, near, far, 0.1, go);
    Arbitrate::of(retreat, very_near, not_so_near, 0.1, usual)
}
// ANCHOR_END: behaviours

#[test]
fn each_behaviour_runs_while_its_condition_lets_it() {
    let (irp6, start, dt) = (Irp6::nominal(), Irp6::READY, 0.002);
    let home = irp6.forward(&start);
    let goal = home * Pose::translation(0.0, 0.0, -0.1);
    let mut step = 0;
    // Nobody for 0.6 s; near until 1.2 s; very near until 3 s; nobody again.
    let demands = rehearse_with(behaviours(home, goal), &irp6, start, dt, |_| {
        step += 1;
        let distance = match step {
            0..300 => 2.0,
            300..600 => 0.9,
            600..1500 => 0.3,
            _ => 2.0,
        };
        (Order::new(()), Reading::new((SensorImage::new(Person { distance }, 0),)))
    })
    .expect("a motion");
    let off = |demand: &Demand<Irp6>, from: &Pose| {
        demand.as_pose().map(|pose| from.inv_mul(&pose).translation.vector.norm())
    };
    // At 0.1 m/s after an acceleration of 0.2 s: 0.05 m in 0.6 s, and less than another 0.01 m while it brakes.
    let gone = demands[..400].iter().filter_map(|demand| off(demand, &home)).fold(0.0, f64::max);
    assert!(gone > 0.049 && gone < 0.06, "{gone}");
    assert!(demands[400..590].iter().all(|demand| *demand == Demand::hold()), "it stands");
    // Back home within 0.06 / 0.1 + 0.2 s, and there until nobody is near.
    assert!(demands[1100..1490].iter().all(|demand| *demand == Demand::hold()), "it is home");
    let last = demands[600..1100].iter().filter_map(|demand| off(demand, &home)).next_back();
    assert!(last.is_some_and(|off| off < 1e-12), "{last:?}");
    assert_eq!(demands.last().and_then(Demand::as_pose), Some(goal));
}
