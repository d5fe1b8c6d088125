//! Two arms lift one body; the base of the second stands 1 mm off where the program believes it to be.
//!
//! `cargo run -p mrroc-examples --example 01_two_arms_one_body`

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::grasp::{Body, Grasp, SimulatedWrist, World};
use mrroc_robots::sensors::WristForce;
use mrroc_robots::{Polycrank, Seven, Simulated};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Lifts both flanges by 5 cm in four seconds.
struct Lift {
    /// Upwards, in the axes of both tools.
    up: Vector3<f64>,
    t: f64,
}

#[generator(mp)]
fn lift(c: &mut Lift, v: &Reading<(WristForce,)>, t: Tick) -> Step<(Polycrank, Polycrank)> {
    if c.t >= 4.0 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(4.0);
    if let Some(wrench) = v.0.reading().filter(|_| t.step.is_multiple_of(250)) {
        let [x, y, z]: [f64; 3] = wrench.force.into();
        println!("{:4.1} s: the second wrist feels ({x:6.2}, {y:6.2}, {z:6.2}) N", c.t);
    }
    let height = 0.025 * (1.0 - (0.25 * std::f64::consts::PI * c.t).cos());
    let displacement = Pose::from_parts((c.up * height).into(), UnitQuaternion::identity());
    Step::Next((Demand::displacement(displacement), Demand::displacement(displacement)))
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let bases = [Pose::identity(), Pose::translation(0.6, 0.0, 0.0)];
    let [one, two] = bases.map(|base| Polycrank::new().with_base(base));
    let flanges = [one.forward(&start), two.forward(&start)];
    let up = flanges[0].rotation.inverse() * Vector3::z();

    // A bar of 3 kg between the flanges.
    let middle = Translation3::from(flanges[0].translation.vector.lerp(&flanges[1].translation.vector, 0.5));
    let bar = Pose::from_parts(middle, UnitQuaternion::identity());
    let world = World::new(&Body::block(3.0, [0.6, 0.1, 0.1]).at(bar))?;
    let grasp = |flange: Pose| Grasp::new(5e4, 500.0).at(bar.inverse() * flange);

    // The true second arm: the program's is `two`.
    let off = Polycrank::new().with_base(Pose::translation(0.601, 0.0, 0.0));
    let left = world.arm(Simulated::new(one.clone(), &start), grasp(flanges[0]))?;
    let right = world.arm(Simulated::new(off, &start), grasp(flanges[1]))?;
    let (hands, wrist) = ([left.hand(), right.hand()], SimulatedWrist::new(right.hand()).with_low_pass(50.0));

    Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("one", one, left))
        .robot(RobotSetup::new("two", two, right))
        .sensor(SensorSetup::new("force", wrist).of("two"))
        .program(move |mp| {
            let (mut one, mut two) = (mp.robot::<Polycrank>("one")?, mp.robot::<Polycrank>("two")?);
            let mut force = mp.sensor::<WristForce>("force")?;
            hands[0].close()?;
            hands[1].close()?;
            mp.move_robots((&mut one, &mut two), (&mut force,), Lift { up, t: 0.0 })?;
            let squeeze = hands[0].world().internal_force();
            println!("the hands squeeze the body with {squeeze:.1} N");
            // k delta / 2, two springs of 5e4 N/m in series.
            assert!((squeeze - 25.0).abs() < 1.0);
            Ok(())
        })
        .run()?;
    Ok(())
}
