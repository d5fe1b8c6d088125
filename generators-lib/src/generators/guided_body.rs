//! Several arms carry a body to where a person pushes it.

use core::marker::PhantomData;

use mrroc::generator::{Motion, RobotList, RobotsEach, SensorList, SensorsEach};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use nalgebra::{Translation3, Vector3};

use mrroc_generators::cooperation::Placed;
use mrroc_generators::force::Give;

/// Moves all tools of the list `L` by one translation, whose velocity follows the push on the body: `u = (b F T + b m u') /
/// (T + b m)`. `F` is the sum of the forces that the wrist sensors `V` read, turned into the world by the *measured* poses
/// of the tools, less the same sum in the first step: the body's weight. No arm presses against another.
///
/// Pushes below the threshold do not move the body. A body that is pushed beyond `reach` is a fault. If a reading of any
/// arm is missing or too old, the body holds.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::force::Give;
/// use mrroc_generators::generators::GuidedBody;
/// use mrroc_generators::rehearsal::{at_rest, rehearse_all};
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// let arms = [0.0, 0.5].map(|y| {
///     let base = Pose::translation(0.0, y, 0.0);
///     at_rest(&Irp6::nominal().with_base(base), Irp6::READY)
/// });
/// let give = Give { reciprocal_damping: 0.01, inertia: 0.0 };
/// let guided = GuidedBody::<[Irp6; 2], [Wrist; 2]>::yielding(give, 1.0, 0.5, 1.0);
/// // Nothing in the first step, then 10 N along the x axis of the world, half of it felt by each arm.
/// let mut push = 0.0;
/// let demands = rehearse_all(guided, 0.002, |last| {
///     push = if last.is_some() { 5.0 } else { 0.0 };
///     let v = Reading::new(arms.map(|arm| {
///         let force = arm.measured().pose.rotation.inverse_transform_vector(&(Vector3::x() * push));
///         SensorImage::new(Wrench::new(force, Vector3::zeros()), 0)
///     }));
///     Ok(Given { order: Order::new(()), e: State::new(arms), v })
/// })?;
/// // Without inertia it moves at b (F - 1 N) = 0.09 m/s, in 499 of the 500 steps.
/// let end = demands[499][0].as_pose().map_or(0.0, |pose| pose.translation.x);
/// let travel = end - arms[0].demanded().pose.translation.x;
/// assert!((travel - 0.09 * 0.998).abs() < 1e-9, "{travel}");
/// # Ok::<(), Fault>(())
/// ```
pub struct GuidedBody<L: RobotList, V, O = Motion> {
    give: Give,
    threshold: f64,
    reach: f64,
    duration: f64,
    starts: L::Each<Pose>,
    weight: Option<Vector3<f64>>,
    velocity: Vector3<f64>,
    travel: Vector3<f64>,
    time: f64,
    of: PhantomData<(V, O)>,
}

impl<L: RobotsEach<Placed, O>, V: SensorsEach<Wrench>, O: 'static> GuidedBody<L, V, O> {
    /// Yields by `give` to pushes above `threshold` \[N\], >= 0, at most `reach` \[m\] from the start, for `duration` \[s\].
    #[must_use]
    pub fn yielding(give: Give, threshold: f64, reach: f64, duration: f64) -> Self {
        const { assert!(<L as RobotList>::LEN == <V as SensorList>::LEN, "one wrist sensor for each robot") };
        let starts = L::array(|_| Pose::identity());
        let still = Vector3::zeros();
        let weight = None;
        let velocity = still;
        let travel = still;
        let time = 0.0;
        let of = PhantomData;
        GuidedBody { give, threshold, reach, duration, starts, weight, velocity, travel, time, of }
    }
}

