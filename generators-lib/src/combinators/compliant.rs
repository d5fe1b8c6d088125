//! Any generator of poses, whose tool also presses and yields by a force law.

use core::marker::PhantomData;

use mrroc::generator::{Class, Generator, Joined, Motion};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::braked::Braked;
use crate::force::{Felt, ForceControl, fresh};

/// Adds to what a generator `G` of one sensor at most demands, poses or displacements, the motion of a [`ForceControl`] by
/// the readings of a wrist sensor, the last of its sensors: force along z while a path leads along x and y, or a search
/// under pressure.
///
/// ```text
/// p_WE = p_WG + d,   R_WE = R_WG Q        G: what the generator demands
/// d <- d + R_WE p_EE',   Q <- Q R_EE'     X_EE': what the law does in a step, in the tool's axes
/// ```
///
/// The generator goes on as if there were no law: an axis that the path is to lead must not yield to its loads, so
/// [`Unguarded`](crate::force::Behaviour::Unguarded) by 0. Turns of the path leave the tip where it is.
///
/// Ends with the generator, or where a condition holds on what is felt: see [`until`](Self::until). Without a reading nothing
/// moves; a reading that is too old is a fault, and so is a demand of joint positions.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::combinators::Compliant;
/// use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
/// use mrroc_generators::generators::ToolOffset;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
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
/// // 0.1 m along x on a spring of 2 N/mm which rises by 1 mm in 50 mm, pressed with 10 N.
/// let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
/// axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
/// let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let limits = ProfileLimits { velocity: 0.02, acceleration: 0.1 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let path = ToolOffset::<Irp6>::by(Pose::translation(0.1, 0.0, 0.0), limits);
/// let motion = Compliant::<_, Wrist>::by(path, law, 1);
/// let irp6 = Irp6::nominal();
/// let start = irp6.forward(&Irp6::READY);
/// let depth = |arm: &Pose| arm.translation.z + 0.02 * arm.translation.x;
/// let demands = rehearse_with(motion, &irp6, Irp6::READY, 0.002, |arm| {
///     let push = Vector3::z() * -2000.0 * depth(&start.inv_mul(&arm.measured().pose)).max(0.0);
///     (Order::new(()), Reading::new((SensorImage::new(Wrench::new(push, Vector3::zeros()), 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_displacement).expect("it moves");
/// // It slows down from 20 mm/s, and so does the slope's 0.4 mm/s, which takes 0.4 mm/s / b = 0.08 N.
/// assert!((end.translation.x - 0.1).abs() < 1e-12 && (2000.0 * depth(&end) - 10.0).abs() < 0.15);
/// # Ok::<(), Fault>(())
/// ```
pub struct Compliant<G, S> {
    generator: G,
    law: ForceControl,
    oldest: u32,
    until: Option<Until>,
    /// While the generator is braked, once the condition has held.
    braked: Option<Braked>,
    /// Rotation of the first demand.
    start: Option<UnitQuaternion<f64>>,
    /// `d` \[m\] and `Q`.
    travel: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    of: PhantomData<S>,
}

/// Where a motion ends.
#[derive(Clone, Copy)]
struct Until {
    found: fn(&Felt) -> bool,
    /// \[s\].
    braking: f64,
}

impl<G: Generator<Language = Motion>, S: Sensor<Reading = Wrench>> Compliant<G, S> {
    /// `generator`, while the tool presses and yields by `law`; readings may be `oldest` steps old.
    #[must_use]
    pub fn by(generator: G, law: ForceControl, oldest: u32) -> Self {
        Compliant {
            generator,
            law,
            oldest,
            until: None,
            braked: None,
            start: None,
            travel: Vector3::zeros(),
            turn: UnitQuaternion::identity(),
            of: PhantomData,
        }
    }

    /// The same, which ends where `found` holds: the generator is braked on its path, by taking its path time away
    /// within `braking` \[s\], > 0, while the law goes on. At a speed `v` that is a deceleration of `1.5 v / braking` and a jerk of
    /// `4.5 v / braking²` at most.
    #[must_use]
    pub fn until(self, found: fn(&Felt) -> bool, braking: f64) -> Self {
        Compliant { until: Some(Until { found, braking }), ..self }
    }

    /// Whether the condition of [`until`](Self::until) has held. Where it has not, the generator came to its end.
    #[must_use]
    pub const fn has_found(&self) -> bool {
        self.braked.is_some()
    }

