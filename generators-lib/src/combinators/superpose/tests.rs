//! What two behaviours at once come to, against each of them alone.

use super::super::Blind;
use super::*;
use crate::generators::ToolOffset;
use crate::profile::ProfileLimits;
use mrroc::robot::{Channel, Output, RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_robots::{Irp6, Six};

const DT: f64 = 2e-3;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Weights {
    both: [f64; 2],
}

struct Knob;

impl Sensor for Knob {
    const KIND: &'static str = "knob";
    type Reading = Weights;
    type Configuration = ();
}

fn limits(velocity: f64, acceleration: f64) -> ToolLimits {
    let limits = ProfileLimits { velocity, acceleration };
    ToolLimits { translation: limits, rotation: limits }
}

fn by(x: f64, y: f64) -> Blind<ToolOffset<Irp6>, (Knob,)> {
    let turned = Pose::rotation(Vector3::new(y, x, 0.3 * x));
    Blind::new(ToolOffset::by(Pose::translation(x, y, 0.1 * y) * turned, limits(0.1, 0.5)))
}

/// Told weights, behaviours, and the demands of these, until they are done.
fn run<G>(mut generator: G, weights: impl Fn(u64) -> [f64; 2]) -> Vec<Demand<Irp6>>
where
    G: Generator<Robots = Irp6, Language = Motion, Sensors = (Knob,), Order = ()>,
{
    let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
    let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
    let mut demands = Vec::new();
    for step in 0..100_000 {
        let v = Reading::new((SensorImage::new(Weights { both: weights(step) }, 0),));
        let t = Tick { step, dt: DT, duration: DT };
        let stepped = if step == 0 {
            generator.first_step(&c0, &e, &v, t)
        } else {
            generator.next_step(&c0, &e, &v, t)
        };
        let Step::Next(demand) = stepped.expect("in range") else { return demands };
        demands.push(demand);
    }
    panic!("it is never done")
}

fn told(v: &Reading<(Knob,)>) -> [f64; 2] {
    v.0.reading().map_or([0.0; 2], |knob| knob.both)
}

/// Velocities of a list of displacements, from rest on: translation and rotation.
fn velocities(demands: &[Demand<Irp6>]) -> Vec<[Vector3<f64>; 2]> {
    let places = demands.iter().map(|demand| demand.as_displacement().expect("a displacement"));
    let all: Vec<_> = core::iter::once(Pose::identity()).chain(places).collect();
    all.windows(2).map(|pair| displacement(&pair[0], &pair[1]).map(|by| by / DT)).collect()
}

/// Pseudo-random numbers in 0..1 (Numerical Recipes' linear congruence).
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn the_velocity_is_the_weighted_sum_where_no_limit_acts() {
    for seed in 0..20 {
        let mut random = numbers(seed);
        let ([x, y], [p, q]) = ([0.3 * random(), -0.2 * random()], [0.1 * random(), 0.2 * random()]);
        let both = [2.0 * random() - 0.5, 2.0 * random() - 0.5];
        let sum = velocities(&run(Superpose::of(by(x, y), by(p, q), told, limits(9.0, 90.0)), |_| both));
        let [first, second] = [by(x, y), by(p, q)].map(|alone| velocities(&run(alone, |_| both)));
        assert!(sum.len() >= first.len().max(second.len()), "seed {seed}");
        for (step, sum) in sum.iter().enumerate() {
            let at = |all: &[[Vector3<f64>; 2]]| all.get(step).copied().unwrap_or_default();
            for (axis, moved) in sum.iter().enumerate() {
                let wanted = at(&first)[axis] * both[0] + at(&second)[axis] * both[1];
                // Per step the demands agree to 1e-12 m and rad.
                let off = (moved - wanted).norm() * DT;
                assert!(off < 1e-12, "seed {seed}, step {step}: {off}");
            }
        }
    }
}

#[test]
fn the_limits_of_the_sum_are_kept_whatever_the_weights_do() {
    for seed in 0..20 {
        let mut random = numbers(100 + seed);
        let most = limits(0.05 + 0.1 * random(), 0.2 + random());
        let period = 1 + (100.0 * random()) as u64;
        let (one, other) = ([3.0 * random(), 3.0 * random()], [3.0 * random() - 3.0, 0.0]);
        let weights = |step: u64| if (step / period).is_multiple_of(2) { one } else { other };
        let moved = velocities(&run(Superpose::of(by(0.3, 0.1), by(0.1, -0.2), told, most), weights));
        let mut last = [Vector3::zeros(); 2];
        for (step, velocity) in moved.iter().enumerate() {
            for (axis, limit) in [most.translation, most.rotation].into_iter().enumerate() {
                let (speed, change) = (velocity[axis].norm(), (velocity[axis] - last[axis]).norm());
                assert!(speed <= limit.velocity * (1.0 + 1e-9), "seed {seed}, step {step}: {speed}");
                // Two differences of places that are known to 1e-16 m.
                let bound = limit.acceleration * DT * (1.0 + 1e-6) + 4e-12;
                assert!(change <= bound, "seed {seed}, step {step}: {change} of {bound}");
            }
            last = *velocity;
        }
        for (axis, limit) in [most.translation, most.rotation].into_iter().enumerate() {
            assert!(last[axis].norm() <= limit.acceleration * DT * (1.0 + 1e-6), "it ends at rest");
        }
    }
}

#[test]
fn a_weight_of_one_beside_zero_gives_the_one_behaviour_to_the_bit() {
    let alone = run(by(0.3, -0.1), |_| [1.0, 0.0]);
    for zero in [0.0, -0.0] {
        let first = Superpose::of(by(0.3, -0.1), by(0.1, 0.2), told, limits(9.0, 90.0));
        assert!(run(first, |_| [1.0, zero])[..alone.len()] == alone, "the first");
        let second = Superpose::of(by(0.01, 0.02), by(0.3, -0.1), told, limits(9.0, 90.0));
        assert!(run(second, |_| [zero, 1.0])[..alone.len()] == alone, "the second");
    }
}

#[test]
fn a_weight_that_goes_to_zero_hands_over_without_a_step_of_velocity() {
    // Along x and along y, until from step 500 on y alone has weight.
    let most = limits(0.5, 0.8);
    let weights = |step| if step < 500 { [1.0, 0.2] } else { [0.0, 1.0] };
    let moved = velocities(&run(Superpose::of(by(0.5, 0.0), by(0.0, 0.4), told, most), weights));
    let changes = moved.windows(2).map(|pair| (pair[1][0] - pair[0][0]).norm());
    assert!(changes.fold(0.0, f64::max) <= 0.8 * DT * (1.0 + 1e-6) + 4e-12);
    // Its velocity was along x, and is along y within the time that the limit needs for both.
    assert!(moved[499][0].x > 0.08 && moved[750][0].x.abs() < 1e-9 && moved[750][0].y > 0.05);
}

/// Holds for ever.
struct Stay;

#[generator(ecp)]
fn stay(c: &mut Stay) -> Always<Irp6> {
    let Stay = c;
    Always(Demand::hold())
}

#[test]
fn it_is_done_when_all_are_that_can_be() {
    let alone = run(by(0.1, 0.0), |_| [1.0, 1.0]).len();
    let beside = Superpose::of(by(0.1, 0.0), Blind::<_, (Knob,)>::new(Stay), told, limits(9.0, 90.0));
    assert_eq!(run(beside, |_| [1.0, 1.0]).len(), alone);
}

/// Along x for ever, a millimetre each step.
struct On;

#[generator(ecp)]
fn on(_c: &mut On, t: Tick) -> Always<Irp6> {
    Always(Demand::displacement(Pose::translation(1e-3 * (t.step + 1) as f64, 0.0, 0.0)))
}

#[test]
fn two_that_never_end_go_on_for_ever() {
    let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
    let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
    let v = Reading::new((SensorImage::new(Weights { both: [1.0, 1.0] }, 0),));
    let [one, other] = [On, On].map(Blind::<_, (Knob,)>::new);
    let mut both = Superpose::of(one, other, told, limits(9.0, 1e6));
    let mut last = both.first_step(&c0, &e, &v, Tick { step: 0, dt: DT, duration: DT }).expect("begins");
    for step in 1..1000 {
        last = both.next_step(&c0, &e, &v, Tick { step, dt: DT, duration: DT }).expect("goes on");
    }
    let Step::Next(demand) = last else { panic!("it is done") };
    assert!((demand.as_displacement().expect("of the tool").translation.x - 2.0).abs() < 1e-9);
}

/// Holds, and switches an output.
struct Switch;

#[generator(ecp)]
fn switch(c: &mut Switch) -> Always<Irp6> {
    let Switch = c;
    Always(Demand::hold().with_output(Output::of(Channel::Digital(2)).expect("digital"), true))
}

#[test]
fn what_a_behaviour_that_holds_switches_is_switched_while_the_other_one_moves() {
    let beside = Superpose::of(Blind::<_, (Knob,)>::new(Switch), by(0.1, 0.0), told, limits(9.0, 90.0));
    let demands = run(beside, |_| [1.0, 1.0]);
    let switched =
        Demand::<Irp6>::hold().with_output(Output::of(Channel::Digital(2)).expect("digital"), true);
    let moved = demands[100];
    assert!(moved.as_displacement().is_some_and(|at| at.translation.x > 1e-3));
    assert_eq!(moved, switched.led_to(&moved));
}

#[test]
fn what_cannot_be_superposed_is_refused() {
    let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
    let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
    let t = Tick { step: 0, dt: DT, duration: DT };
    let refused = |weight: f64, limits: ToolLimits| {
        let v = Reading::new((SensorImage::new(Weights { both: [1.0, weight] }, 0),));
        Superpose::of(by(0.1, 0.0), by(0.0, 0.1), told, limits).first_step(&c0, &e, &v, t).is_err()
    };
    assert!(!refused(1.0, limits(1.0, 1.0)));
    for odd in [f64::NAN, f64::INFINITY] {
        assert!(refused(odd, limits(1.0, 1.0)) && refused(1.0, limits(odd, 1.0)));
    }
    assert!(refused(1.0, limits(0.0, 1.0)) && refused(1.0, limits(1.0, -1.0)));
}
