//! Plain functions as the first step and as the terminal condition of a motion.
//!
//! `#[generator(.., first = grasp, until = released)]` names functions whose signatures the attribute cannot
//! see. A trait sees them: it is implemented for every function that takes some of `order`, `c`, `e`, `v` and
//! `t`, in this order, and each implementation knows which those are. So the class follows from the types.

use core::marker::PhantomData;

use crate::class::Uses;
use crate::fault::Fault;
use crate::generator::Generator;
use crate::image::{Reading, State};
use crate::list::{RobotList, Robots, SensorList};
use crate::payload::{Order, Payload};
use crate::step::{IntoStep, IntoVerdict, Step, Tick};

/// In the shape of a function: takes this argument.
#[derive(Debug)]
pub struct Takes;

/// In the shape of a function: leaves this argument out.
#[derive(Debug)]
pub struct Without;

/// A plain function that computes a step of the motion of state `C`; `Shape` says which arguments it takes.
#[diagnostic::on_unimplemented(
    message = "this function is no first step of a generator with the state `{C}`",
    label = "no step function for `{C}`, the robots `{L}`, the sensors `{V}` and the order `{P}`",
    note = "a first step takes some of `&Order<{P}>`, `&mut {C}`, `&State<{L}>`, `&Reading<{V}>`, `Tick`, in this order, and returns `Step<{L}>`, in the language of the next steps, or a `Result` of it",
    note = "readings or an order that the next steps do not take are named in the attribute: `sensors = (WristForce,)`, `order = Phase`"
)]
pub trait StepFn<C, L: Robots<O>, O, V: SensorList, P: Payload, Shape> {
    /// Which arguments the function takes.
    const USES: Uses;

    /// Calls the function with the arguments that it takes.
    ///
    /// # Errors
    /// The function's own.
    fn call(
        &self,
        order: &Order<P>,
        c: &mut C,
        e: &State<L>,
        v: &Reading<V>,
        t: Tick,
    ) -> Result<Step<L, O>, Fault>;
}

/// A plain function that says whether the motion of state `C` is over.
#[diagnostic::on_unimplemented(
    message = "this function is no terminal condition of a generator with the state `{C}`",
    label = "no terminal condition for `{C}`, the robots `{L}`, the sensors `{V}` and the order `{P}`",
    note = "a terminal condition takes some of `&Order<{P}>`, `&mut {C}`, `&State<{L}>`, `&Reading<{V}>`, `Tick`, in this order, and returns `bool` or `Result<bool, Fault>`",
    note = "readings or an order that the steps do not take are named in the attribute: `sensors = (WristForce,)`, `order = Phase`"
)]
pub trait UntilFn<C, L: RobotList, V: SensorList, P: Payload, Shape> {
    /// Which arguments the function takes.
    const USES: Uses;

    /// Calls the function with the arguments that it takes.
    ///
    /// # Errors
    /// The function's own.
    fn call(&self, order: &Order<P>, c: &mut C, e: &State<L>, v: &Reading<V>, t: Tick)
    -> Result<bool, Fault>;
}

/// The shapes that have a meaning in an MP (section 6 of the paper).
#[diagnostic::on_unimplemented(
    message = "this first step has no meaning in an MP",
    label = "takes an order, or reacts to robots or sensors without a state of the coordinator",
    note = "the five forms of an MP are `c`, `c, v`, `c, e`, `c, e, v`, and a constant without arguments"
)]
pub trait MeaningfulInMp {}
impl<E, V, T> MeaningfulInMp for (Without, Takes, E, V, T) {}
impl<E, V> MeaningfulInMp for (Without, Without, E, V, Takes) {}
impl MeaningfulInMp for (Without, Without, Without, Without, Without) {}

/// A plain function with what its type says of it.
#[derive(Debug)]
pub struct Plain<'f, F, G, Shape> {
    /// Which arguments the function takes.
    pub uses: Uses,
    function: &'f F,
    shape: PhantomData<fn() -> (G, Shape)>,
}

impl<'f, F, G, Shape> Plain<'f, F, G, Shape> {
    const fn new(function: &'f F, uses: Uses) -> Self {
        Plain { uses, function, shape: PhantomData }
    }
}

/// `f` as the first step of the MP generator `G`.
pub const fn first_in_mp<G, F, Shape>(f: &F) -> Plain<'_, F, G, Shape>
where
    G: Generator,
    F: StepFn<G, G::Robots, G::Language, G::Sensors, G::Order, Shape>,
    Shape: MeaningfulInMp,
{
    Plain::new(f, F::USES)
}

