//! Squeezes on a body with inertia, in springs with dampers, felt by simulated wrist sensors (`mrroc_robots::grasp`).

use std::cell::Cell as Shared;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::cooperation::{
    BodyFrame, GraspStiffness, SqueezeBounds, SqueezeGains, SqueezeLaw, TimedBody,
};
use mrroc_generators::generators::{RigidCarry, SqueezedCarry};
use mrroc_robots::grasp::{Body, Grasp, SimulatedWrist, World};
use mrroc_robots::sensors::WristForce;
use mrroc_robots::{Polycrank, Seven, Simulated};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::kit::STEP;

type Two = [Polycrank; 2];

/// How the second gripper closes; the first closes where it finds the bar.
#[derive(Clone, Copy)]
enum Closing {
    /// Where it finds the bar: stress comes with the displacement.
    WhereItIs,
    /// Tightened over two seconds, where the program believes the bar to be: it pulls the whole misplacement into the bar.
    WhereItIsSaidToBe,
}

/// The internal force at its peak and at the end \[N\], from the closed grasps on, of a bar of 1 kg that is carried 0.1 m aside
/// and 0.05 m up in four seconds, by arms of which one's base stands 1 mm aside and 0.1 degree turned.
fn stress(closing: Closing, with_sensors: bool) -> (f64, f64) {
    let start = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let bases = [Pose::identity(), Pose::translation(0.6, 0.0, 0.0)];
    let [one, two] = bases.map(|base| Polycrank::new().with_base(base));
    let flanges = [one.forward(&start), two.forward(&start)];
    let middle = Translation3::from(flanges[0].translation.vector.lerp(&flanges[1].translation.vector, 0.5));
    let bar = Body::block(1.0, [0.6, 0.1, 0.1]).at(Pose::from_parts(middle, UnitQuaternion::identity()));
    let world = World::new(&bar).expect("a bar");
    let error = Pose::new(Vector3::new(1e-3, 0.0, 0.0), Vector3::z() * 0.1_f64.to_radians());
    let off = Polycrank::new().with_base(bases[1] * error);
    let grasp = Grasp::new(5e4, 500.0);
    // Until the second grasp is tightened the first one alone carries the bar, which counts as internal.
    let (second, tightened) = match closing {
        Closing::WhereItIs => (grasp, 0),
        Closing::WhereItIsSaidToBe => {
            let middle = Pose::from_parts(middle, UnitQuaternion::identity());
            (grasp.at(middle.inverse() * flanges[1]).closing_over(2.0), 1000)
        }
    };
    let left = world.arm(Simulated::new(one.clone(), &start), grasp).expect("an arm");
    let right = world.arm(Simulated::new(off, &start), second).expect("an arm");
    let hands = [left.hand(), right.hand()];
    let wrists = [left.hand(), right.hand()].map(|hand| SimulatedWrist::new(hand).with_low_pass(50.0));
    let [wrist_one, wrist_two] = wrists;
    let (peak, seen, watched) = (Rc::new(Shared::new(0.0_f64)), world.clone(), hands.clone());
    let highest = Rc::clone(&peak);
    let cell = Cell::new(STEP)
        .robot(RobotSetup::new("one", one, left))
        .robot(RobotSetup::new("two", two, right))
        .sensor(SensorSetup::new("wrist_one", wrist_one).of("one"))
        .sensor(SensorSetup::new("wrist_two", wrist_two).of("two"))
        .on_step(move |step, _| {
            if watched[1].is_closed() && step >= tightened {
                highest.set(highest.get().max(seen.internal_force()));
            }
        });
    let cell = cell.program(move |mp| {
        let (mut one, mut two) = (mp.robot::<Polycrank>("one")?, mp.robot::<Polycrank>("two")?);
        let (mut left, mut right) =
            (mp.sensor::<WristForce>("wrist_one")?, mp.sensor::<WristForce>("wrist_two")?);
        for hand in &hands {
            hand.close().map_err(|error| mrroc::fault::Fault::thrown(&error.to_string()))?;
        }
        // A smooth start and end (of fifth order), and time for the weight to be taken.
        let path = TimedBody::new(7.0, |t| {
            let u = ((t - 2.5) / 4.0).clamp(0.0, 1.0);
            let s = u * u * u * (10.0 - u * (15.0 - 6.0 * u));
            Pose::translation(0.0, 0.1 * s, 0.05 * s)
        });
        if with_sensors {
            let stiffness = GraspStiffness { force: 5e4, torque: 500.0 };
            let gains = SqueezeGains { stiffness, rate: 8.0, inertia: 0.03 };
            let bounds = SqueezeBounds { speed: 0.02, turning: 0.1, travel: 5e-3, angle: 0.02 };
            let law = SqueezeLaw::new(gains, bounds, 0.03).expect("reserve");
            let carry =
                SqueezedCarry::<Two, [WristForce; 2], _>::along(BodyFrame::Centroid, path, law, 0.0, 0);
            mp.move_robots([&mut one, &mut two], [&mut left, &mut right], carry).map(drop)
        } else {
            mp.move_robots([&mut one, &mut two], (), RigidCarry::along(BodyFrame::Centroid, path)).map(drop)
        }
    });
    cell.run().expect("within the limits");
    (peak.get(), world.internal_force())
}

#[test]
fn sensors_reduce_the_peak_stress_of_a_misplaced_base_to_a_fifth() {
    for closing in [Closing::WhereItIs, Closing::WhereItIsSaidToBe] {
        let ((peak, end), (peak_with, end_with)) = (stress(closing, false), stress(closing, true));
        assert!(peak_with < peak / 5.0, "{peak_with} N of {peak} N");
        assert!(end_with < end / 5.0, "{end_with} N of {end} N");
    }
}
