//! Any generator of poses, corrected by a sensor.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::generator::{Class, Generator, Joined, Motion};
use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// How fast and how far a correction may go; all within 1e-9 and 1e9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrectionLimits {
    /// Speed [m/s].
    pub speed: f64,
    /// Angular speed [rad/s].
    pub turning: f64,
    /// Time in which the correction's speed reaches these \[s\], and in which it approaches its goal.
    pub ramp: f64,
    /// Distance \[m\] beyond which a correction is a fault.
    pub travel: f64,
    /// Angle \[rad\] beyond which it is one.
    pub angle: f64,
    /// Age of a reading that is too old \[steps\].
    pub oldest: u32,
}

/// Adds to what a generator `G` of one sensor at most demands, poses or displacements, a correction in the tool's own axes:
/// `X_WE X_EE'`. The sensor of the correction is the last.
/// The correction `X_EE'` goes towards what `correct` makes of a reading, at a limited speed and acceleration; without a
/// reading it stays. The generator knows nothing of it.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::combinators::{Corrected, CorrectionLimits};
/// use mrroc_generators::cooperation::Displacement;
/// use mrroc_generators::generators::ToolOffset;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
///
/// # struct Camera;
/// # impl Sensor for Camera {
/// #     const KIND: &'static str = "camera";
/// #     type Reading = Displacement;
/// #     type Configuration = ();
/// # }
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let line = ToolOffset::<Irp6>::by(Pose::translation(0.2, 0.0, 0.0), limits);
/// let within = CorrectionLimits { speed: 0.02, turning: 0.1, ramp: 0.1, travel: 0.02, angle: 0.1, oldest: 1 };
/// let motion = Corrected::<_, Camera>::by(line, |seam| seam.pose, within);
/// // The seam that the camera sees is 1 cm beside the line.
/// let seam = Displacement { pose: Pose::translation(0.0, 0.01, 0.0) };
/// let demands = rehearse_with(motion, &Irp6::nominal(), Irp6::READY, 0.002, |_| {
///     (Order::new(()), Reading::new((SensorImage::new(seam, 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_displacement).map(|end| end.translation.vector);
/// assert!(end.is_some_and(|end| (end - nalgebra::Vector3::new(0.2, 0.01, 0.0)).norm() < 1e-6));
/// # Ok::<(), Fault>(())
/// ```
pub struct Corrected<G, S: Sensor> {
    generator: G,
    correct: fn(&S::Reading) -> Pose,
    limits: CorrectionLimits,
    travel: Vector3<f64>,
    turn: Vector3<f64>,
    speed: Vector3<f64>,
    turning: Vector3<f64>,
    of: PhantomData<S>,
}

impl<G: Generator<Language = Motion>, S: Sensor> Corrected<G, S> {
    /// `generator`, displaced by what `correct` makes of a reading, within `limits`.
    #[must_use]
    pub fn by(generator: G, correct: fn(&S::Reading) -> Pose, limits: CorrectionLimits) -> Self {
        let still = Vector3::zeros();
        Corrected {
            generator,
            correct,
            limits,
            travel: still,
            turn: still,
            speed: still,
            turning: still,
            of: PhantomData,
        }
    }

    fn check(&self) -> Result<(), Fault> {
        let CorrectionLimits { speed, turning, ramp, travel, angle, .. } = self.limits;
        if [speed, turning, ramp, travel, angle].iter().all(|x| (1e-9..=1e9).contains(x)) {
            return Ok(());
        }
        Err(Fault::thrown("the limits of a correction must lie within 1e-9 and 1e9"))
    }

