//! What the macros make of step functions: plain functions stay plain, the class follows from the signature,
//! and the implementation calls the right functions with the right arguments.
#![deny(unused, nonstandard_style, unreachable_pub)]
#![allow(missing_docs)]

use core::marker::PhantomData;

use mrroc::generator::{AnyRobots, Condition, Generator, Motion};
use mrroc::payload::{WORDS, Wire};
use mrroc::prelude::*;
use mrroc::robot::{JointVector, RobotImage, RobotState};
use mrroc::sensor::SensorImage;

use super::cell::{Camera, Displacement, Force, Phase, Polycrank, Rnt, WristForce};

const TICK: Tick = Tick { step: 3, dt: 0.002, duration: 0.004 };

/// An image of a robot whose joints all stand at `q`.
fn at<R: Robot>(q: f64) -> RobotImage<R> {
    let joints = R::Joints::from_joints(|_| q);
    let state = RobotState { joints, velocity: R::Joints::zeros(), pose: Pose::identity() };
    RobotImage::new(state, state)
}

fn both(rnt: f64, polycrank: f64) -> State<(Rnt, Polycrank)> {
    State::new((at(rnt), at(polycrank)))
}

fn pushed(newton: f64) -> Reading<(WristForce,)> {
    Reading::new((SensorImage::new(Force { along: [0.0, 0.0, newton] }, 0),))
}

/// A demand of all joints at `q`.
fn to<R: Robot>(q: f64) -> Demand<R> {
    Demand::joints(R::Joints::from_joints(|_| q))
}

const NO_ORDER: Order<()> = Order::new(());
const NOTHING_READ: Reading<()> = Reading::new(());

// ---- A motion of the MP: its first step is another function, which alone needs `e`.

#[derive(Debug, Default, PartialEq)]
struct Carry {
    from: f64,
    steps: f64,
}

/// Carries.
#[generator(mp, first = grasp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
    c.steps += t.dt / t.duration;
    if c.steps > 1.0 { Step::Done } else { Step::Next((to(c.from + c.steps), to(c.steps))) }
}

fn grasp(c: &mut Carry, e: &State<(Rnt, Polycrank)>, _: Tick) -> Step<(Rnt, Polycrank)> {
    c.from = e.0.demanded().joints[0];
    Step::Next((to(c.from), Demand::hold()))
}

#[test]
fn a_step_function_is_called_in_a_test_without_robots() {
    let mut c = Carry { from: 1.0, steps: 0.0 };
    assert_eq!(carry(&mut c, TICK), Step::Next((to(1.5), to(0.5))));
    assert_eq!(grasp(&mut c, &both(4.0, 0.0), TICK), Step::Next((to(4.0), Demand::hold())));
}

#[test]
fn first_and_next_step_call_their_functions() {
    let mut c = Carry::default();
    let e = both(7.0, 0.0);
    assert_eq!(c.first_step(&NO_ORDER, &e, &NOTHING_READ, TICK), Ok(Step::Next((to(7.0), Demand::hold()))));
    assert_eq!(c.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK), Ok(Step::Next((to(7.5), to(0.5)))));
    assert_eq!(c.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK), Ok(Step::Next((to(8.0), to(1.0)))));
    assert_eq!(c.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK), Ok(Step::Done));
}

// ---- Functions without state.

#[generator(mp)]
fn trigger() -> Always<(Rnt, Polycrank), Phase> {
    Always((Phase::Grasp, Phase::Close))
}

#[generator(ecp)]
fn transmit(order: &Order<Displacement>) -> Always<Rnt> {
    Always(Demand::displacement(order.value().pose))
}

/// Runs until it has made its steps: a clock is enough of a state.
#[generator(ecp)]
fn ten_steps(t: Tick) -> Step<Rnt> {
    if t.step < 10 { Step::Next(Demand::hold()) } else { Step::Done }
}

#[test]
fn a_function_without_state_becomes_a_constant_of_its_name() {
    let order = Order::new(Displacement { pose: Pose::translation(0.0, 0.0, 0.1), step: 4 });
    let told = transmit {}.next_step(&order, &State::new(at(0.0)), &NOTHING_READ, TICK).unwrap();
    assert_eq!(told, Step::Next(transmit(&order).0));
    assert_eq!(told, Step::Next(Demand::displacement(Pose::translation(0.0, 0.0, 0.1))));
    let told = trigger {}.first_step(&NO_ORDER, &both(0.0, 0.0), &NOTHING_READ, TICK).unwrap();
    assert_eq!(told, Step::Next((Phase::Grasp, Phase::Close)));
}

