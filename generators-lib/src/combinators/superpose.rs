//! Two behaviours at once: their velocities, weighted and added.

use mrroc::generator::{Class, Generator, Motion, Uses};
use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::line::ToolLimits;

/// Two behaviours that move the tool together: the velocity of the tool is the weighted sum of theirs (cooperative, where
/// [`Arbitrate`](super::Arbitrate) is competitive). The weights are functions of the readings. More than two are superposed in pairs: a
/// behaviour may be a `Superpose` itself.
///
/// ```text
/// v_i = difference of two demands of behaviour i / dt        translation, and rotation about fixed axes
/// v   = w_A v_A + w_B v_B                                    within the limits of the sum; the tool goes on by v dt
/// ```
///
/// **Limits of the sum.** A sum that is too fast is slowed down as a whole: its direction stays, translation and rotation apart. A velocity that
/// would change too fast changes as fast as it may. So the velocity has no step, even where a weight jumps, or goes to zero, and
/// hands the tool over to the other behaviour. What is cut off is not made up for. Limits of joints are checked where all demands are.
///
/// **Where it leads.** A behaviour that does not read `e` goes on along its own motion as if it were alone, so the tool comes to its end plus what
/// the other one has added. As long as one behaviour has weight 1, the other one 0, and no limit acts, its demands pass unchanged.
///
/// **End.** A behaviour that is done adds nothing more. When all are done that can be, the tool is braked within the limits, and the motion is done.
///
/// All demands must be poses, or all displacements; `Demand::hold` is a velocity of zero. Tool, redundancy, regulators, outputs and loads are those of the first
/// behaviour; of the second where that is done or has weight 0 beside 1.
///
/// This is the cooperative composition of transfer functions that the paper's later formalism has beside the competitive one, and of potential
/// fields (Arkin, *Motor schema-based mobile robot navigation*, 1989).
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::combinators::{Blind, Superpose};
/// use mrroc_generators::generators::ToolOffset;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::{Irp6, Six};
///
/// # #[derive(Clone, Copy, Debug, PartialEq, Payload)]
/// # struct Slope {
/// #     share: f64,
/// # }
/// # struct Level;
/// # impl Sensor for Level {
/// #     const KIND: &'static str = "level";
/// #     type Reading = Slope;
/// #     type Configuration = ();
/// # }
/// # let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
/// // Along x by 0.1 m; aside by 0.05 m, as far as the sensor calls for it: half, here.
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let by = |x, y| Blind::<_, (Level,)>::new(ToolOffset::<Irp6>::by(Pose::translation(x, y, 0.0), limits));
/// let weights = |v: &Reading<(Level,)>| [1.0, v.0.reading().map_or(0.0, |slope| slope.share)];
/// let within = ProfileLimits { velocity: 0.2, acceleration: 1.0 };
/// let within = ToolLimits { translation: within, rotation: within };
/// let motion = Superpose::of(by(0.1, 0.0), by(0.0, 0.05), weights, within);
/// let demands = rehearse_with(motion, &Irp6::nominal(), start, 0.002, |_| {
///     (Order::new(()), Reading::new((SensorImage::new(Slope { share: 0.5 }, 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_displacement).map(|end| end.translation.vector);
/// assert!(end.is_some_and(|end| (end - nalgebra::Vector3::new(0.1, 0.025, 0.0)).norm() < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct Superpose<A: Generator, B: Generator> {
    first: Part<A>,
    second: Part<B>,
    weigh: fn(&Reading<A::Sensors>) -> [f64; 2],
    limits: ToolLimits,
    /// Whether poses are displacements; `None` before the first of them.
    relative: Option<bool>,
    start: Pose,
    at: Pose,
    velocity: [Vector3<f64>; 2],
}

/// A behaviour, and where its last demand was.
struct Part<G> {
    generator: G,
    at: Pose,
    done: bool,
}