    /// The correction after `t` more, towards what the sensor says.
    fn advance(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Pose, Fault> {
        let limits = self.limits;
        let age = v.0.age();
        if let Some(reading) = v.0.reading() {
            if age > limits.oldest {
                return Err(Fault::new(FaultKind::SensorStale).exceeds(
                    age.into(),
                    limits.oldest.into(),
                    "step",
                ));
            }
            let goal = (self.correct)(&reading);
            let travel = goal.translation.vector;
            let turn = goal.rotation.scaled_axis();
            let finite = travel.iter().chain(goal.rotation.coords.iter()).all(|x| x.is_finite());
            if !finite || travel.norm() > limits.travel || turn.norm() > limits.angle {
                let fault = Fault::thrown("the sensor asks for a correction that is out of bounds");
                return Err(fault.exceeds(travel.norm(), limits.travel, "m"));
            }
            pull(&mut self.travel, &mut self.speed, &travel, limits.speed, limits.ramp, t.dt);
            pull(&mut self.turn, &mut self.turning, &turn, limits.turning, limits.ramp, t.dt);
        }
        let rotation = UnitQuaternion::from_scaled_axis(self.turn);
        Ok(Pose::from_parts(Translation3::from(self.travel), rotation))
    }

    fn corrected<R: Robot>(&mut self, step: Step<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        let Step::Next(demand) = step else { return Ok(Step::Done) };
        let moved = demand.moved_in_tool(&self.advance(v, t)?);
        let refused = || Fault::thrown("only poses and displacements can be corrected, no joint positions");
        moved.map(Step::Next).ok_or_else(refused)
    }
}

/// Draws `x` towards `goal`: critically damped, within a speed, and an acceleration of that speed in `ramp`.
fn pull(x: &mut Vector3<f64>, v: &mut Vector3<f64>, goal: &Vector3<f64>, speed: f64, ramp: f64, dt: f64) {
    if dt <= 0.0 {
        return;
    }
    // Implicit in v: stable whatever the step.
    let rate = 4.0 / ramp;
    let wanted = (*v + (goal - *x) * (rate * rate * dt)) / (1.0 + 2.0 * rate * dt + rate * rate * dt * dt);
    let within = |x: Vector3<f64>, most: f64| if x.norm() > most { x * (most / x.norm()) } else { x };
    *v += within(within(wanted, speed) - *v, speed / ramp * dt);
    *x += *v * dt;
}

impl<G, S, R> Generator for Corrected<G, S>
where
    G: Generator<Robots = R, Language = Motion>,
    G::Sensors: Joined<(S,)>,
    S: Sensor,
    R: Robot,
{
    type Robots = R;
    type Language = Motion;
    type Sensors = <G::Sensors as Joined<(S,)>>::All;
    type Order = G::Order;
    const CLASS: Class = {
        let mut class = G::CLASS;
        class.first.sensors = true;
        class.first.state = true;
        class.first.tick = true;
        class.next.sensors = true;
        class.next.state = true;
        class.next.tick = true;
        class
    };
    const ENDS: bool = G::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<R>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        self.check()?;
        let (own, v) = G::Sensors::split(v);
        let step = self.generator.first_step(c0, e, &own, t)?;
        self.corrected(step, &v, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<R>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let (own, v) = G::Sensors::split(v);
        let step = self.generator.next_step(c0, e, &own, t)?;
        self.corrected(step, &v, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cooperation::Displacement;
    use crate::force::{Behaviour, Bound, ForceControl, Give};
    use crate::generators::{ForceLaw, ToolOffset};
    use crate::line::ToolLimits;
    use crate::profile::ProfileLimits;
    use mrroc::pose::Wrench;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};

    struct Seam;

    impl Sensor for Seam {
        const KIND: &'static str = "seam";
        type Reading = Displacement;
        type Configuration = ();
    }

    #[test]
    fn a_line_is_drawn_onto_the_seam_within_the_limits_of_the_correction() {
        let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
        let line = ToolOffset::<Irp6>::by(
            Pose::translation(0.2, 0.0, 0.0),
            ToolLimits { translation: limits, rotation: limits },
        );
        let speed = 0.02;
        let ramp = 0.1;
        let dt = 2e-3;
        let bounds = CorrectionLimits { speed, turning: 0.1, ramp, travel: 0.02, angle: 0.1, oldest: 1 };
        let mut generator = Corrected::<_, Seam>::by(line, |seam| seam.pose, bounds);
        assert_eq!(<Corrected<ToolOffset<Irp6>, Seam> as Generator>::CLASS.to_string(), "ECP f*1(c, v)");
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
        let e = State::new(RobotImage::new(state, state));
        let c0 = Order::new(());
        let seam = |y: f64| {
            let pose = Pose::translation(0.0, y, 0.0);
            Reading::<(Seam,)>::new((SensorImage::new(Displacement { pose }, 0),))
        };
        let t = Tick { step: 0, dt, duration: dt };
        let mut p = vec![Vector3::zeros(); 2];
        let mut step = generator.first_step(&c0, &e, &seam(0.01), t);
        while let Ok(Step::Next(demand)) = step {
            p.push(demand.as_displacement().expect("a displacement").translation.vector);
            step = generator.next_step(&c0, &e, &seam(0.01), t);
        }
        assert_eq!(step, Ok(Step::Done));
        for w in p.windows(3) {
            let v = (w[1].y - w[0].y) / dt;
            let a = (w[2].y - 2.0 * w[1].y + w[0].y) / (dt * dt);
            assert!(v.abs() <= speed * (1.0 + 1e-9) && a.abs() <= speed / ramp * (1.0 + 1e-6), "{v} {a}");
            assert!(w[2].y < 0.0103, "overshoot: {}", w[2].y);
        }
        // The line itself is as it was: 0.2 m, with the correction of the seam.
        let end = p[p.len() - 1];
        assert!((end - Vector3::new(0.2, 0.01, 0.0)).norm() < 1e-6, "{end}");
        let far = generator.advance(&seam(0.03), t).expect_err("out of bounds");
        assert!(far.excess().is_some_and(|x| x.actual == 0.03 && x.limit == 0.02));
    }

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    /// Pressing on a surface along z by a wrist's readings, drawn aside along y by those of a seam.
    #[test]
    fn a_generator_that_has_a_sensor_of_its_own_is_corrected_by_another() {
        let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
        axes[2] =
            Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
        let law = ForceControl::new(axes).expect("in range");
        let bounds =
            CorrectionLimits { speed: 0.02, turning: 0.1, ramp: 0.1, travel: 0.02, angle: 0.1, oldest: 1 };
        let press = ForceLaw::<Irp6, Wrist>::lasting(law, 4.0, 1);
        let mut generator = Corrected::<_, Seam>::by(press, |seam| seam.pose, bounds);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
        let c0 = Order::new(());
        let e = State::new(RobotImage::new(state, state));
        let mut at = Vector3::<f64>::zeros();
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        for i in 0..1900 {
            let felt = Wrench::new(Vector3::new(0.0, 0.0, -2000.0 * at.z.max(0.0)), Vector3::zeros());
            let seam = Displacement { pose: Pose::translation(0.0, 0.01, 0.0) };
            let v = Reading::<(Wrist, Seam)>::new((SensorImage::new(felt, 0), SensorImage::new(seam, 0)));
            let step = if i == 0 {
                generator.first_step(&c0, &e, &v, t)
            } else {
                generator.next_step(&c0, &e, &v, t)
            };
            let Ok(Step::Next(demand)) = step else { panic!("{step:?}") };
            at = demand.as_pose().expect("a pose").translation.vector;
        }
        assert!((at - Vector3::new(0.0, 0.01, 10.0 / 2000.0)).norm() < 1e-6, "{at}");
    }
}
