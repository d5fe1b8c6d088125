//! Bodies on a belt: slip and stick, ends, rest, and what the belt bears; against Coulomb's law and Newton's.

use core::time::Duration;

use mrroc::pose::Pose;
use mrroc::robot::Driver;
use nalgebra::Vector3;

use super::bench::at;
use crate::models::{Conveyor, GRAVITY, One};
use crate::simulation::grasp::{Belt, Body, Sink, Whereabouts, World};
use crate::simulation::simulated::Simulated;

const MASS: f64 = 0.3;
const EDGES: [f64; 3] = [0.08, 0.06, 0.04];
const FRICTION: f64 = 0.5;
const PERIOD: f64 = 2e-3;
/// How deep four corners sink into the belt at rest \[m\].
const DEPTH: f64 = MASS * GRAVITY / (4.0 * 4e3);

/// A world with a belt along x that is led from outside.
struct Led {
    world: World,
    belt: usize,
    ticks: u32,
    force: f64,
}

impl Led {
    fn new(world: World, belt: Belt) -> Self {
        let period = Duration::from_secs_f64(PERIOD);
        let belt = world.add_belt(belt, period, Pose::identity(), Pose::identity()).expect("a belt");
        Self { world, belt, ticks: 0, force: 0.0 }
    }

    /// Moves the belt for a while, to `x(t)`.
    fn run(&mut self, until: f64, x: impl Fn(f64) -> f64) {
        while f64::from(self.ticks) * PERIOD < until - 1e-9 {
            self.ticks += 1;
            self.force = self.world.begin_belt(self.belt);
            self.world.end_belt(self.belt, at(x(f64::from(self.ticks) * PERIOD), 0.0, 0.0));
        }
    }
}

/// The block on the belt, at rest.
fn block(x: f64) -> Body {
    Body::block(MASS, EDGES).at(at(x, 0.0, 0.5 * EDGES[2] - DEPTH))
}

fn on_belt(world: World, friction: f64) -> Led {
    world.put(&block(0.0)).expect("a block");
    Led::new(world, Belt::new(-1.0, 3.0, 0.4).with_friction(friction))
}

#[test]
fn a_body_that_comes_at_rest_slips_as_friction_says_and_goes_on_with_the_belt() {
    let speed = 0.5;
    let mut led = on_belt(World::empty(), FRICTION);
    let began = led.world.body().pose.translation.x;
    // Half of the time for which it slips, v / (mu g).
    let slipping = speed / (FRICTION * GRAVITY);
    led.run(0.5 * slipping, |t| speed * t);
    let half = led.world.body().velocity.x / (FRICTION * GRAVITY * led.world.time());
    assert!((half - 1.0).abs() < 0.02, "{half} of the speed that friction gives");
    led.run(1.0, |t| speed * t);
    let body = led.world.body();
    let lag = speed * led.world.time() - (body.pose.translation.x - began);
    let expected = speed * speed / (2.0 * FRICTION * GRAVITY);
    // The contacts stretch by mu n / k before they slip, 0.1 mm.
    assert!((lag - expected).abs() < 2e-4, "{lag} m behind, {expected} m by Coulomb");
    assert!((body.velocity - Vector3::x() * speed).norm() < 1e-4, "{}", body.velocity);
}

#[test]
fn a_belt_that_accelerates_beyond_friction_leaves_the_body_behind() {
    let pull = 2.0 * FRICTION * GRAVITY;
    let mut led = on_belt(World::empty().with_rest(), FRICTION);
    led.run(0.2, |_| 0.0);
    let (from, before) = (led.world.time(), led.world.body().velocity.x);
    led.run(0.5, |t| 0.5 * pull * (t - 0.2) * (t - 0.2));
    let acceleration = (led.world.body().velocity.x - before) / (led.world.time() - from);
    assert!((acceleration / (FRICTION * GRAVITY) - 1.0).abs() < 0.02, "{acceleration}");
}