// ---- A generic motion of an ECP that ends by a condition of its own, which reads what the steps do not.

struct Press<R> {
    depth: f64,
    of: PhantomData<R>,
}

#[generator(ecp, first = begin, until = pressed, sensors = (WristForce,), order = Phase)]
fn press<R: Robot>(c: &mut Press<R>, e: &State<R>) -> Result<Step<R>, Fault> {
    c.depth += e.measured().joints[0];
    if c.depth > 9.0 { Err(Fault::thrown("too deep")) } else { Ok(Step::Next(to(c.depth))) }
}

fn begin<R: Robot>(order: &Order<Phase>, c: &mut Press<R>) -> Step<R> {
    c.depth = if order.value() == Phase::Close { 5.0 } else { 0.0 };
    Step::Next(to(c.depth))
}

fn pressed(v: &Reading<(WristForce,)>) -> bool {
    v.0.reading().is_some_and(|force| force.along[2] > 5.0)
}

#[test]
fn the_terminal_condition_is_asked_before_every_step() {
    let mut c = Press::<Rnt> { depth: 0.0, of: PhantomData };
    let (order, e) = (Order::new(Phase::Close), State::new(at(3.0)));
    assert_eq!(c.first_step(&order, &e, &pushed(9.0), TICK), Ok(Step::Done));
    assert_eq!(c.depth.to_bits(), 0.0_f64.to_bits(), "a step that is over computes nothing");
    assert_eq!(c.first_step(&order, &e, &pushed(0.0), TICK), Ok(Step::Next(to(5.0))));
    assert_eq!(c.next_step(&order, &e, &pushed(0.0), TICK), Ok(Step::Next(to(8.0))));
    assert_eq!(c.next_step(&order, &e, &pushed(9.0), TICK), Ok(Step::Done));
    let fault = c.next_step(&order, &e, &pushed(0.0), TICK).unwrap_err();
    assert!(fault.to_string().contains("too deep"), "{fault}");
}

// ---- The same from a block of methods.

struct Line<R: Robot> {
    left: f64,
    robot: PhantomData<R>,
}

#[generator(ecp)]
impl<R: Robot> Line<R> {
    const SPEED: f64 = 500.0;

    fn of(left: f64) -> Self {
        Line { left, robot: PhantomData }
    }

    fn first_step(&mut self, e: &State<R>) -> Step<R> {
        self.left += e.measured().joints[0];
        Step::Next(Demand::hold())
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.left -= Self::SPEED * t.dt;
        Step::Next(to(self.left))
    }

    fn until(&self, v: &Reading<(WristForce,)>) -> Result<bool, Fault> {
        v.0.reading().map(|force| force.along[2] > 5.0).ok_or_else(|| Fault::thrown("no reading"))
    }
}

#[test]
fn methods_are_called_as_functions_are() {
    let mut line = Line::<Polycrank>::of(1.0);
    let e = State::new(at(3.0));
    assert_eq!(
        Generator::first_step(&mut line, &NO_ORDER, &e, &pushed(0.0), TICK),
        Ok(Step::Next(Demand::hold()))
    );
    assert_eq!(Generator::next_step(&mut line, &NO_ORDER, &e, &pushed(0.0), TICK), Ok(Step::Next(to(3.0))));
    assert_eq!(Generator::next_step(&mut line, &NO_ORDER, &e, &pushed(6.0), TICK), Ok(Step::Done));
    assert_eq!(line.next_step(TICK), Step::Next(to(2.0)), "the methods stay methods");
}

// ---- The other forms: arrays, one robot, borrowed states, functions named like the expansion's own names.

struct Row<'a, const N: usize>(&'a [f64; N]);

#[generator(mp, until = Row::is_level)]
fn row<const N: usize>(c: &mut Row<'_, N>) -> Step<[Rnt; N]> {
    Step::Next(core::array::from_fn(|i| to(c.0[i])))
}

impl<const N: usize> Row<'_, N> {
    fn is_level(&self) -> bool {
        self.0.iter().all(|q| *q == self.0[0])
    }
}

#[test]
fn lists_may_be_arrays_and_states_may_borrow() {
    let (mut steep, mut level) = (Row(&[1.0, 2.0, 3.0]), Row(&[2.0, 2.0]));
    let e = State::new([at(0.0); 3]);
    assert_eq!(
        steep.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK),
        Ok(Step::Next([to(1.0), to(2.0), to(3.0)]))
    );
    assert_eq!(level.first_step(&NO_ORDER, &State::new([at(0.0); 2]), &NOTHING_READ, TICK), Ok(Step::Done));
}

