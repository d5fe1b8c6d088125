//! Motions of single robots as one motion of the MP.

mod joined;

use crate::model::class::{Class, Level, Uses};
use crate::model::demand::Demand;
use crate::model::fault::Fault;
use crate::model::generator::Generator;
use crate::model::list::{Motion, Reading, State};
use crate::model::payload::Order;
use crate::model::robot::Robot;
use crate::model::step::{Step, Tick};

pub use joined::{Joined, Repeated};

/// One motion of the MP for several robots, of one generator for each robot: any that an ECP moves its robot with.
///
/// All begin in the same step and share its path time. A motion that is done holds its robot until the last one is done;
/// `Each` is done then. The motions are a tuple of at most four, for the tuple of their robots, or an array for an array of
/// robots of one kind. They take no orders. Their sensors are a list, too: those of the first motion, then those of the second,
/// and so on, at most four; for an array of motions with one sensor each, an array.
///
/// The robots have no programs of their own: their ECPs are transparent. For one robot there is
/// [`Mp::move_robot`](crate::program::Mp::move_robot).
///
/// ```
/// use mrroc::generator::Each;
/// use mrroc::prelude::*;
/// # use mrroc_core as mrroc;
/// # fn robots() {}
///
/// /// Moves a robot on by 1 mm in a second.
/// struct Creep<R>(core::marker::PhantomData<R>, f64);
///
/// #[generator(ecp)]
/// fn creep<R: Robot>(c: &mut Creep<R>, t: Tick) -> Step<R> {
///     c.1 += t.dt;
///     if c.1 > 1.0 {
///         return Step::Done;
///     }
///     Step::Next(Demand::displacement(Pose::translation(1e-3 * c.1, 0.0, 0.0)))
/// }
///
/// /// Moves two robots of whatever kinds at once.
/// fn both<A: Robot, B: Robot>(mp: &mut Mp, a: &mut mrroc::generator::RobotHandle<A>, b: &mut mrroc::generator::RobotHandle<B>) -> Result<(), Fault> {
///     let creep_of_a = Creep(core::marker::PhantomData::<A>, 0.0);
///     let creep_of_b = Creep(core::marker::PhantomData::<B>, 0.5);
///     mp.move_robots((a, b), (), Each::of((creep_of_a, creep_of_b))).map(drop)
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Each<G> {
    /// The motions, in the order of their robots.
    pub motions: G,
    /// Those that are done, a bit each.
    done: u64,
}

impl<G> Each<G> {
    /// The motions of the robots of a list, in its order.
    #[must_use]
    pub const fn of(motions: G) -> Self {
        Each { motions, done: 0 }
    }

    const fn is_done(&self, i: usize) -> bool {
        self.done >> i & 1 == 1
    }

    /// What robot `i` is told by a step of its motion: to hold, from where it is done.
    fn told<R: Robot>(&mut self, i: usize, step: Step<R>) -> Demand<R> {
        match step {
            Step::Next(demand) => demand,
            Step::Done => {
                self.done |= 1 << i;
                Demand::hold()
            }
        }
    }

    /// The step of all robots, of which there are `count`.
    const fn step<D>(&self, count: u32, demands: D) -> Option<D>
    where
        D: Copy,
    {
        if self.done.count_ones() == count { None } else { Some(demands) }
    }
}

/// The class of motions that these two are parts of.
const fn class(a: Class, b: Class) -> Class {
    // Which of them is done is a state of the coordinator.
    let state = Uses { state: true, ..Uses::NOTHING };
    let first = a.first_uses().and(b.first_uses()).and(state);
    let next = a.next_uses().and(b.next_uses()).and(state);
    Class { level: Level::Mp, first, next, until: None }
}

type One<A> = <A as Generator>::Sensors;
type Two<A, B> = <One<A> as Joined<One<B>>>::All;
type Three<A, B, C> = <Two<A, B> as Joined<One<C>>>::All;
type Four<A, B, C, D> = <Three<A, B, C> as Joined<One<D>>>::All;