#[test]
fn bodies_that_rest_on_a_belt_are_where_integrated_ones_are() {
    // Speeds up, keeps its speed, wavers, slows down.
    let x = |t: f64| {
        let run = 0.05 * t.min(2.0).powi(2) / 2.0 + 0.1 * (t - 2.0).max(0.0);
        run + 1e-3 * (1.0 - (3.0 * t).cos())
    };
    let [with, without] = [World::empty().with_rest(), World::empty()].map(|world| {
        let mut led = on_belt(world, FRICTION);
        led.run(6.0, x);
        led
    });
    assert_eq!([&with, &without].map(|led| led.world.rests()), [1, 0]);
    let [with, without] = [with, without].map(|led| led.world.body());
    let apart = (with.pose.translation.vector - without.pose.translation.vector).norm();
    assert!(apart < 2e-5, "{apart} m");
    assert!(with.pose.rotation.angle_to(&without.pose.rotation) < 1e-4);
    // Within the friction cone nothing slips: both have come as far as the belt.
    let slipped = (without.pose.translation.x - x(6.0 - PERIOD)).abs();
    assert!(slipped < 1e-4, "{slipped} m");
}

#[test]
fn the_belt_bears_the_inertia_of_what_it_carries_at_rest_or_not() {
    for world in [World::empty(), World::empty().with_rest()] {
        let mut led = on_belt(world, FRICTION);
        let pull = 1.0;
        led.run(0.3, |_| 0.0);
        led.run(0.8, |t| 0.5 * pull * (t - 0.3) * (t - 0.3));
        // m a, 0.3 N; against the belt's motion.
        assert!((led.force + MASS * pull).abs() < 0.01 * MASS, "{} N", led.force);
    }
}

#[test]
fn a_body_that_is_taken_away_is_gone_and_counted_once() {
    let sink = Sink { lower: [-2.0, -1.0, -0.6], upper: [3.0, 1.0, -0.2] };
    let world = World::empty().with_rest().with_sink(sink).expect("a sink");
    let first = world.put(&block(0.0)).expect("a block");
    let second = world.put_at(&block(-0.4), 1.0).expect("a block");
    let mut led = Led::new(world, Belt::new(-1.0, 0.2, 0.4));
    led.run(0.5, |_| 0.0);
    // One that has not come yet cannot be taken, nor one that does not exist.
    assert!(!led.world.take_away(second, 0) && !led.world.take_away(second + 1, 0));
    assert!(led.world.take_away(first, 0) && !led.world.take_away(first, 0));
    assert_eq!((led.world.taken(0), led.world.body_of(first).is_some()), (1, false));
    led.run(1.5, |_| 0.0);
    assert_eq!((led.world.taken(0), led.world.whereabouts(second)), (1, Some(Whereabouts::Here)));
    let mut left = Vec::new();
    led.world.each_body(|number, _| left.push(number));
    assert_eq!(left, [second]);
}

#[test]
fn a_body_tips_over_the_end_and_the_sink_below_counts_it_once() {
    let sink = Sink { lower: [-2.0, -1.0, -0.6], upper: [3.0, 1.0, -0.2] };
    let world = World::empty().with_rest().with_sink(sink).expect("a sink");
    let first = world.put(&block(0.0)).expect("a block");
    let second = world.put_at(&block(-0.4), 1.0).expect("a block");
    let mut led = Led::new(world, Belt::new(-1.0, 0.2, 0.4));
    assert_eq!(led.world.whereabouts(second), Some(Whereabouts::Awaited));
    assert!(led.world.body_of(second).is_none());
    let x = |t: f64| 0.1 * t;
    led.run(1.5, x);
    assert_eq!((led.world.taken(0), led.world.whereabouts(second)), (0, Some(Whereabouts::Here)));
    // Its middle is over the end after 2 s; then it falls by 0.2 m, within 0.2 s.
    led.run(4.0, x);
    let Some(Whereabouts::Gone { sink: 0, time }) = led.world.whereabouts(first) else { panic!("not gone") };
    assert!((2.0..2.8).contains(&time), "{time}");
    // The other one is put 0.4 m before the first and comes 1 s later: 5 s later, and it slips on a little.
    led.run(12.0, x);
    let Some(Whereabouts::Gone { sink: 0, time: later }) = led.world.whereabouts(second) else {
        panic!("not gone")
    };
    assert!((later - time - 5.0).abs() < 0.05, "{}", later - time);
    assert_eq!(led.world.taken(0), 2);
    let mut left = 0;
    led.world.each_body(|_, _| left += 1);
    assert_eq!(left, 0);
}

