//! Conditions in a tuple: which robots and sensors they have together, and what each of them sees of these.

use core::any::Any;

use mrroc::generator::{
    Class, Condition, Joined, JoinedRobots, Level, RobotList, SensorList, SharedRobots, SharedSensors, Uses,
};
use mrroc::prelude::*;

/// Conditions in a tuple whose lists become one by the rule `M`.
pub trait Group<M>: Sized {
    type Robots: RobotList;
    type Sensors: SensorList;
    type Order: Payload;
    const CLASS: Class;

    fn ask_each(
        &mut self,
        order: &Order<Self::Order>,
        e: &State<Self::Robots>,
        v: &Reading<Self::Sensors>,
        t: Tick,
        answer: impl FnMut(bool),
    ) -> Result<(), Fault>;
}

/// The class of two conditions together; that of the coordinator if one of them is.
const fn class(a: Class, b: Class) -> Class {
    let level = match (a.level, b.level) {
        (Level::Ecp, Level::Ecp) => Level::Ecp,
        (Level::Mp, _) | (_, Level::Mp) => Level::Mp,
    };
    Class::new(level, a.next.and(b.next))
}

/// Refuses, when the program is compiled, a part with the order `Q` that cannot be asked with the order `P` of the first one.
const fn check_order<P: Payload, Q: Payload>(part: Class, all: Class) {
    let reads = part.next.order;
    assert!(
        !reads || P::ID == Q::ID,
        "of the parts of a condition, the one that reads the order comes first"
    );
    assert!(
        !reads || matches!(all.level, Level::Ecp),
        "nobody orders an MP: a part of its condition reads an order"
    );
}

/// The order as a part reads it that has it or reads none.
fn order_of<P: Payload, Q: Payload>(order: &Order<P>) -> Result<Order<Q>, Fault> {
    let value = order.value();
    if let Some(same) = (&value as &dyn Any).downcast_ref::<Q>() {
        return Ok(Order::new(*same));
    }
    // It is not read, so any value does.
    let unread = Q::get(&[0; mrroc::payload::WORDS]);
    unread.map(Order::new).map_err(|_| Fault::thrown("a part of a condition has no order"))
}

/// The lists of the parts are one and the same.
#[derive(Debug)]
pub struct Shared;

/// Each part has lists of its own, one after the other.
#[derive(Debug)]
pub struct Own;

/// Two lists of robots as one, by the rule `M`.
pub trait OneOfRobots<M, B: RobotList>: RobotList + Sized {
    type All: RobotList;
    fn part(all: &State<Self::All>) -> (State<Self>, State<B>);
}

impl<A: SharedRobots<B>, B: RobotList> OneOfRobots<Shared, B> for A {
    type All = <A as SharedRobots<B>>::All;
    fn part(all: &State<Self::All>) -> (State<A>, State<B>) {
        A::split(all)
    }
}

impl<A: JoinedRobots<B>, B: RobotList> OneOfRobots<Own, B> for A {
    type All = <A as JoinedRobots<B>>::All;
    fn part(all: &State<Self::All>) -> (State<A>, State<B>) {
        A::split(all)
    }
}

/// Two lists of sensors as one, by the rule `M`.
pub trait OneOfSensors<M, B: SensorList>: SensorList + Sized {
    type All: SensorList;
    fn part(all: &Reading<Self::All>) -> (Reading<Self>, Reading<B>);
}

impl<A: SharedSensors<B>, B: SensorList> OneOfSensors<Shared, B> for A {
    type All = <A as SharedSensors<B>>::All;
    fn part(all: &Reading<Self::All>) -> (Reading<A>, Reading<B>) {
        A::split(all)
    }
}

impl<A: Joined<B>, B: SensorList> OneOfSensors<Own, B> for A {
    type All = <A as Joined<B>>::All;
    fn part(all: &Reading<Self::All>) -> (Reading<A>, Reading<B>) {
        A::split(all)
    }
}