impl<A, B> Superpose<A, B>
where
    A: Generator<Language = Motion>,
    B: Generator<Robots = A::Robots, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
{
    /// What `first` and `second` do together, each by its weight: `weigh` says them in every step, finite. The sum stays within `limits`, all
    /// finite and > 0. The tool is at rest when it begins.
    #[must_use]
    pub fn of(first: A, second: B, weigh: fn(&Reading<A::Sensors>) -> [f64; 2], limits: ToolLimits) -> Self {
        const { assert!(A::CLASS.level as u8 == B::CLASS.level as u8, "both of an MP, or both of an ECP") };
        let (at, still) = (Pose::identity(), Vector3::zeros());
        Self {
            first: Part { generator: first, at, done: false },
            second: Part { generator: second, at, done: false },
            weigh,
            limits,
            relative: None,
            start: at,
            at,
            velocity: [still; 2],
        }
    }
}

/// From one pose to another: along and about fixed axes.
fn way(from: &Pose, to: &Pose) -> [Vector3<f64>; 2] {
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    [to.translation.vector - from.translation.vector, turn]
}

fn within(vector: Vector3<f64>, most: f64) -> Vector3<f64> {
    let norm = vector.norm();
    if norm > most { vector * (most / norm) } else { vector }
}

impl<A, B, R> Superpose<A, B>
where
    A: Generator<Robots = R, Language = Motion>,
    B: Generator<Robots = R, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
    R: Robot,
{
    /// Where a demand leads; `None` of one that holds.
    fn place(&mut self, demand: &Demand<R>) -> Result<Option<Pose>, Fault> {
        let (place, relative) = match (demand.as_pose(), demand.as_displacement()) {
            (Some(pose), _) => (pose, false),
            (_, Some(displacement)) => (displacement, true),
            _ if demand.as_joints().is_none() => return Ok(None),
            _ => {
                return Err(Fault::thrown(
                    "only poses and displacements can be superposed, no joint positions",
                ));
            }
        };
        match self.relative {
            Some(known) if known != relative => {
                return Err(Fault::thrown(
                    "poses and displacements cannot be superposed: demand one of them",
                ));
            }
            Some(_) => {}
            None => {
                self.relative = Some(relative);
                let begin = if relative { Pose::identity() } else { self.start };
                (self.at, self.first.at, self.second.at) = (begin, begin, begin);
            }
        }
        Ok(Some(place))
    }

    fn superposed(
        &mut self,
        steps: [Step<R>; 2],
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let [first, second] = steps.map(|step| match step {
            Step::Next(demand) => Some(demand),
            Step::Done => None,
        });
        let places = [&first, &second].map(|demand| demand.as_ref().map(|d| self.place(d)));
        let [to_first, to_second] = places.map(|place| place.transpose().map(Option::flatten));
        let (to_first, to_second) = (to_first?, to_second?);
        self.first.done |= first.is_none();
        self.second.done |= second.is_none();
        let weights = (self.weigh)(v);
        if !weights.iter().all(|weight| weight.is_finite()) {
            return Err(Fault::thrown("the weights of superposed behaviours must be finite"));
        }
        let ways = [(to_first, self.first.at), (to_second, self.second.at)]
            .map(|(to, from)| to.map_or([Vector3::zeros(); 2], |to| way(&from, &to)));
        let before = [self.first.at, self.second.at];
        self.first.at = to_first.unwrap_or(self.first.at);
        self.second.at = to_second.unwrap_or(self.second.at);
        let done = (self.first.done || !A::ENDS) && (self.second.done || !B::ENDS);
        // What goes along with the place: of the first, unless it is done or the second alone leads.
        let of_second = self.first.done || weights == [0.0, 1.0] && to_second.is_some();
        let same = if of_second { second } else { first }.unwrap_or_else(Demand::hold);
        if t.dt <= 0.0 || self.relative.is_none() {
            let moved = self.relative.is_some();
            return Ok(if done && !moved { Step::Done } else { Step::Next(self.led(same)) });
        }
        let limits = [self.limits.translation, self.limits.rotation];
        let mut limited = false;
        let mut velocity = self.velocity;
        for (axis, limit) in limits.into_iter().enumerate() {
            let sum = (ways[0][axis] * weights[0] + ways[1][axis] * weights[1]) / t.dt;
            let wanted = if done { Vector3::zeros() } else { within(sum, limit.velocity) };
            let change = wanted - velocity[axis];
            // A velocity found by differences of places has rounding in it, which is no acceleration.
            let most = limit.acceleration * t.dt + ROUNDING / t.dt;
            limited |= wanted != sum || change.norm() > most;
            velocity[axis] += within(change, most);
        }
        if done && self.velocity.iter().zip(limits).all(|(v, limit)| v.norm() <= limit.acceleration * t.dt) {
            return Ok(Step::Done);
        }
        self.velocity = velocity;
        // One alone that has not been led aside: to the bit.
        let alone = match weights {
            [1.0, 0.0] => Some((before[0], self.first.at)),
            [0.0, 1.0] => Some((before[1], self.second.at)),
            _ => None,
        };
        self.at = match alone.filter(|(from, _)| !limited && *from == self.at) {
            Some((_, to)) => to,
            None => {
                let [along, about] = velocity.map(|v| v * t.dt);
                let mut rotation = UnitQuaternion::from_scaled_axis(about) * self.at.rotation;
                rotation.renormalize_fast();
                Pose::from_parts(Translation3::from(self.at.translation.vector + along), rotation)
            }
        };
        Ok(Step::Next(self.led(same)))
    }

    /// A demand of a behaviour, led to where the sum is.
    fn led(&self, demand: Demand<R>) -> Demand<R> {
        let theirs = demand.as_pose().or_else(|| demand.as_displacement());
        match (theirs, self.relative) {
            (Some(theirs), _) if theirs == self.at => demand,
            (Some(theirs), _) => {
                demand.moved_in_tool(&theirs.inv_mul(&self.at)).unwrap_or_else(|| self.plain())
            }
            (None, Some(_)) => self.plain(),
            (None, None) => demand,
        }
    }

    fn plain(&self) -> Demand<R> {
        if self.relative == Some(true) { Demand::displacement(self.at) } else { Demand::pose(self.at) }
    }
}