#[test]
fn a_body_that_tips_over_the_end_is_not_thrown_up() {
    let edges = [0.056, 0.074, 0.037];
    for degrees in (0..90).step_by(6) {
        let world = World::empty().with_rest();
        let turned = Pose::rotation(Vector3::z() * f64::from(degrees).to_radians());
        world.put(&Body::block(0.15, edges).at(at(0.0, 0.0, 0.5 * edges[2]) * turned)).expect("a block");
        let mut led = Led::new(world, Belt::new(-1.0, 0.02, 0.24));
        let mut pose = led.world.body().pose;
        for tick in 1..4000 {
            led.run(f64::from(tick) * PERIOD, |t| 0.02 * t);
            pose = led.world.body().pose;
            // Nothing lifts it: to the height from which it would fall with the belt's speed, v^2 / 2 g, are 0.02 mm.
            let height = pose.translation.z;
            assert!(height < 0.5 * edges[2] + 1e-4, "{degrees} degrees: {height} m high");
        }
        assert!(pose.translation.z < -0.2, "{degrees} degrees: it has not fallen, {pose}");
    }
}

#[test]
fn a_conveyor_carries_a_body_with_its_true_joint_and_bears_it_at_its_motor() {
    let currents = [0.0, 50.0].map(|mass: f64| {
        let world = World::empty().with_rest();
        if mass > 0.0 {
            world.put(&Body::block(mass, EDGES).at(at(0.0, 0.0, 0.02))).expect("a block");
        }
        let belt = Belt::new(-1.0, 3.0, 0.4).with_stiffness(6e5, 2000.0);
        let mut belt = world.belt(Simulated::new(Conveyor::new(), &One::zeros()), belt).expect("a belt");
        let mut current = 0.0;
        for i in 1..=1000_u32 {
            let t = f64::from(i) * PERIOD;
            belt.tick(&One::new(0.5 * 0.04 * t * t)).expect("follows");
            current += if i > 500 { belt.motor_currents().expect("simulated")[0] / 500.0 } else { 0.0 };
        }
        if mass > 0.0 {
            let off = world.body().pose.translation.x - belt.shaft().state().position[0];
            // The world is a period behind the drive, 0.16 mm at 0.08 m/s.
            assert!(off.abs() < 4e-4, "{off} m");
        }
        current
    });
    // m a = 2 N through 2250 rad/m at 0.1 N m/A: 8.9 mA more.
    let more = currents[1] - currents[0];
    assert!((more / (50.0 * 0.04 / 2250.0 / 0.1) - 1.0).abs() < 0.05, "{more} A");
}

#[test]
fn a_belt_that_leans_or_has_no_size_is_refused() {
    let world = World::empty();
    let drive = |base| Simulated::new(Conveyor::new().with_base(base), &One::zeros());
    let leaning = Pose::rotation(Vector3::x() * 0.1);
    assert!(world.belt(drive(leaning), Belt::new(0.0, 1.0, 0.4)).is_err());
    assert!(world.belt(drive(Pose::identity()), Belt::new(1.0, 1.0, 0.4)).is_err());
    assert!(world.belt(drive(Pose::identity()), Belt::new(0.0, 1.0, f64::NAN)).is_err());
    assert!(World::empty().with_sink(Sink { lower: [0.0; 3], upper: [1.0, 1.0, 0.0] }).is_err());
}