    /// What is felt now; the tick of the generator, without path time where nothing has been felt yet; `None` at the end.
    fn begin(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Option<(Option<Wrench>, Tick)>, Fault> {
        let Some(load) = fresh(&v.0, self.oldest)? else { return Ok(Some((None, Tick { dt: 0.0, ..t }))) };
        let travel =
            self.start.map_or_else(Vector3::zeros, |start| start.inverse_transform_vector(&self.travel));
        let Some(Until { found, braking }) = self.until else { return Ok(Some((Some(load), t))) };
        if self.braked.as_ref().is_some_and(Braked::stands) {
            return Ok(None);
        }
        if self.braked.is_none() && found(&Felt { load, travel }) {
            self.braked = Some(Braked::within(braking));
        }
        let share = self.braked.as_mut().map_or(1.0, |braked| braked.share(t.dt));
        Ok(Some((Some(load), Tick { dt: t.dt * share, ..t })))
    }

    /// What the generator demands, moved as the law has moved the tool.
    #[allow(non_snake_case)]
    fn moved<R: Robot>(&mut self, step: Step<R>, load: Option<Wrench>, t: Tick) -> Result<Step<R>, Fault> {
        let Step::Next(demand) = step else { return Ok(Step::Done) };
        let refused = || Fault::thrown("a tool on a path of joint positions cannot yield: demand poses");
        let R_WG = demand.as_pose().or(demand.as_displacement()).ok_or_else(refused)?.rotation;
        self.start.get_or_insert(R_WG);
        if let Some(load) = load {
            let X_EE = self.law.advance(&load, t.dt)?;
            self.travel += R_WG * (self.turn * X_EE.translation.vector);
            self.turn *= X_EE.rotation;
            self.turn.renormalize_fast();
        }
        let X_GE =
            Pose::from_parts(Translation3::from(R_WG.inverse_transform_vector(&self.travel)), self.turn);
        demand.moved_in_tool(&X_GE).map(Step::Next).ok_or_else(refused)
    }
}

impl<G, S, R> Generator for Compliant<G, S>
where
    G: Generator<Robots = R, Language = Motion>,
    G::Sensors: Joined<(S,)>,
    S: Sensor<Reading = Wrench>,
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
    // By its condition, whatever the generator does.
    const ENDS: bool = true;

