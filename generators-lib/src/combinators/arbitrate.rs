//! The behaviour that matters most at the moment, of a list by priority.

use mrroc::generator::{Class, Generator, Uses};
use mrroc::prelude::*;

use crate::braked::Braked;

/// Two behaviours, of which one is preferred: it takes over when its condition on the readings begins to hold, and gives back when
/// another one ends it. Between the two conditions nothing changes, so that noise about a threshold does not hand the robot to and fro
/// (hysteresis). More than two are a list by priority: the usual behaviour is an `Arbitrate` itself.
///
/// The robot is handed over at rest: the behaviour that runs is braked *on its path* by taking its path time away within a given
/// time, and then the other one is made anew and begins from where the robot stands. A behaviour is given as what makes it, because it
/// may begin many times; what makes it runs in a step, so it must not allocate. The motion is done when the behaviour that runs is
/// done; one that is to give back must go on until then.
///
/// Behaviours that begin with the velocity that they find need no rest between them: [`in_motion`](Self::in_motion) hands over in the
/// very step. So a tool that goes with a part on a belt is handed over without losing it.
///
/// This is subsumption with priorities fixed beforehand (Brooks, *A robust layered control system for a mobile robot*, 1986). Where a
/// behaviour is to take over once, and for good, [`Override`](super::Override) does.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::combinators::{Arbitrate, Blind};
/// use mrroc_generators::generators::{Sleep, StraightLine};
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
///
/// # #[derive(Clone, Copy, Debug, PartialEq, Payload)]
/// # struct Distance {
/// #     to_person: f64,
/// # }
/// # struct Scanner;
/// # impl Sensor for Scanner {
/// #     const KIND: &'static str = "scanner";
/// #     type Reading = Distance;
/// #     type Configuration = ();
/// # }
/// # let irp6 = Irp6::nominal();
/// // To the goal; from where somebody is nearer than 1 m until they are 1.2 m away it stands, braked within 0.1 s.
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let goal = irp6.forward(&Irp6::READY) * Pose::translation(0.0, 0.0, -0.05);
/// let nearer = |v: &Reading<(Scanner,)>| v.0.reading().is_some_and(|seen| seen.to_person < 1.0);
/// let away = |v: &Reading<(Scanner,)>| v.0.reading().is_some_and(|seen| seen.to_person > 1.2);
/// let stand = || Blind::new(Sleep::lasting(f64::INFINITY));
/// let go = move || Blind::new(StraightLine::to(goal, limits));
/// let motion = Arbitrate::of(stand, nearer, away, 0.1, go);
/// // Somebody is near from 0.3 s to 1 s. It stands from 0.4 s, when it is braked, to 1.1 s: what stands is braked, too.
/// let mut step = 0;
/// let demands = rehearse_with(motion, &irp6, Irp6::READY, 0.002, |_| {
///     step += 1;
///     let to_person = if (150..500).contains(&step) { 0.9 } else { 1.3 };
///     (Order::new(()), Reading::new((SensorImage::new(Distance { to_person }, 0),)))
/// })?;
/// let stood = demands.iter().filter(|demand| **demand == Demand::hold()).count();
/// assert!((349..=351).contains(&stood), "{stood}");
/// assert_eq!(demands.last().and_then(Demand::as_pose), Some(goal));
/// # Ok::<(), Fault>(())
/// ```
pub struct Arbitrate<A: Generator, B, MakeA, MakeB> {
    preferred: MakeA,
    usual: MakeB,
    begins: fn(&Reading<A::Sensors>) -> bool,
    ends: fn(&Reading<A::Sensors>) -> bool,
    /// \[s\]; `None`: none, the behaviours begin with the velocity that they find.
    braking: Option<f64>,
    /// Whether the preferred behaviour is to run.
    chosen: bool,
    running: Option<Running<A, B>>,
    /// While the running behaviour is braked.
    braked: Option<Braked>,
}

enum Running<A, B> {
    Preferred(A),
    Usual(B),
}