/// `f` as the first step of the ECP generator `G`.
pub const fn first_in_ecp<G, F, Shape>(f: &F) -> Plain<'_, F, G, Shape>
where
    G: Generator,
    F: StepFn<G, G::Robots, G::Language, G::Sensors, G::Order, Shape>,
{
    Plain::new(f, F::USES)
}

/// `f` as the terminal condition of the generator `G`.
pub const fn until<G, F, Shape>(f: &F) -> Plain<'_, F, G, Shape>
where
    G: Generator,
    F: UntilFn<G, G::Robots, G::Sensors, G::Order, Shape>,
{
    Plain::new(f, F::USES)
}

impl<F, G: Generator, Shape> Plain<'_, F, G, Shape> {
    /// The step that the function computes.
    ///
    /// # Errors
    /// The function's own.
    #[inline]
    pub fn step(
        &self,
        order: &Order<G::Order>,
        c: &mut G,
        e: &State<G::Robots>,
        v: &Reading<G::Sensors>,
        t: Tick,
    ) -> Result<Step<G::Robots, G::Language>, Fault>
    where
        F: StepFn<G, G::Robots, G::Language, G::Sensors, G::Order, Shape>,
    {
        self.function.call(order, c, e, v, t)
    }

    /// Whether the terminal condition holds.
    ///
    /// # Errors
    /// The function's own.
    #[inline]
    pub fn holds(
        &self,
        order: &Order<G::Order>,
        c: &mut G,
        e: &State<G::Robots>,
        v: &Reading<G::Sensors>,
        t: Tick,
    ) -> Result<bool, Fault>
    where
        F: UntilFn<G, G::Robots, G::Sensors, G::Order, Shape>,
    {
        self.function.call(order, c, e, v, t)
    }
}

/// The type of an argument.
macro_rules! argument {
    (order) => { &Order<P> };
    (state) => { &mut C };
    (robots) => { &State<L> };
    (sensors) => { &Reading<V> };
    (tick) => { Tick };
}

/// Both traits for every subset of the arguments, by deciding one argument after another.
macro_rules! shapes {
    ($values:tt [$($taken:ident)*] [$($shape:ident)*] $next:ident $($rest:ident)*) => {
        shapes! { $values [$($taken)* $next] [$($shape)* Takes] $($rest)* }
        shapes! { $values [$($taken)*] [$($shape)* Without] $($rest)* }
    };
    (($order:ident $state:ident $robots:ident $sensors:ident $tick:ident) [$($taken:ident)*] [$($shape:ident)*]) => {
        #[diagnostic::do_not_recommend]
        impl<F, C, L, O, V, P, T> StepFn<C, L, O, V, P, ($($shape,)*)> for F
        where
            L: Robots<O>,
            V: SensorList,
            P: Payload,
            T: IntoStep<L, O>,
            F: Fn($(argument!($taken)),*) -> T,
        {
            #[allow(clippy::needless_update)] // of the shape that takes all
            const USES: Uses = Uses { $($taken: true,)* ..Uses::NOTHING };

            #[inline]
            #[allow(unused_variables)]
            fn call(
                &self,
                $order: &Order<P>,
                $state: &mut C,
                $robots: &State<L>,
                $sensors: &Reading<V>,
                $tick: Tick,
            ) -> Result<Step<L, O>, Fault> {
                self($($taken),*).into_step()
            }
        }

        #[diagnostic::do_not_recommend]
        impl<F, C, L, V, P, T> UntilFn<C, L, V, P, ($($shape,)*)> for F
        where
            L: RobotList,
            V: SensorList,
            P: Payload,
            T: IntoVerdict,
            F: Fn($(argument!($taken)),*) -> T,
        {
            #[allow(clippy::needless_update)] // of the shape that takes all
            const USES: Uses = Uses { $($taken: true,)* ..Uses::NOTHING };

            #[inline]
            #[allow(unused_variables)]
            fn call(
                &self,
                $order: &Order<P>,
                $state: &mut C,
                $robots: &State<L>,
                $sensors: &Reading<V>,
                $tick: Tick,
            ) -> Result<bool, Fault> {
                self($($taken),*).into_verdict()
            }
        }
    };
}

shapes! { (order state robots sensors tick) [] [] order state robots sensors tick }