    fn first_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<R>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        if self.until.is_some_and(|Until { braking, .. }| !Braked::is_possible(braking)) {
            return Err(Fault::thrown("the time in which a motion is braked must be finite and > 0"));
        }
        let (own, v) = G::Sensors::split(v);
        let Some((load, tick)) = self.begin(&v, t)? else { return Ok(Step::Done) };
        let step = self.generator.first_step(c0, e, &own, tick)?;
        self.moved(step, load, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<R>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let (own, v) = G::Sensors::split(v);
        let Some((load, tick)) = self.begin(&v, t)? else { return Ok(Step::Done) };
        let step = self.generator.next_step(c0, e, &own, tick)?;
        self.moved(step, load, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::{Behaviour, Bound, Give};
    use crate::generators::{JointMove, SpiralSearch, TiltSearch, ToolOffset};
    use crate::line::ToolLimits;
    use crate::profile::{JerkLimits, ProfileLimits};
    use crate::rehearsal::rehearse_with;
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    const STIFFNESS: f64 = 2000.0;
    const LOAD: f64 = 10.0;
    const DT: f64 = 2e-3;

    /// Presses along z of the tool.
    fn law() -> ForceControl {
        let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
        axes[2] =
            Behaviour::Contact { load: LOAD, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
        ForceControl::new(axes).expect("in range")
    }

    /// Where the tool is in its axes at the start, in each step, on springs whose surface is at `surface` \[m\] below x and y.
    fn pressed<G>(motion: Compliant<G, Wrist>, surface: impl Fn(f64, f64) -> f64) -> Vec<Pose>
    where
        G: Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()>,
    {
        let irp6 = Irp6::nominal();
        let start = irp6.forward(&Irp6::READY);
        let demands = rehearse_with(motion, &irp6, Irp6::READY, DT, |arm| {
            let at = start.inv_mul(&arm.measured().pose);
            let depth = (at.translation.z - surface(at.translation.x, at.translation.y)).max(0.0);
            let push = at.rotation.inverse_transform_vector(&(Vector3::z() * (-STIFFNESS * depth)));
            (Order::new(()), Reading::new((SensorImage::new(Wrench::new(push, Vector3::zeros()), 0),)))
        });
        let pose = |demand: &Demand<Irp6>| {
            let displaced = demand.as_displacement();
            displaced.or_else(|| demand.as_pose().map(|pose| start.inv_mul(&pose))).expect("a pose")
        };
        demands.expect("it ends").iter().map(pose).collect()
    }

    fn line(by: Vector3<f64>) -> ToolOffset<Irp6> {
        let limits = ProfileLimits { velocity: 0.02, acceleration: 0.1 };
        ToolOffset::by(
            Pose::translation(by.x, by.y, by.z),
            ToolLimits { translation: limits, rotation: limits },
        )
    }

    /// On a slope `i` the law has to follow with the velocity `v i`, which takes `v i / b` of the load: `z` is behind by that
    /// over the stiffness. `x` is that of the path itself.
    #[test]
    fn the_path_leads_across_and_the_load_is_kept_on_a_slope_but_for_what_its_damping_takes() {
        let slope = -0.02;
        let travel = pressed(Compliant::by(line(Vector3::x() * 0.1), law(), 1), |x, _| slope * x);
        let (speed, give) = (0.02, Give::FORCE);
        // The middle of the path, long after the oscillation of the first contact.
        let at = travel[travel.len() * 4 / 5].translation;
        let load = STIFFNESS * (at.z - slope * at.x);
        let expected = LOAD - speed * slope / give.reciprocal_damping;
        assert!((load - expected).abs() < 0.01, "{load} {expected}");
        let end = travel[travel.len() - 1].translation;
        assert!((end.x - 0.1).abs() < 1e-12 && end.y.abs() < 1e-12, "{end}");
    }

    /// Turns of the path are about the tip, which stays pressed on the same point of the table.
    #[test]
    fn a_tilt_under_pressure_leaves_the_tip_where_it_is() {
        let limits = JerkLimits { velocity: 0.05, acceleration: 0.5, jerk: 10.0 };
        let search = TiltSearch::within(0.05, 0.02, limits);
        let travel = pressed(Compliant::by(search, law(), 1), |_, _| 0.0);
        let end = travel[travel.len() - 1];
        assert!((end.rotation.angle() - 0.06).abs() < 1e-9, "{end}");
        // It moves across only as far as the axis along which it presses is tilted: by 0.06 of 5 mm at most.
        assert!(end.translation.vector.xy().norm() < 0.06 * 5.1e-3, "{end}");
        let load = STIFFNESS * end.translation.z;
        assert!((load - LOAD).abs() < 0.1, "{load}");
    }

    /// A hole 2 mm beside the tool, 1 mm wide: the spiral finds it, is braked there within 50 ms, and says so.
    #[test]
    fn a_spiral_ends_where_the_tool_falls_in_and_without_a_hole_at_its_radius() {
        let limits = JerkLimits { velocity: 0.01, acceleration: 0.1, jerk: 2.0 };
        let search = || {
            let spiral = SpiralSearch::<Irp6>::over(4e-3, 1e-3, limits);
            Compliant::<_, Wrist>::by(spiral, law(), 1).until(|felt| felt.travel.z > 6.5e-3, 0.05)
        };
        let hole = |x: f64, y: f64| if (x + 1.2e-3).hypot(y - 1.6e-3) < 0.5e-3 { 0.05 } else { 0.0 };
        let found = pressed(search(), hole);
        let end = found[found.len() - 1].translation;
        // Beside the hole by what it goes on: what 0.05 s at 0.01 m/s leave, and the distance in which it sinks by 1.5 mm.
        assert!((end.x + 1.2e-3).hypot(end.y - 1.6e-3) < 2e-3 && end.z > 6.5e-3, "{end}");
        let all = pressed(search(), |_, _| 0.0);
        let end = all[all.len() - 1].translation;
        assert!((end.vector.xy().norm() - 4.5e-3).abs() < 1e-9 && found.len() < all.len() / 2, "{end}");
        // The same, asked in a step.
        let mut search = search();
        assert!(!search.has_found());
        search.start = Some(UnitQuaternion::identity());
        search.travel = Vector3::z() * 7e-3;
        let v = Reading::new((SensorImage::new(Wrench::default(), 0),));
        search.begin(&v, Tick { step: 1, dt: DT, duration: DT }).expect("fresh");
        assert!(search.has_found());
    }

    #[test]
    fn without_a_reading_nothing_moves_and_joint_positions_and_old_readings_are_refused() {
        let irp6 = Irp6::nominal();
        let mut motion = Compliant::<_, Wrist>::by(line(Vector3::x() * 0.1), law(), 1);
        let e = State::new(crate::rehearsal::at_rest(&irp6, Irp6::READY));
        let t = Tick { step: 0, dt: DT, duration: DT };
        let none = Reading::new(<(Wrist,) as mrroc::generator::SensorList>::unknown());
        let first = motion.first_step(&Order::new(()), &e, &none, t);
        assert_eq!(first, Ok(Step::Next(Demand::displacement(Pose::identity()))));
        let stale = Reading::new((SensorImage::new(Wrench::default(), 2),));
        let fault = motion.next_step(&Order::new(()), &e, &stale, t).expect_err("too old");
        assert_eq!(fault.kind(), mrroc::fault::FaultKind::SensorStale);
        let joints = JointMove::<Irp6>::to(Irp6::READY, Six::repeat(1.0), Six::repeat(1.0));
        let mut motion = Compliant::<_, Wrist>::by(joints, law(), 1);
        let fresh = Reading::new((SensorImage::new(Wrench::default(), 0),));
        assert!(motion.first_step(&Order::new(()), &e, &fresh, t).is_err());
    }
}