struct Lift;

type Outcome<T> = Result<T, Fault>;

/// A list of one robot, a `Result` by another name, and a function whose name the expansion uses for time.
#[generator(mp)]
fn t(
    c: &mut Lift,
    t: Tick,
    e: &mrroc::robot::State<(Rnt,)>,
) -> core::result::Result<mrroc::generator::Step<(Rnt,)>, mrroc::fault::Fault> {
    let _ = (c, t);
    lifted(e)
}

fn lifted(e: &State<(Rnt,)>) -> Outcome<Step<(Rnt,)>> {
    Ok(Step::Next((to(e.0.measured().joints[0]),)))
}

#[test]
fn names_of_the_expansion_do_not_meet_the_users() {
    let e = State::new((at(2.0),));
    assert_eq!(Lift.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK), t(&mut Lift, TICK, &e));
}

macro_rules! holds {
    ($name:ident: $robot:ty, $state:ty) => {
        #[generator(ecp)]
        fn $name(_: &mut $state) -> Step<$robot> {
            Step::Next(Demand::hold())
        }
    };
}

struct Hold;
holds!(hold: Polycrank, Hold);

mod inner {
    /// The runtime under another path.
    pub(crate) mod runtime {
        pub(crate) use mrroc::*;
    }

    use runtime::generator::{Always, Demand};
    use runtime::{condition, generator};

    #[generator(ecp, crate = runtime)]
    pub(crate) fn rest() -> Always<super::Rnt> {
        Always(Demand::hold())
    }

    #[condition(ecp, crate = runtime)]
    pub(crate) fn never() -> bool {
        false
    }

    #[derive(Clone, Copy, runtime::payload::Payload)]
    #[payload(crate = runtime)]
    pub(crate) struct Empty;
}

#[test]
fn types_may_come_through_macros_and_the_runtime_under_another_path() {
    let e = State::new(at(0.0));
    assert_eq!(hold(&mut Hold), Step::Next(Demand::hold()));
    assert_eq!(Hold.next_step(&NO_ORDER, &e, &NOTHING_READ, TICK), Ok(Step::Next(Demand::hold())));
    let told = inner::rest {}.next_step(&NO_ORDER, &State::new(at(0.0)), &NOTHING_READ, TICK);
    assert_eq!(told, Ok(Step::Next(inner::rest().0)));
    assert_eq!((inner::never(), inner::Empty::LEN), (false, 0));
}

// ---- Conditions.

struct Dwell<const N: usize>(usize);

#[condition(mp)]
fn dwell<const N: usize>(c: &mut Dwell<N>, v: &Reading<(WristForce,)>) -> bool {
    c.0 = if pressed(v) { c.0 + 1 } else { 0 };
    c.0 >= N
}

#[condition(ecp)]
fn near(e: &State<Rnt>, order: &Order<Displacement>) -> Result<bool, Fault> {
    if order.value().step == 0 {
        Err(Fault::thrown("no step"))
    } else {
        Ok(e.measured().joints[0].abs() < 0.1)
    }
}

struct After(u64);

#[condition(mp)]
impl After {
    fn is_met(&self, t: Tick) -> bool {
        t.step >= self.0
    }
}

#[test]
fn conditions_call_their_functions() {
    let mut c = Dwell::<2>(0);
    let e = State::<AnyRobots>::new(());
    let mut met = |newton| c.is_met(&NO_ORDER, &e, &pushed(newton), TICK).unwrap();
    assert_eq!([9.0, 9.0, 0.0, 9.0, 9.0].map(&mut met), [false, true, false, false, true]);

    let order = |step| Order::new(Displacement { pose: Pose::identity(), step });
    assert_eq!(near {}.is_met(&order(1), &State::new(at(0.0)), &NOTHING_READ, TICK), Ok(true));
    assert_eq!(near {}.is_met(&order(1), &State::new(at(1.0)), &NOTHING_READ, TICK), Ok(false));
    assert!(near {}.is_met(&order(0), &State::new(at(1.0)), &NOTHING_READ, TICK).is_err());

    assert_eq!(Condition::is_met(&mut After(3), &NO_ORDER, &e, &NOTHING_READ, TICK), Ok(true));
    assert_eq!(Condition::is_met(&mut After(4), &NO_ORDER, &e, &NOTHING_READ, TICK), Ok(false));
}