impl<A, B, MakeA, MakeB> Arbitrate<A, B, MakeA, MakeB>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
    MakeA: FnMut() -> A,
    MakeB: FnMut() -> B,
{
    /// What `preferred` makes, from where `begins` holds until `ends` does, and else what `usual` makes. What hands over is braked
    /// within `braking` \[s\], finite, > 0: at a speed `v` that is a deceleration of `1.5 v / braking` and a jerk of
    /// `4.5 v / braking²` at most, besides what the path itself takes.
    #[must_use]
    pub fn of(
        preferred: MakeA,
        begins: fn(&Reading<A::Sensors>) -> bool,
        ends: fn(&Reading<A::Sensors>) -> bool,
        braking: f64,
        usual: MakeB,
    ) -> Self {
        Self::handing_over(preferred, begins, ends, Some(braking), usual)
    }

    /// The same, without braking: the one that takes over begins in the step in which it is chosen, and must go on with the velocity
    /// that it finds. One that does not is refused by the limits of the robot.
    #[must_use]
    pub fn in_motion(
        preferred: MakeA,
        begins: fn(&Reading<A::Sensors>) -> bool,
        ends: fn(&Reading<A::Sensors>) -> bool,
        usual: MakeB,
    ) -> Self {
        Self::handing_over(preferred, begins, ends, None, usual)
    }

    fn handing_over(
        preferred: MakeA,
        begins: fn(&Reading<A::Sensors>) -> bool,
        ends: fn(&Reading<A::Sensors>) -> bool,
        braking: Option<f64>,
        usual: MakeB,
    ) -> Self {
        const { assert!(A::CLASS.level as u8 == B::CLASS.level as u8, "both of an MP, or both of an ECP") };
        Arbitrate { preferred, usual, begins, ends, braking, chosen: false, running: None, braked: None }
    }

    /// Chooses by the readings.
    fn choose(&mut self, v: &Reading<A::Sensors>) {
        self.chosen = if self.chosen { !(self.ends)(v) } else { (self.begins)(v) };
    }

    /// Makes the chosen behaviour, and its first step.
    fn begin(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        self.braked = None;
        if self.chosen {
            let mut preferred = (self.preferred)();
            let step = preferred.first_step(c0, e, v, t);
            self.running = Some(Running::Preferred(preferred));
            return step;
        }
        let mut usual = (self.usual)();
        let step = usual.first_step(c0, e, v, t);
        self.running = Some(Running::Usual(usual));
        step
    }
}

