//! The macros, with what users read about them: a crate of macros alone has no `mrroc` that its examples could use.

/// Makes a generator of a step function: what a **Move** executes.
///
/// ```
#[doc = include_str!("macros_example_cell.txt")]
/// # struct Profile(f64);
/// # impl Profile { fn advance(&mut self, t: Tick) -> Option<f64> { self.0 -= t.dt; (self.0 > 0.0).then_some(self.0) } }
/// struct Carry {
///     profile: Profile,
///     grasps: [Pose; 2],
/// }
///
/// /// Carries the body upwards; both grippers keep their grasp on it.
/// #[generator(mp, first = grasp)]
/// fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
///     let Some(height) = c.profile.advance(t) else { return Step::Done };
///     let [X_WE0, X_WE1] = c.grasps.map(|X_WE| Pose::translation(0.0, 0.0, height) * X_WE);
///     Step::Next((Demand::pose(X_WE0), Demand::pose(X_WE1)))
/// }
///
/// /// Learns where each robot holds the body: the one place that needs `e`.
/// fn grasp(c: &mut Carry, e: &State<(Rnt, Polycrank)>, t: Tick) -> Step<(Rnt, Polycrank)> {
///     c.grasps = [e.0.demanded().pose, e.1.demanded().pose];
///     carry(c, t)
/// }
///
/// assert_eq!(Carry::CLASS.to_string(), "MP f*0(c0), first step f*2(c0, e)");
/// ```
///
/// # Arguments of a step function
///
/// They stand in any order, each at most once; the name of the type decides which argument it is.
///
/// | type | paper | |
/// |---|---|---|
/// | `&mut Carry` | `c0` in an MP, `c_j` in an ECP | the function's own state, a type of the user's crate |
/// | `&State<(Rnt, Polycrank)>` | `e` | the robots of an MP; of an ECP `&State<Rnt>` |
/// | `&Reading<(WristForce,)>` | `v` | the virtual sensors |
/// | `&Order<Phase>` | `c0` in an ECP | the MP's order |
/// | `Tick` | a part of `c` | the step's index and its path time |
///
/// The arguments that a function takes *are* its class (section 6 of the paper). In an ECP all eight classes are
/// legal. In an MP these five are legal: `f*0(c0)`, `f*1(c0, v)`, `f*2(c0, e)`, `f*3(c0, e, v)` and
/// `f**() = const`; others do not compile.
///
/// # What it returns
///
/// `Step<L>` with a demand for each robot of the list `L`, a tuple or an array in an MP, one robot in an ECP;
/// `Step<L, Phase>` with an order of that type for each; `Always<..>` when the motion has no end of its own; or
/// a `Result` of one of these with a `Fault`.
///
/// # A function without state
///
/// becomes a constant of its own name, `transmit {}`, and stays a function, `transmit(&order)`:
///
/// ```
#[doc = include_str!("macros_example_cell.txt")]
/// # fn program(mut ecp: Ecp<Rnt>) -> Result<(), Fault> {
/// #[generator(ecp)]
/// fn transmit(order: &Order<Force>) -> Always<Rnt> {
///     Always(Demand::displacement(Pose::translation(0.0, 0.0, order.value().along_z / 1000.0)))
/// }
///
/// ecp.move_robot((), transmit {})?;
/// # Ok(())
/// # }
/// ```
///
/// # In the attribute
///
/// | | |
/// |---|---|
/// | `mp` or `ecp` | the level, first |
/// | `first = grasp` | a plain function that computes the first step |
/// | `until = pressed` | a plain function that says, before each step, whether the motion is over: `-> bool` or `-> Result<bool, Fault>` |
/// | `sensors = (WristForce,)` | the sensors that only these functions read |
/// | `order = Phase` | the order that only these functions read |
/// | `crate = path` | the runtime, when it is not `::mrroc` |
///
/// The plain functions take their arguments in the order `&Order<P>`, `&mut C`, `&State<L>`, `&Reading<V>`,
/// `Tick`, leaving out what they do not need; `until` may take `&C`.
///
/// # Over an `impl` block
///
/// The method `next_step`, and the optional methods `first_step` and `until`, take the same arguments, with
/// `&mut self` or `&self` as the state. The block itself is not changed and may contain anything else.
///
/// ```
#[doc = include_str!("macros_example_cell.txt")]
/// use std::marker::PhantomData;
///
/// /// Presses down until the sensor feels it: serves every robot.
/// struct Press<R> {
///     depth: f64,
///     robot: PhantomData<R>,
/// }
///
/// #[generator(ecp)]
/// impl<R: Robot> Press<R> {
///     fn next_step(&mut self, t: Tick) -> Step<R> {
///         self.depth += 0.01 * t.dt;
///         Step::Next(Demand::displacement(Pose::translation(0.0, 0.0, self.depth)))
///     }
///
///     fn until(&self, v: &Reading<(WristForce,)>) -> bool {
///         v.0.reading().is_some_and(|force| force.along_z > 5.0)
///     }
/// }
///
/// assert_eq!(Press::<Rnt>::CLASS.to_string(), "ECP f*0(c), until f*1(c, v)");
/// ```
pub use mrroc_macros::generator;

/// Makes a condition of a function that returns `bool` or `Result<bool, Fault>`: what a **Wait** waits for.
///
/// The arguments are those of [`#[generator]`](macro@generator); without `&State<..>` the condition goes with
/// any robots. A condition without state is the constant of its name, `touched {}`. Over an `impl` block its
/// method is `is_met`.
///
/// ```
#[doc = include_str!("macros_example_cell.txt")]
/// /// How many steps in succession the body has been held, and how many are wanted.
/// struct Dwell {
///     held: u32,
///     wanted: u32,
/// }
///
/// #[condition(mp)]
/// fn body_held(c: &mut Dwell, v: &Reading<(WristForce,)>) -> bool {
///     let pulls = v.0.reading().is_some_and(|force| force.along_z < -2.0);
///     c.held = if pulls { c.held + 1 } else { 0 };
///     c.held >= c.wanted
/// }
///
/// assert_eq!(Dwell::CLASS.to_string(), "MP f*1(c0, v)");
/// ```
pub use mrroc_macros::condition;

/// Makes a payload: what travels between processes as an order, a reading or a sensor's configuration.
///
/// An `enum` is an order of loose cooperation: one word, the variant's index, and the words of the variant's fields if it
/// has any. A `struct` is an order of tight cooperation: the words of its fields, each of a type that implements `Wire`,
/// one after another. Both are checked when they are read back. The layout's hash covers the name of the type, the names
/// of fields and variants, and the types of fields.
///
/// ```
/// use mrroc::payload::Wire;
/// use mrroc::prelude::*;
///
/// #[derive(Clone, Copy, Debug, PartialEq, Payload)]
/// enum Phase {
///     Grasp,
///     Carry,
/// }
///
/// #[derive(Clone, Copy, Payload)]
/// struct Displacement {
///     pose: Pose,
///     step: u64,
/// }
///
/// /// What an arm does by itself, with a part and a bin that the MP chooses.
/// #[derive(Clone, Copy, Debug, PartialEq, Payload)]
/// enum Handle {
///     Pick { part: u32, at: Pose },
///     Drop { bin: u8 },
///     Rest,
/// }
///
/// assert!(!Phase::TIGHT && !Handle::TIGHT && Displacement::TIGHT);
/// assert_eq!(Phase::get(&[1]), Ok(Phase::Carry));
/// assert!(Phase::get(&[2]).is_err());
/// ```
///
/// `#[payload(crate = path)]` names the runtime when it is not `::mrroc`.
pub use mrroc_macros::Payload;