// ---- The classes, by the names of section 6 of the paper, and whether a motion has an end of its own.

/// One function for each class, named `mp_` or `ecp_` and its index.
mod classes {
    use super::*;

    pub(crate) struct S<const K: usize>;
    type L = (Rnt, Polycrank);
    type V = (WristForce, Camera);

    macro_rules! step_functions {
        ($($level:ident $name:ident($($argument:ty),*) -> $outcome:ty;)*) => {$(
            #[generator($level)]
            pub(crate) fn $name($(_: $argument),*) -> $outcome {
                unimplemented!("only the class is asked for")
            }
        )*};
    }

    step_functions! {
        mp mp_0(&mut S<0>) -> Step<(Rnt, Polycrank)>;
        mp mp_1(&mut S<1>, &Reading<V>) -> Step<(Rnt, Polycrank)>;
        mp mp_2(&State<(Rnt, Polycrank)>, &mut S<2>) -> Step<(Rnt, Polycrank)>;
        mp mp_3(&mut S<3>, &Reading<V>, &State<(Rnt, Polycrank)>) -> Step<(Rnt, Polycrank)>;
        mp mp_constant() -> Always<(Rnt, Polycrank)>;
        ecp ecp_0(&mut S<10>, Tick) -> Step<Rnt>;
        ecp ecp_1(&Reading<V>) -> Step<Rnt>;
        ecp ecp_2(&State<Rnt>) -> Always<Rnt>;
        ecp ecp_3(&State<Rnt>, &Reading<V>, &mut S<13>) -> Result<Step<Rnt>, Fault>;
        ecp ecp_4(&Order<Phase>) -> Result<Always<Rnt>, Fault>;
        ecp ecp_5(&Order<Phase>, &mut S<15>, &Reading<V>) -> Step<Rnt>;
        ecp ecp_6(&State<Rnt>, &Order<Phase>) -> Always<Rnt, Motion>;
        ecp ecp_7(&mut S<17>, &State<Rnt>, &Reading<V>, &Order<Phase>, Tick) -> Step<Rnt>;
    }

    #[test]
    fn all_thirteen_have_their_names() {
        let _: fn(&State<L>, &mut S<2>) -> Step<L> = mp_2;
        let of = [
            (S::<0>::CLASS, "MP f*0(c0)"),
            (S::<1>::CLASS, "MP f*1(c0, v)"),
            (S::<2>::CLASS, "MP f*2(c0, e)"),
            (S::<3>::CLASS, "MP f*3(c0, e, v)"),
            (mp_constant::CLASS, "MP f**() = const"),
            (S::<10>::CLASS, "ECP f*0(c)"),
            (ecp_1::CLASS, "ECP f*1(c, v)"),
            (ecp_2::CLASS, "ECP f*2(c, e)"),
            (S::<13>::CLASS, "ECP f*3(c, e, v)"),
            (ecp_4::CLASS, "ECP f*4(c0, c)"),
            (S::<15>::CLASS, "ECP f*5(c0, c, v)"),
            (ecp_6::CLASS, "ECP f*6(c0, c, e)"),
            (S::<17>::CLASS, "ECP f*7(c0, c, e, v)"),
        ];
        for (class, name) in of {
            assert_eq!(class.to_string(), name);
        }
    }
}

#[test]
fn sporadic_feedback_and_termination_have_classes_of_their_own() {
    assert_eq!(Carry::CLASS.to_string(), "MP f*0(c0), first step f*2(c0, e)");
    assert_eq!(Press::<Rnt>::CLASS.to_string(), "ECP f*2(c, e), first step f*4(c0, c), until f*1(c, v)");
    assert_eq!(Line::<Rnt>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e), until f*1(c, v)");
    assert_eq!(Row::<4>::CLASS.to_string(), "MP f*0(c0), until f*0(c0)");
    assert_eq!(Dwell::<1>::CLASS.to_string(), "MP f*1(c0, v)");
    assert_eq!(near::CLASS.to_string(), "ECP f*6(c0, c, e)");
    let carry = Carry::CLASS;
    assert!(carry.first.robots && carry.first.tick && carry.next.tick && !carry.next.robots);
}

#[test]
fn a_motion_ends_by_itself_if_it_can_be_done() {
    const { assert!(Carry::ENDS && ten_steps::ENDS && Press::<Rnt>::ENDS && Line::<Rnt>::ENDS) };
    const { assert!(!trigger::ENDS && !transmit::ENDS && !inner::rest::ENDS) };
}