/// `Each` for a tuple: generators, robots, places, readings and demands; the list of all sensors; what it asks of them; how the
/// reading of all sensors becomes those of the motions.
macro_rules! each {
    ($count:literal: $($G:ident $R:ident $i:tt $v:ident $demand:ident),+; $sensors:ty; [$($bound:tt)*]; |$all:ident| $split:block) => {
        impl<$($G, $R),+> Generator for Each<($($G,)+)>
        where
            $($G: Generator<Robots = $R, Language = Motion, Order = ()>, $R: Robot,)+
            $($bound)*
        {
            type Robots = ($($R,)+);
            type Language = Motion;
            type Sensors = $sensors;
            type Order = ();
            const CLASS: Class = {
                let mut all = Class::new(Level::Mp, Uses::NOTHING);
                $(all = class(all, $G::CLASS);)+
                all
            };
            const ENDS: bool = $($G::ENDS)&&+;

            fn first_step(
                &mut self,
                c0: &Order<()>,
                e: &State<Self::Robots>,
                $all: &Reading<Self::Sensors>,
                t: Tick,
            ) -> Result<Step<Self::Robots>, Fault> {
                let ($($v,)+) = $split;
                $(
                    let step = self.motions.$i.first_step(c0, &State::new(e.$i), &$v, t)?;
                    let $demand = self.told($i, step);
                )+
                Ok(self.step($count, ($($demand,)+)).map_or(Step::Done, Step::Next))
            }

            fn next_step(
                &mut self,
                c0: &Order<()>,
                e: &State<Self::Robots>,
                $all: &Reading<Self::Sensors>,
                t: Tick,
            ) -> Result<Step<Self::Robots>, Fault> {
                let ($($v,)+) = $split;
                $(
                    let $demand = if self.is_done($i) {
                        Demand::hold()
                    } else {
                        let step = self.motions.$i.next_step(c0, &State::new(e.$i), &$v, t)?;
                        self.told($i, step)
                    };
                )+
                Ok(self.step($count, ($($demand,)+)).map_or(Step::Done, Step::Next))
            }
        }
    };
}

each! {
    1: A Ra 0 a of_a; One<A>; []; |all| { (Reading::<One<A>>::new(**all),) }
}
each! {
    2: A Ra 0 a of_a, B Rb 1 b of_b; Two<A, B>; [One<A>: Joined<One<B>>,];
    |all| { <One<A> as Joined<One<B>>>::split(all) }
}
each! {
    3: A Ra 0 a of_a, B Rb 1 b of_b, C Rc 2 c of_c; Three<A, B, C>;
    [One<A>: Joined<One<B>>, Two<A, B>: Joined<One<C>>,];
    |all| {
        let (ab, c) = <Two<A, B> as Joined<One<C>>>::split(all);
        let (a, b) = <One<A> as Joined<One<B>>>::split(&ab);
        (a, b, c)
    }
}
each! {
    4: A Ra 0 a of_a, B Rb 1 b of_b, C Rc 2 c of_c, D Rd 3 d of_d; Four<A, B, C, D>;
    [One<A>: Joined<One<B>>, Two<A, B>: Joined<One<C>>, Three<A, B, C>: Joined<One<D>>,];
    |all| {
        let (abc, d) = <Three<A, B, C> as Joined<One<D>>>::split(all);
        let (ab, c) = <Two<A, B> as Joined<One<C>>>::split(&abc);
        let (a, b) = <One<A> as Joined<One<B>>>::split(&ab);
        (a, b, c, d)
    }
}

impl<G, R, const N: usize> Generator for Each<[G; N]>
where
    G: Generator<Robots = R, Language = Motion, Order = ()>,
    G::Sensors: Repeated<N>,
    R: Robot,
{
    type Robots = [R; N];
    type Language = Motion;
    type Sensors = <G::Sensors as Repeated<N>>::All;
    type Order = ();
    const CLASS: Class = class(Class::new(Level::Mp, Uses::NOTHING), G::CLASS);
    const ENDS: bool = G::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<()>,
        e: &State<[R; N]>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<[R; N]>, Fault> {
        const { assert!(N <= 64, "a cell has at most 64 robots") };
        let mut demands = [Demand::hold(); N];
        for (i, demand) in demands.iter_mut().enumerate() {
            let v = <G::Sensors as Repeated<N>>::one(v, i);
            let step = self.motions[i].first_step(c0, &State::new(e[i]), &v, t)?;
            *demand = self.told(i, step);
        }
        Ok(self.step(N as u32, demands).map_or(Step::Done, Step::Next))
    }

    fn next_step(
        &mut self,
        c0: &Order<()>,
        e: &State<[R; N]>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<[R; N]>, Fault> {
        let mut demands = [Demand::hold(); N];
        for (i, demand) in demands.iter_mut().enumerate() {
            if !self.is_done(i) {
                let v = <G::Sensors as Repeated<N>>::one(v, i);
                let step = self.motions[i].next_step(c0, &State::new(e[i]), &v, t)?;
                *demand = self.told(i, step);
            }
        }
        Ok(self.step(N as u32, demands).map_or(Step::Done, Step::Next))
    }
}