/// Places are known to this \[m or rad\].
const ROUNDING: f64 = 1e-15;

impl<A, B, R> Generator for Superpose<A, B>
where
    A: Generator<Robots = R, Language = Motion>,
    B: Generator<Robots = R, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
    R: Robot,
{
    type Robots = R;
    type Language = Motion;
    type Sensors = A::Sensors;
    type Order = A::Order;
    const CLASS: Class = {
        let (a, b) = (A::CLASS, B::CLASS);
        let own = Uses { sensors: true, tick: true, ..Uses::NOTHING };
        let first = a.first_uses().and(b.first_uses()).and(own).and(Uses { state: true, ..Uses::NOTHING });
        let next = a.next_uses().and(b.next_uses()).and(own);
        Class { level: a.level, first, next, until: None }
    };
    const ENDS: bool = A::ENDS || B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<R>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let ToolLimits { translation, rotation } = self.limits;
        let all = [translation.velocity, translation.acceleration, rotation.velocity, rotation.acceleration];
        if !all.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(Fault::thrown("the limits of superposed behaviours must be finite and > 0"));
        }
        self.start = e.demanded().pose;
        let steps =
            [self.first.generator.first_step(c0, e, v, t)?, self.second.generator.first_step(c0, e, v, t)?];
        self.superposed(steps, v, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<R>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let steps = [self.first.next_step(c0, e, v, t)?, self.second.next_step(c0, e, v, t)?];
        self.superposed(steps, v, t)
    }
}

impl<G: Generator> Part<G> {
    /// Its next step; one that is done stays so.
    fn next_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<G::Robots>,
        v: &Reading<G::Sensors>,
        t: Tick,
    ) -> Result<Step<G::Robots, G::Language>, Fault> {
        if self.done { Ok(Step::Done) } else { self.generator.next_step(c0, e, v, t) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Blind;
    use super::*;
    use crate::generators::ToolOffset;
    use crate::profile::ProfileLimits;
    use mrroc::robot::{RobotImage, RobotState};
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
        all.windows(2).map(|pair| way(&pair[0], &pair[1]).map(|way| way / DT)).collect()
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
}
