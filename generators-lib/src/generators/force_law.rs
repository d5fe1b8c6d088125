//! MRROC++'s force control: every axis of the tool moves freely, is guarded, or keeps a load.

use core::marker::PhantomData;

use mrroc::pose::Wrench;
use mrroc::prelude::*;

use mrroc_generators::force::{Felt, ForceControl, fresh};

/// Moves the tool by a [`ForceControl`] and the readings of a wrist sensor: the load of the surroundings on the tool,
/// in the axes of the tool.
///
/// Starts from the pose demanded last, at rest, and ends after a path time, or where a condition holds on what is felt.
/// Without a reading nothing moves; a reading that is too old is a fault.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
/// use mrroc_generators::generators::ForceLaw;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// // Along its z axis the tool presses with 10 N on a spring of 2 N/mm; along the others it stays.
/// let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
/// axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
/// let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let irp6 = Irp6::nominal();
/// let depth = |arm: Pose| irp6.forward(&Irp6::READY).inv_mul(&arm).translation.z;
/// let motion = ForceLaw::<Irp6, Wrist>::lasting(law, 3.0, 1);
/// let demands = rehearse_with(motion, &irp6, Irp6::READY, 0.002, |arm| {
///     let push = Vector3::z() * -2000.0 * depth(arm.measured().pose);
///     (Order::new(()), Reading::new((SensorImage::new(Wrench::new(push, Vector3::zeros()), 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_pose);
/// assert!(end.is_some_and(|end| (2000.0 * depth(end) - 10.0).abs() < 1e-3));
/// # Ok::<(), Fault>(())
/// ```
pub struct ForceLaw<R, S> {
    law: ForceControl,
    duration: f64,
    oldest: u32,
    until: Option<fn(&Felt) -> bool>,
    found: bool,
    start: Pose,
    pose: Pose,
    time: f64,
    of: PhantomData<(R, S)>,
}

impl<R: Robot, S: Sensor<Reading = Wrench>> ForceLaw<R, S> {
    /// By `law` for `duration` \[s\], >= 0, which may be infinite; readings may be `oldest` steps old.
    #[must_use]
    pub fn lasting(law: ForceControl, duration: f64, oldest: u32) -> Self {
        ForceLaw {
            law,
            duration,
            oldest,
            until: None,
            found: false,
            start: Pose::identity(),
            pose: Pose::identity(),
            time: 0.0,
            of: PhantomData,
        }
    }

    /// The same, which ends where `found` holds, if that is before its time.
    #[must_use]
    pub fn until(self, found: fn(&Felt) -> bool) -> Self {
        ForceLaw { until: Some(found), ..self }
    }

    /// Whether the condition of [`until`](Self::until) has held.
    #[must_use]
    pub const fn has_found(&self) -> bool {
        self.found
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor<Reading = Wrench>> ForceLaw<R, S> {
    fn first_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        self.start = e.demanded().pose;
        self.pose = self.start;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        if self.duration.is_nan() || self.time >= self.duration {
            return Ok(Step::Done);
        }
        self.time += t.dt;
        if let Some(load) = fresh(&v.0, self.oldest)? {
            let travel = self.start.inv_mul(&self.pose).translation.vector;
            if self.until.is_some_and(|found| found(&Felt { load, travel })) {
                self.found = true;
                return Ok(Step::Done);
            }
            self.pose *= self.law.advance(&load, t.dt)?;
            self.pose.rotation.renormalize_fast();
        }
        Ok(Step::Next(Demand::pose(self.pose)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::force::{Behaviour, Bound, Give};
    use mrroc_robots::{Irp6, SimulatedIrp6};
    use nalgebra::Vector3;
    use std::time::Duration;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    const WITHIN: Bound = Bound { speed: 0.1, travel: 0.05 };

    /// A table at this height \[m\], a spring of 2 N/mm, under a tool that points down.
    struct Table(f64);

    impl VirtualSensor for Table {
        type Kind = Wrist;
        fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Wrench, Fault> {
            let tool = order.robot.ok_or_else(|| Fault::thrown("the sensor is on no robot"))?;
            let up = Vector3::z() * 2000.0 * (self.0 - tool.pose.translation.z).max(0.0);
            Ok(Wrench::new(tool.pose.rotation.inverse_transform_vector(&up), Vector3::zeros()))
        }
    }

    #[test]
    fn the_tool_finds_the_table_and_presses_on_it_as_told() {
        let irp6 = Irp6::nominal();
        let start = Irp6::READY;
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let height = irp6.forward(&start).translation.z - 5e-3;
        let robot = RobotSetup::new("irp6", irp6.clone(), arm).program(|ecp| {
            let mut wrist = ecp.sensor::<Wrist>("wrist")?;
            let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
            axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: WITHIN };
            let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
            ecp.move_robot((&mut wrist,), ForceLaw::lasting(law, 4.0, 1)).map(drop)
        });
        let wrist = SensorSetup::new("wrist", Table(height)).of("irp6");
        Cell::new(Duration::from_millis(2)).robot(robot).sensor(wrist).run().expect("within the limits");
        let depth = height - irp6.forward(&shaft.state().position).translation.z;
        // F = K depth; an encoder count is some 10 um, which is 0.02 N.
        assert!((2000.0 * depth - 10.0).abs() < 0.2, "{} N", 2000.0 * depth);
    }

    /// Free space: with `b F` = 50 mm/s and the time constant `b m` = 0.1 s, 20 mm are gone where
    /// `50 (t - 0.1 (1 - exp(-t / 0.1))) = 20`, at 0.499 s.
    #[test]
    fn it_ends_where_the_tool_has_gone_as_far_as_its_condition_says() {
        let irp6 = Irp6::nominal();
        let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
        axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: WITHIN };
        let law = ForceControl::new(axes).expect("in range");
        let mut motion = ForceLaw::<Irp6, Wrist>::lasting(law, 4.0, 1).until(|felt| felt.travel.z > 0.02);
        let e = State::new(mrroc_generators::rehearsal::at_rest(&irp6, Irp6::READY));
        let v = Reading::new((mrroc::sensor::SensorImage::new(Wrench::default(), 0),));
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let mut step = motion.first_step(&e, &v, t);
        let mut steps = 0;
        while let Ok(Step::Next(_)) = step {
            assert!(!motion.has_found());
            steps += 1;
            step = motion.next_step(&v, t);
        }
        assert!(step == Ok(Step::Done) && motion.has_found());
        assert!((f64::from(steps) * 2e-3 - 0.499).abs() < 0.005, "{steps} steps");
    }
}
