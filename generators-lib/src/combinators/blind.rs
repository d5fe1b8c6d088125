//! A generator without sensors among others that have some.

use core::marker::PhantomData;

use mrroc::generator::{Class, Generator, SensorList};
use mrroc::prelude::*;

/// A generator that reads no sensors, in a motion that has the sensors `V`: combinators take parts of one list of sensors. It
/// demands what the generator demands. `V` follows from the other parts.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc_generators::combinators::Blind;
/// use mrroc_generators::generators::Sleep;
/// use mrroc_robots::Irp6;
///
/// # struct Wrist;
/// # impl mrroc::prelude::Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = mrroc::pose::Wrench;
/// #     type Configuration = ();
/// # }
/// let waits: Blind<_, (Wrist,)> = Blind::new(Sleep::<Irp6>::lasting(0.5));
/// # fn class<G: Generator>(_: &G) -> String {
/// #     G::CLASS.to_string()
/// # }
/// assert_eq!(class(&waits), "ECP f*0(c)");
/// ```
pub struct Blind<G, V> {
    generator: G,
    of: PhantomData<V>,
}

impl<G: Generator<Sensors = ()>, V: SensorList> Blind<G, V> {
    /// The generator, which never sees a reading.
    #[must_use]
    pub fn new(generator: G) -> Self {
        Blind { generator, of: PhantomData }
    }
}

impl<G: Generator<Sensors = ()>, V: SensorList> Generator for Blind<G, V> {
    type Robots = G::Robots;
    type Language = G::Language;
    type Sensors = V;
    type Order = G::Order;
    const CLASS: Class = G::CLASS;
    const ENDS: bool = G::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<G::Robots>,
        _: &Reading<V>,
        t: Tick,
    ) -> Result<Step<G::Robots, G::Language>, Fault> {
        self.generator.first_step(c0, e, &Reading::new(()), t)
    }

    fn next_step(
        &mut self,
        c0: &Order<G::Order>,
        e: &State<G::Robots>,
        _: &Reading<V>,
        t: Tick,
    ) -> Result<Step<G::Robots, G::Language>, Fault> {
        self.generator.next_step(c0, e, &Reading::new(()), t)
    }
}