#[generator(mp)]
impl<L: RobotsEach<Placed, O>, V: SensorsEach<Wrench>, O: 'static> GuidedBody<L, V, O> {
    fn first_step(&mut self, e: &State<L>, v: &Reading<V>, t: Tick) -> Result<Step<L, O>, Fault> {
        let Give { reciprocal_damping, inertia } = self.give;
        if ![reciprocal_damping, inertia, self.threshold, self.reach]
            .iter()
            .all(|x| x.is_finite() && *x >= 0.0)
        {
            return Err(Fault::thrown(
                "damping, inertia, threshold and reach of a guided body must be finite and >= 0",
            ));
        }
        self.starts = e.demanded_poses();
        self.next_step(e, v, t)
    }

    #[allow(non_snake_case)]
    fn next_step(&mut self, e: &State<L>, v: &Reading<V>, t: Tick) -> Result<Step<L, O>, Fault> {
        if self.duration.is_nan() || self.time >= self.duration {
            return Ok(Step::Done);
        }
        self.time += t.dt;
        let measured = e.measured_poses();
        let readings = v.each::<Wrench>();
        let mut sum = Some(Vector3::zeros());
        for (X, reading) in measured.as_ref().iter().zip(readings.as_ref()) {
            let fresh = reading.filter(|(_, age)| *age <= 1).map(|(wrench, _)| X.rotation * wrench.force);
            sum = sum.zip(fresh).map(|(sum, force): (Vector3<f64>, _)| sum + force);
        }
        let Give { reciprocal_damping: b, inertia: m } = self.give;
        let push = sum.map_or(Vector3::zeros(), |sum| sum - *self.weight.get_or_insert(sum));
        let push = if push.norm() > self.threshold {
            push * (1.0 - self.threshold / push.norm())
        } else {
            push * 0.0
        };
        if t.dt > 0.0 {
            self.velocity = (push * (b * t.dt) + self.velocity * (b * m)) / (t.dt + b * m);
        }
        self.travel += self.velocity * t.dt;
        let far = self.travel.norm();
        if far.is_nan() || far > self.reach {
            return Err(
                Fault::thrown("a guided body was pushed out of its reach").exceeds(far, self.reach, "m")
            );
        }
        let starts = &self.starts;
        let moved = Translation3::from(self.travel);
        Ok(Step::Next(L::each(|i| Placed { X_WEs: starts.as_ref()[i], X_WE: moved * starts.as_ref()[i] })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};
    use std::f64::consts::PI;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    #[test]
    fn the_body_goes_where_it_is_pushed_and_its_weight_is_no_push() {
        let poses = [0.5, 0.9].map(|x| Pose::new(Vector3::new(x, 0.0, 0.3), Vector3::x() * PI));
        let e = State::<[Irp6; 2]>::new(poses.map(|pose| {
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
            RobotImage::new(state, state)
        }));
        // Tools point down: 15 N of weight along z of each; a push of 10 N along x of the world, felt by one.
        let felt =
            |x| SensorImage::<Wrist>::new(Wrench::new(Vector3::new(x, 0.0, 15.0), Vector3::zeros()), 0);
        let v = |x| Reading::<[Wrist; 2]>::new([felt(x), felt(0.0)]);
        let b = 0.01;
        let m = 10.0;
        let dt = 2e-3;
        let give = Give { reciprocal_damping: b, inertia: m };
        let mut generator = GuidedBody::<[Irp6; 2], [Wrist; 2]>::yielding(give, 2.0, 0.1, 5.0);
        let t = Tick { step: 0, dt, duration: dt };
        let held = generator.first_step(&e, &v(0.0), t).expect("in reach");
        assert_eq!(held, Step::Next(poses.map(Demand::pose)));
        let r = b * m / (dt + b * m);
        for n in 1..=200 {
            let step = generator.next_step(&e, &v(10.0), t).expect("in reach");
            assert!(matches!(step, Step::Next(_)));
            // Of 10 N, 8 are above the threshold: u_n = b F (1 - r^n), x_n = T sum u.
            let x = dt * b * 8.0 * (f64::from(n) - r * (1.0 - r.powi(n)) / (1.0 - r));
            assert!((generator.travel - Vector3::new(x, 0.0, 0.0)).norm() < 1e-12, "{}", generator.travel);
        }
        let fault = (0..2000).find_map(|_| generator.next_step(&e, &v(20.0), t).err()).expect("out of reach");
        assert!(fault.excess().is_some_and(|x| x.actual > 0.1 && x.limit == 0.1));
    }
}