impl<A, B, MakeA, MakeB> Generator for Arbitrate<A, B, MakeA, MakeB>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
    MakeA: FnMut() -> A,
    MakeB: FnMut() -> B,
{
    type Robots = A::Robots;
    type Language = A::Language;
    type Sensors = A::Sensors;
    type Order = A::Order;
    const CLASS: Class = {
        let a = A::CLASS;
        let b = B::CLASS;
        let own = Uses { sensors: true, ..Uses::NOTHING };
        let first = a.first_uses().and(b.first_uses()).and(own);
        // Both may begin in any step.
        let next = first.and(a.next_uses()).and(b.next_uses()).and(Uses { tick: true, ..Uses::NOTHING });
        Class { level: a.level, first, next, until: None }
    };
    const ENDS: bool = A::ENDS || B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        if self.braking.is_some_and(|braking| !Braked::is_possible(braking)) {
            return Err(Fault::thrown("the time in which a behaviour is braked must be finite and > 0"));
        }
        self.choose(v);
        self.begin(c0, e, v, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        self.choose(v);
        let stands = self.braked.as_ref().is_some_and(Braked::stands);
        let Some(running) = self.running.as_mut().filter(|_| !stands) else {
            return self.begin(c0, e, v, t);
        };
        let is_chosen = matches!(running, Running::Preferred(_)) == self.chosen;
        let Some(braking) = self.braking else {
            if !is_chosen {
                return self.begin(c0, e, v, t);
            }
            return match running {
                Running::Preferred(preferred) => preferred.next_step(c0, e, v, t),
                Running::Usual(usual) => usual.next_step(c0, e, v, t),
            };
        };
        // Once begun, braking goes on to rest, whatever is chosen meanwhile: no behaviour can speed up again where it was.
        if !is_chosen && self.braked.is_none() {
            self.braked = Some(Braked::within(braking));
        }
        let share = self.braked.as_mut().map_or(1.0, |braked| braked.share(t.dt));
        let t = Tick { dt: t.dt * share, ..t };
        match running {
            Running::Preferred(preferred) => preferred.next_step(c0, e, v, t),
            Running::Usual(usual) => usual.next_step(c0, e, v, t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Blind;
    use super::*;
    use crate::generators::{Sleep, StraightLine};
    use crate::line::ToolLimits;
    use crate::profile::ProfileLimits;
    use mrroc::generator::Motion;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};

    #[derive(Clone, Copy, Debug, PartialEq, Payload)]
    struct Distance {
        to_person: f64,
    }

    struct Scanner;

    impl Sensor for Scanner {
        const KIND: &'static str = "scanner";
        type Reading = Distance;
        type Configuration = ();
    }

    const DT: f64 = 2e-3;
    const BRAKING: f64 = 0.1;

    fn to(x: f64) -> Blind<StraightLine<Irp6>, (Scanner,)> {
        let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        Blind::new(StraightLine::to(Pose::translation(x, 0.0, 0.0), limits))
    }

    fn nearer(than: f64, v: &Reading<(Scanner,)>) -> bool {
        v.0.reading().is_some_and(|seen| seen.to_person < than)
    }

    /// Where the tool is demanded to be along x in each step, and whether the motion is done.
    fn run<G>(mut generator: G, steps: u64, to_person: impl Fn(u64) -> f64) -> (Vec<f64>, bool)
    where
        G: Generator<Robots = Irp6, Language = Motion, Sensors = (Scanner,), Order = ()>,
    {
        let mut pose = Pose::identity();
        let mut trace = vec![0.0; 2];
        for step in 0..steps {
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
            let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
            let v = Reading::new((SensorImage::new(Distance { to_person: to_person(step) }, 0),));
            let t = Tick { step, dt: DT, duration: DT };
            let stepped = if step == 0 {
                generator.first_step(&c0, &e, &v, t)
            } else {
                generator.next_step(&c0, &e, &v, t)
            };
            let Step::Next(demand) = stepped.expect("in range") else { return (trace, true) };
            pose = demand.as_pose().unwrap_or(pose);
            trace.push(pose.translation.x);
        }
        (trace, false)
    }

    fn accelerations(trace: &[f64]) -> impl Iterator<Item = f64> {
        trace.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]) / (DT * DT))
    }

    #[test]
    fn it_is_handed_over_at_rest_as_often_as_the_readings_say_and_arrives() {
        // Out of the way to x = -0.1 while somebody is near; else to x = 0.3.
        let out = || to(-0.1);
        let motion = Arbitrate::of(out, |v| nearer(1.0, v), |v| !nearer(1.2, v), BRAKING, || to(0.3));
        // Near in steps 400..600 and 1400..1700: 0.8 s, in which it has come 0.06 m of them, and so on.
        let near = |step| (400..600).contains(&step) || (1400..1700).contains(&step);
        let (trace, done) = run(motion, 10_000, |step| if near(step) { 0.9 } else { 1.3 });
        assert!(done);
        assert!((trace[trace.len() - 1] - 0.3).abs() < 1e-12);
        // The lines take 0.5 m/s², and braking 0.1 m/s within 0.1 s takes 1.5 m/s², on top of which a line may speed up or slow down.
        let most = accelerations(&trace).map(f64::abs).fold(0.0, f64::max);
        assert!(most < 1.5 + 0.5 + 1e-6, "{most}");
        // It turned back four times: the velocity changes its sign so often.
        let moves: Vec<_> = trace.windows(2).map(|x| x[1] - x[0]).filter(|x| x.abs() > 1e-12).collect();
        let turns = moves.windows(2).filter(|x| x[0] * x[1] < 0.0).count();
        assert_eq!(turns, 4);
    }

    #[test]
    fn noise_about_the_threshold_hands_over_once() {
        // The readings of a person at 1 m scatter by 5 cm about it: each crosses the first threshold, none the second.
        let (stand, go) = (|| Blind::new(Sleep::lasting(f64::INFINITY)), || to(0.3));
        let motion = Arbitrate::of(stand, |v| nearer(1.0, v), |v| !nearer(1.2, v), BRAKING, go);
        let noisy = |step: u64| 1.0 + if step.is_multiple_of(2) { 0.05 } else { -0.05 };
        let (trace, done) = run(motion, 3_000, noisy);
        assert!(!done);
        // It goes for one step, and is braked within 50.
        assert!(trace.windows(2).skip(60).all(|x| x[0].to_bits() == x[1].to_bits()), "it stands for good");
    }

    #[test]
    fn the_first_of_a_list_that_wants_to_has_the_robot() {
        // Nearer than 0.5 m: out of the way; nearer than 1 m: stand; else go.
        let list = || {
            let stand = || Blind::new(Sleep::lasting(f64::INFINITY));
            let rest =
                move || Arbitrate::of(stand, |v| nearer(1.0, v), |v| !nearer(1.2, v), BRAKING, || to(0.3));
            Arbitrate::of(|| to(-0.1), |v| nearer(0.5, v), |v| !nearer(0.6, v), BRAKING, rest)
        };
        // All the time one distance: out, stood, gone.
        for (distance, end) in [(0.4, Some(-0.1)), (0.8, None), (1.5, Some(0.3))] {
            let (trace, done) = run(list(), 5_000, |_| distance);
            assert_eq!(done, end.is_some(), "{distance}");
            assert!((trace[trace.len() - 1] - end.unwrap_or(0.0)).abs() < 1e-12, "{distance}");
        }
        // One after the other, and back.
        let distance = |step| [1.5, 0.8, 0.4, 0.8, 1.5][(step as usize / 400).min(4)];
        let (trace, done) = run(list(), 10_000, distance);
        assert!(done && (trace[trace.len() - 1] - 0.3).abs() < 1e-12);
        assert!(accelerations(&trace).all(|a| a.abs() < 1.5 + 0.5 + 1e-6));
    }

    #[test]
    fn what_hands_over_is_braked_within_a_jerk() {
        // Both go on at 0.1 m/s, from rest and at once; braked within 0.2 s that takes 4.5 v / T² = 11.25 m/s³.
        let ahead = || Blind::<_, (Scanner,)>::new(Steady { velocity: 0.1, x: 0.0 });
        let away = || Blind::new(Sleep::lasting(f64::INFINITY));
        let motion = Arbitrate::of(away, |v| nearer(1.0, v), |v| !nearer(1.2, v), 0.2, ahead);
        let (trace, _) = run(motion, 600, |step| if step > 300 { 0.9 } else { 1.3 });
        let jerk = |x: &[f64]| (x[3] - 3.0 * x[2] + 3.0 * x[1] - x[0]).abs() / DT.powi(3);
        let most = trace[10..].windows(4).map(jerk).fold(0.0, f64::max);
        assert!((11.0..11.25 + 1e-4).contains(&most), "{most}");
        assert!(trace.windows(2).skip(420).all(|x| x[0].to_bits() == x[1].to_bits()), "it stands");
    }

    struct Steady {
        velocity: f64,
        x: f64,
    }

    #[generator(ecp)]
    impl Steady {
        fn first_step(&mut self, t: Tick) -> Step<Irp6> {
            self.next_step(t)
        }

        fn next_step(&mut self, t: Tick) -> Step<Irp6> {
            self.x += self.velocity * t.dt;
            Step::Next(Demand::pose(Pose::translation(self.x, 0.0, 0.0)))
        }
    }

    /// Goes on at a velocity that it approaches from whatever it finds, which it is told.
    struct Towards {
        found: std::rc::Rc<core::cell::Cell<f64>>,
        velocity: f64,
        x: f64,
    }

    #[generator(ecp)]
    impl Towards {
        fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
            self.x = e.demanded().pose.translation.x;
            self.next_step(t)
        }

        fn next_step(&mut self, t: Tick) -> Step<Irp6> {
            let change = 0.5 * t.dt;
            let velocity = self.found.get() + (self.velocity - self.found.get()).clamp(-change, change);
            self.found.set(velocity);
            self.x += velocity * t.dt;
            Step::Next(Demand::pose(Pose::translation(self.x, 0.0, 0.0)))
        }
    }

    #[test]
    fn behaviours_that_go_on_with_what_they_find_are_handed_over_in_motion() {
        let found = std::rc::Rc::new(core::cell::Cell::new(0.0));
        let towards = |velocity: f64| {
            let found = std::rc::Rc::clone(&found);
            move || {
                Blind::<_, (Scanner,)>::new(Towards { found: std::rc::Rc::clone(&found), velocity, x: 0.0 })
            }
        };
        let motion =
            Arbitrate::in_motion(towards(-0.05), |v| nearer(1.0, v), |v| !nearer(1.2, v), towards(0.1));
        let (trace, done) = run(motion, 1_000, |step| if (400..600).contains(&step) { 0.9 } else { 1.3 });
        assert!(!done);
        // It turns back once and forth once, and at no time within more than 0.5 m/s².
        assert!(accelerations(&trace).skip(1).all(|a| a.abs() < 0.5 + 1e-6));
        let speed = |step: usize| (trace[step + 1] - trace[step]) / DT;
        assert!(
            (speed(390) - 0.1).abs() < 1e-9 && (speed(599) + 0.05).abs() < 1e-9,
            "{} {}",
            speed(390),
            speed(599)
        );
        assert!((speed(990) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn a_time_of_braking_that_is_none_is_refused() {
        for braking in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut motion = Arbitrate::of(|| to(0.1), |_| true, |_| false, braking, || to(0.3));
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
            let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
            let v = Reading::new((SensorImage::new(Distance { to_person: 1.0 }, 0),));
            assert!(motion.first_step(&c0, &e, &v, Tick { step: 0, dt: DT, duration: DT }).is_err());
        }
    }
}