// ---- Payloads.

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Pair(u8, Phase);

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Full {
    words: [u64; WORDS],
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
enum Handle {
    Rest,
    Pick { part: u32, at: Pose, how: Phase },
    Drop(u8, bool),
}

fn round_trip<P: Payload + PartialEq + core::fmt::Debug>(value: P) {
    let mut words = [u64::MAX; WORDS];
    value.put(&mut words[..P::LEN]);
    assert_eq!(P::get(&words[..P::LEN]), Ok(value));
    if P::LEN > 0 {
        assert!(P::get(&words[..P::LEN - 1]).is_err(), "one word is missing");
    }
}

#[test]
fn payloads_come_back_as_they_were_sent() {
    round_trip(Phase::Grasp);
    round_trip(Phase::Close);
    round_trip(Displacement { pose: Pose::translation(1.0, -2.0, 0.5), step: u64::MAX });
    round_trip(Pair(255, Phase::Close));
    round_trip(Handle::Rest);
    round_trip(Handle::Pick { part: u32::MAX, at: Pose::translation(1.0, -2.0, 0.5), how: Phase::Close });
    round_trip(Handle::Drop(7, true));
    round_trip(Full { words: core::array::from_fn(|i| i as u64) });
    assert_eq!((Phase::LEN, Displacement::LEN, Pair::LEN, Full::LEN), (1, 8, 2, WORDS));
    assert_eq!(Handle::LEN, 1 + 1 + 7 + 1, "the choice, and the longest variant");
    assert_eq!(Handle::SHAPE.len(), Handle::LEN);
}

#[test]
fn words_that_spell_no_value_are_refused() {
    assert!(Phase::get(&[2]).is_err(), "a third variant");
    assert!(Phase::get(&[]).is_err());
    assert!(Pair::get(&[256, 0]).is_err(), "no u8");
    assert!(Pair::get(&[1, 7]).is_err(), "no phase");
    let words = |first: [u64; 3]| {
        let mut words = [0; Handle::LEN];
        words[..3].copy_from_slice(&first);
        words
    };
    assert_eq!(Handle::get(&words([2, 7, 1])), Ok(Handle::Drop(7, true)));
    assert!(Handle::get(&words([3, 0, 0])).is_err(), "a fourth variant");
    assert!(Handle::get(&words([2, 256, 0])).is_err(), "no u8 in a variant");
    assert!(Handle::get(&words([2, 0, 2])).is_err(), "no bool in a variant");
}

#[test]
fn what_a_variant_does_not_say_is_zero() {
    let mut words = [u64::MAX; Handle::LEN];
    Handle::Drop(7, true).put(&mut words);
    assert_eq!(words, [2, 7, 1, 0, 0, 0, 0, 0, 0, 0]);
    Handle::Rest.put(&mut words);
    assert_eq!(words, [0; Handle::LEN]);
}

#[test]
fn an_enum_is_loose_and_a_struct_is_tight() {
    const { assert!(!Phase::TIGHT && !Handle::TIGHT && Displacement::TIGHT && Pair::TIGHT) };
    assert_eq!((Phase::NAME, Pair::NAME), ("Phase", "Pair"));
}

#[test]
fn payloads_that_differ_in_name_fields_or_types_differ_on_the_wire() {
    macro_rules! ids {
        ($($module:ident { $item:item })*) => {{
            $(mod $module {
                #![allow(dead_code)]
                use mrroc::payload::Payload;
                #[derive(Clone, Copy, Payload)]
                $item
                pub(super) const ID: u64 = P::ID;
            })*
            [$($module::ID),*]
        }};
    }
    let ids = ids! {
        a { enum P { A, B } }
        b { enum P { B, A } }
        c { enum P { A, B, C } }
        d { struct P { a: f64, b: f64 } }
        e { struct P { b: f64, a: f64 } }
        f { struct P { a: f64, b: u64 } }
        g { struct P { a: [f64; 2] } }
        h { struct P { a: [f64; 3] } }
        i { struct P(f64, f64); }
        j { struct P; }
        k { enum P { A(f64), B } }
        l { enum P { A, B(f64) } }
        m { enum P { A { a: f64 }, B } }
        n { enum P { A(u64), B } }
        o { enum P { A(f64, f64), B } }
    };
    for (i, id) in ids.iter().enumerate() {
        assert!(!ids[..i].contains(id), "payload {i} is taken for another");
    }
}