type R1<A> = <A as Condition>::Robots;
type R2<M, A, B> = <R1<A> as OneOfRobots<M, R1<B>>>::All;
type R3<M, A, B, C> = <R2<M, A, B> as OneOfRobots<M, R1<C>>>::All;
type R4<M, A, B, C, D> = <R3<M, A, B, C> as OneOfRobots<M, R1<D>>>::All;
type V1<A> = <A as Condition>::Sensors;
type V2<M, A, B> = <V1<A> as OneOfSensors<M, V1<B>>>::All;
type V3<M, A, B, C> = <V2<M, A, B> as OneOfSensors<M, V1<C>>>::All;
type V4<M, A, B, C, D> = <V3<M, A, B, C> as OneOfSensors<M, V1<D>>>::All;

/// `Group` for a tuple: the conditions, their places, and what each of them looks at and reads; the lists of all; what is asked
/// of the lists; how those of all become those of the parts, from the last part on.
macro_rules! group {
    (
        $($C:ident $i:tt $e:ident $v:ident),+; $robots:ty, $sensors:ty; [$($bound:tt)*];
        |$all_e:ident, $all_v:ident| $($split:stmt;)*
    ) => {
        #[diagnostic::do_not_recommend]
        impl<M, $($C: Condition),+> Group<M> for ($($C,)+)
        where
            $($bound)*
        {
            type Robots = $robots;
            type Sensors = $sensors;
            type Order = A::Order;
            const CLASS: Class = {
                let mut all = Class::new(Level::Ecp, Uses::NOTHING);
                $(all = class(all, $C::CLASS);)+
                all
            };

            fn ask_each(
                &mut self,
                order: &Order<A::Order>,
                $all_e: &State<Self::Robots>,
                $all_v: &Reading<Self::Sensors>,
                t: Tick,
                mut answer: impl FnMut(bool),
            ) -> Result<(), Fault> {
                const { $(check_order::<A::Order, $C::Order>($C::CLASS, Self::CLASS);)+ }
                $($split)*
                $(answer(self.$i.is_met(&order_of(order)?, &$e, &$v, t)?);)+
                Ok(())
            }
        }
    };
}

group! {
    A 0 a va, B 1 b vb; R2<M, A, B>, V2<M, A, B>;
    [R1<A>: OneOfRobots<M, R1<B>>, V1<A>: OneOfSensors<M, V1<B>>,];
    |e, v|
    let (a, b) = R1::<A>::part(e);
    let (va, vb) = V1::<A>::part(v);
}
group! {
    A 0 a va, B 1 b vb, C 2 c vc; R3<M, A, B, C>, V3<M, A, B, C>;
    [
        R1<A>: OneOfRobots<M, R1<B>>, V1<A>: OneOfSensors<M, V1<B>>,
        R2<M, A, B>: OneOfRobots<M, R1<C>>, V2<M, A, B>: OneOfSensors<M, V1<C>>,
    ];
    |e, v|
    let (ab, c) = R2::<M, A, B>::part(e);
    let (vab, vc) = V2::<M, A, B>::part(v);
    let (a, b) = R1::<A>::part(&ab);
    let (va, vb) = V1::<A>::part(&vab);
}
group! {
    A 0 a va, B 1 b vb, C 2 c vc, D 3 d vd; R4<M, A, B, C, D>, V4<M, A, B, C, D>;
    [
        R1<A>: OneOfRobots<M, R1<B>>, V1<A>: OneOfSensors<M, V1<B>>,
        R2<M, A, B>: OneOfRobots<M, R1<C>>, V2<M, A, B>: OneOfSensors<M, V1<C>>,
        R3<M, A, B, C>: OneOfRobots<M, R1<D>>, V3<M, A, B, C>: OneOfSensors<M, V1<D>>,
    ];
    |e, v|
    let (abc, d) = R3::<M, A, B, C>::part(e);
    let (vabc, vd) = V3::<M, A, B, C>::part(v);
    let (ab, c) = R2::<M, A, B>::part(&abc);
    let (vab, vc) = V2::<M, A, B>::part(&vabc);
    let (a, b) = R1::<A>::part(&ab);
    let (va, vb) = V1::<A>::part(&vab);
}
