//! Two behaviours at once: their velocities, weighted and added.

use mrroc::generator::{Class, Generator, Motion, Uses};
use mrroc::prelude::*;
use mrroc_generators::between::{displacement, moved};
use mrroc_generators::line::ToolLimits;
use nalgebra::Vector3;

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
/// the other one has added. A behaviour that has had weight 1 beside 0 from the beginning, and met no limit, passes its demands unchanged. One that
/// begins anew from `e` during its motion, such as the next of a [`Sequence`](super::Sequence), begins where the sum is: that jump of its own demands is taken
/// for a velocity, within the limits.
///
/// **End.** A behaviour that is done adds nothing more. When all are done that can be, the tool is braked within the limits, and the motion is done.
///
/// All demands must be poses, or all displacements, of one tool that is in force when it begins; `Demand::hold` is a velocity of zero. Redundancy, regulators,
/// outputs and loads are those of the first behaviour; of the second where that is done, or has weight 0 beside 1 while the second does not hold.
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
/// use mrroc_robots::Irp6;
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
/// // Along x by 0.1 m; aside by 0.05 m, as far as the sensor calls for it: half, here.
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let by = |x, y| Blind::<_, (Level,)>::new(ToolOffset::<Irp6>::by(Pose::translation(x, y, 0.0), limits));
/// let weights = |v: &Reading<(Level,)>| [1.0, v.0.reading().map_or(0.0, |slope| slope.share)];
/// let within = ProfileLimits { velocity: 0.2, acceleration: 1.0 };
/// let within = ToolLimits { translation: within, rotation: within };
/// let motion = Superpose::of(by(0.1, 0.0), by(0.0, 0.05), weights, within);
/// let demands = rehearse_with(motion, &Irp6::nominal(), Irp6::READY, 0.002, |_| {
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
        let moved_by = [(to_first, self.first.at), (to_second, self.second.at)]
            .map(|(to, from)| to.map_or([Vector3::zeros(); 2], |to| displacement(&from, &to)));
        let before = [self.first.at, self.second.at];
        self.first.at = to_first.unwrap_or(self.first.at);
        self.second.at = to_second.unwrap_or(self.second.at);
        // Of two that never end, neither is waited for.
        let done = Self::ENDS && (self.first.done || !A::ENDS) && (self.second.done || !B::ENDS);
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
            let sum = (moved_by[0][axis] * weights[0] + moved_by[1][axis] * weights[1]) / t.dt;
            let wanted = if done { Vector3::zeros() } else { sum.cap_magnitude(limit.velocity) };
            let change = wanted - velocity[axis];
            // A velocity found by differences of places has rounding in it, which is no acceleration.
            let most = limit.acceleration * t.dt + ROUNDING / t.dt;
            limited |= wanted != sum || change.norm() > most;
            velocity[axis] += change.cap_magnitude(most);
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
            None => moved(&self.at, velocity.map(|v| v * t.dt)),
        };
        Ok(Step::Next(self.led(same)))
    }

    /// A demand of a behaviour, led to where the sum is.
    fn led(&self, demand: Demand<R>) -> Demand<R> {
        let theirs = demand.as_pose().or_else(|| demand.as_displacement());
        match (theirs, self.relative) {
            (Some(theirs), _) if theirs == self.at => demand,
            (Some(theirs), _) => demand
                .moved_in_tool(&theirs.inv_mul(&self.at))
                .unwrap_or_else(|| demand.led_to(&self.there())),
            (None, Some(_)) => demand.led_to(&self.there()),
            (None, None) => demand,
        }
    }

    /// Where the sum is.
    fn there(&self) -> Demand<R> {
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
mod tests;
