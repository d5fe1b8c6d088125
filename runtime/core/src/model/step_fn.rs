//! Plain functions as the first step and as the terminal condition of a motion.
//!
//! `#[generator(.., first = grasp, until = released)]` names functions whose signatures the attribute cannot
//! see. A trait sees them: it is implemented for every function that takes some of `order`, `c`, `e`, `v` and
//! `t`, in this order, and each implementation knows which those are. So the class follows from the types.

use crate::model::class::Uses;
use crate::model::fault::Fault;
use crate::model::generator::Generator;
use crate::model::list::{Reading, State};
use crate::model::list::{RobotList, Robots, SensorList};
use crate::model::payload::{Order, Payload};
use crate::model::step::{IntoStep, IntoVerdict, Step, Tick};

/// In the shape of a function: takes this argument.
#[derive(Debug)]
pub struct Takes;

/// In the shape of a terminal condition: takes its state by shared reference.
#[derive(Debug)]
pub struct Reads;

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
    note = "a terminal condition takes some of `&Order<{P}>`, `&mut {C}` or `&{C}`, `&State<{L}>`, `&Reading<{V}>`, `Tick`, in this order, and returns `bool` or `Result<bool, Fault>`",
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

/// A plain function with what its type says of it; `Call` is its type with all the arguments there are.
#[derive(Debug)]
pub struct Plain<'f, F, Call> {
    /// Which arguments the function takes.
    pub uses: Uses,
    function: &'f F,
    call: Call,
}

/// A first step, called with all arguments.
pub type FirstStep<F, G> = fn(
    &F,
    &Order<<G as Generator>::Order>,
    &mut G,
    &State<<G as Generator>::Robots>,
    &Reading<<G as Generator>::Sensors>,
    Tick,
) -> Result<Step<<G as Generator>::Robots, <G as Generator>::Language>, Fault>;

/// A terminal condition, called with all arguments.
pub type Until<F, G> = fn(
    &F,
    &Order<<G as Generator>::Order>,
    &mut G,
    &State<<G as Generator>::Robots>,
    &Reading<<G as Generator>::Sensors>,
    Tick,
) -> Result<bool, Fault>;

/// `f` as the first step of the MP generator `G`.
pub const fn first_in_mp<G, F, Shape>(f: &F) -> Plain<'_, F, FirstStep<F, G>>
where
    G: Generator,
    F: StepFn<G, G::Robots, G::Language, G::Sensors, G::Order, Shape>,
    Shape: MeaningfulInMp,
{
    Plain { uses: F::USES, function: f, call: F::call }
}

/// `f` as the first step of the ECP generator `G`.
pub const fn first_in_ecp<G, F, Shape>(f: &F) -> Plain<'_, F, FirstStep<F, G>>
where
    G: Generator,
    F: StepFn<G, G::Robots, G::Language, G::Sensors, G::Order, Shape>,
{
    Plain { uses: F::USES, function: f, call: F::call }
}

/// `f` as the terminal condition of the generator `G`.
pub const fn until<G, F, Shape>(f: &F) -> Plain<'_, F, Until<F, G>>
where
    G: Generator,
    F: UntilFn<G, G::Robots, G::Sensors, G::Order, Shape>,
{
    Plain { uses: F::USES, function: f, call: F::call }
}

impl<F, G: Generator> Plain<'_, F, FirstStep<F, G>> {
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
    ) -> Result<Step<G::Robots, G::Language>, Fault> {
        (self.call)(self.function, order, c, e, v, t)
    }
}

impl<F, G: Generator> Plain<'_, F, Until<F, G>> {
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
    ) -> Result<bool, Fault> {
        (self.call)(self.function, order, c, e, v, t)
    }
}

/// `StepFn` for the functions of one shape.
macro_rules! step_fn {
    (($order:ident $state:ident $robots:ident $sensors:ident $tick:ident)
     [$(($taken:ident: $of:ty))*] [$($shape:ident)*]) => {
        #[diagnostic::do_not_recommend]
        impl<F, C, L, O, V, P, T> StepFn<C, L, O, V, P, ($($shape,)*)> for F
        where
            L: Robots<O>,
            V: SensorList,
            P: Payload,
            T: IntoStep<L, O>,
            F: Fn($($of),*) -> T,
        {
            #[allow(clippy::needless_update)]
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
    };
}

/// `UntilFn` for the functions of one shape.
macro_rules! until_fn {
    (($order:ident $state:ident $robots:ident $sensors:ident $tick:ident)
     [$(($taken:ident: $of:ty))*] [$($shape:ident)*]) => {
        #[diagnostic::do_not_recommend]
        impl<F, C, L, V, P, T> UntilFn<C, L, V, P, ($($shape,)*)> for F
        where
            L: RobotList,
            V: SensorList,
            P: Payload,
            T: IntoVerdict,
            F: Fn($($of),*) -> T,
        {
            #[allow(clippy::needless_update)]
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

/// The traits for every subset of the arguments, by deciding one argument after another. `@both` implements
/// both; `@until` the one alone.
macro_rules! shapes {
    (@$which:ident $names:tt [$($taken:tt)*] [$($shape:ident)*] ($name:ident: $of:ty) $($rest:tt)*) => {
        shapes! { @$which $names [$($taken)* ($name: $of)] [$($shape)* Takes] $($rest)* }
        shapes! { @$which $names [$($taken)*] [$($shape)* Without] $($rest)* }
    };
    (@$which:ident $names:tt [$($taken:tt)*] [$($shape:ident)*] ($name:ident: $of:ty, or $shared:ty) $($rest:tt)*) => {
        shapes! { @$which $names [$($taken)* ($name: $of)] [$($shape)* Takes] $($rest)* }
        shapes! { @until $names [$($taken)* ($name: $shared)] [$($shape)* Reads] $($rest)* }
        shapes! { @$which $names [$($taken)*] [$($shape)* Without] $($rest)* }
    };
    (@both $names:tt $taken:tt $shape:tt) => {
        step_fn! { $names $taken $shape }
        until_fn! { $names $taken $shape }
    };
    (@until $names:tt $taken:tt $shape:tt) => {
        until_fn! { $names $taken $shape }
    };
}

shapes! {
    @both (order state robots sensors tick) [] []
    (order: &Order<P>) (state: &mut C, or &C) (robots: &State<L>) (sensors: &Reading<V>) (tick: Tick)
}
