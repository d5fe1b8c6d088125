//! What every generator must keep, as tests that any generator can run: of this crate or of another.
//!
//! ```ignore
//! mrroc_generators::generator_conformance! {
//!     joint_move: JointMove<Irp6>,
//!     class: "ECP f*0(c), first step f*2(c, e)",
//!     make: JointMove::to(goal, velocity, acceleration),
//!     given: |_step| Given { order: Order::new(()), e: arm_at(start), v: Reading::new(()) },
//!     odd: |x| vec![JointMove::to(Six::repeat(x), velocity, acceleration), JointMove::to(goal, Six::repeat(x), acceleration)],
//!     allocated: bytes,
//! }
//! ```
//!
//! `given` says what the generator is told in each step. `odd` makes generators out of a number that may be anything: one of
//! [`ODD`]. `allocated` names a function that counts the bytes allocated so far; without it that test is left out. Demands are
//! compared as they travel, number by number.

use mrroc::generator::{Generator, RobotList, Robots, SensorList, Uses};
use mrroc::payload::{WORDS, Wire};
use mrroc::prelude::*;

/// Path time of a step \[s\].
pub const DT: f64 = 4e-3;

/// Steps after which a motion is looked at no longer.
pub const MOST: usize = 2_000;

/// Numbers that a caller may hand to a generator by mistake; the first ones are only unusual.
pub const ODD: [f64; 9] =
    [0.0, 1e-300, 1e-12, 1e300, -1.0, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];

/// By how much a number of a demand may depend on suspensions \[m, rad, or a quaternion's\].
pub const TOLERANCE: f64 = 1e-9;

/// A promise that a generator does not keep, with the figures.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Violation(String);

/// A violation unless `holds`.
fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation(what())) }
}

/// What a generator is told in a step.
pub struct Given<G: Generator> {
    /// The coordinator's order `c0`.
    pub order: Order<G::Order>,
    /// The robots' states `e`.
    pub e: State<G::Robots>,
    /// The sensors' readings `v`.
    pub v: Reading<G::Sensors>,
}

impl<G: Generator> Given<G> {
    /// Nothing of use: what a step function must not look at that does not name it in its class.
    fn nothing() -> Result<Self, Violation> {
        let order = G::Order::get(&[0; WORDS]).map_err(|bad| Violation(bad.to_string()))?;
        let e = <G::Robots as RobotList>::unknown();
        let v = <G::Sensors as SensorList>::unknown();
        Ok(Given { order: Order::new(order), e: State::new(e), v: Reading::new(v) })
    }
}

/// How a run of a generator ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// The generator was done.
    Done,
    /// It threw a fault.
    Fault,
    /// It was still at it.
    Open,
}

/// The demands of a run, each as its words.
#[derive(PartialEq)]
struct Run {
    demands: Vec<Vec<u64>>,
    end: End,
}

/// How a generator is run.
struct How<'a> {
    /// Path time of a step \[s\].
    dt: &'a dyn Fn(usize) -> f64,
    /// The step whose knowledge it is given.
    known: &'a dyn Fn(u64) -> u64,
    /// Whether it is given only what its class names.
    only_named: bool,
}

impl How<'_> {
    /// At full speed, with all that is known.
    const FREELY: How<'static> = How { dt: &|_| DT, known: &|step| step, only_named: false };
}

/// What a generator's type says.
struct Facts {
    class: String,
    next_uses: Uses,
    ends: bool,
}

impl Facts {
    fn of<G: Generator>() -> Facts {
        Facts { class: G::CLASS.to_string(), next_uses: G::CLASS.next_uses(), ends: G::ENDS }
    }
}

/// A run of a generator. What looks at runs is compiled once for all generators.
fn run<G: Generator>(mut generator: G, given: &dyn Fn(u64) -> Given<G>, how: &How<'_>) -> Run {
    let mut demands = Vec::new();
    for i in 0..MOST {
        let t = Tick { step: i as u64, dt: (how.dt)(i), duration: DT };
        let known = given((how.known)(t.step));
        let Given { order, e, v } = if how.only_named { named(known, i == 0) } else { known };
        let stepped = match i {
            0 => generator.first_step(&order, &e, &v, t),
            _ => generator.next_step(&order, &e, &v, t),
        };
        match stepped {
            Ok(Step::Next(told)) => demands.push(words::<G>(&told)),
            Ok(Step::Done) => return Run { demands, end: End::Done },
            Err(_) => return Run { demands, end: End::Fault },
        }
    }
    Run { demands, end: End::Open }
}

/// Of what is known, only what the class of a step names.
fn named<G: Generator>(known: Given<G>, is_first: bool) -> Given<G> {
    let uses = if is_first { G::CLASS.first_uses() } else { G::CLASS.next_uses() };
    let Ok(Given { order, e, v }) = Given::<G>::nothing() else { return known };
    Given {
        order: if uses.order { known.order } else { order },
        e: if uses.robots { known.e } else { e },
        v: if uses.sensors { known.v } else { v },
    }
}

/// What is told to all robots, as it travels.
fn words<G: Generator>(told: &<G::Robots as Robots<G::Language>>::Demands) -> Vec<u64> {
    let mut words = vec![0; WORDS * <G::Robots as RobotList>::LEN];
    for (i, share) in words.chunks_mut(WORDS).enumerate() {
        <G::Robots as Robots<G::Language>>::write(told, i, share);
    }
    words
}

/// The largest difference between two demands, number by number.
fn difference(a: &[u64], b: &[u64]) -> f64 {
    let differ =
        |(a, b): (&u64, &u64)| if a == b { 0.0 } else { (f64::from_bits(*a) - f64::from_bits(*b)).abs() };
    // Words that are no number and differ count as far apart.
    a.iter().zip(b).map(differ).fold(0.0, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
}

/// Whether a step takes nothing but the function's own state and the tick.
fn is_blind(uses: Uses) -> bool {
    !(uses.order || uses.robots || uses.sensors)
}

/// The class is the one that is declared, and the steps look at nothing else: what their class does not name may be
/// anything.
///
/// # Errors
/// The first [`Violation`].
pub fn has_its_class<G: Generator>(
    make: impl Fn() -> G,
    given: impl Fn(u64) -> Given<G>,
    class: &str,
) -> Result<(), Violation> {
    class_of(&Facts::of::<G>(), class, &|how| run(make(), &given, how))?;
    Given::<G>::nothing().map(drop)
}

fn class_of(facts: &Facts, class: &str, run: &dyn Fn(&How<'_>) -> Run) -> Result<(), Violation> {
    ensure(facts.class == class, || format!("the class is {}, not {class}", facts.class))?;
    let named = run(&How { only_named: true, ..How::FREELY });
    ensure(run(&How::FREELY) == named, || "it looks at what its class does not name".into())
}

/// Equal generators that are told the same demand the same, to the bit.
///
/// # Errors
/// The first [`Violation`].
pub fn is_deterministic<G: Generator>(
    make: impl Fn() -> G,
    given: impl Fn(u64) -> Given<G>,
) -> Result<(), Violation> {
    equal_runs(&|how| run(make(), &given, how))
}

fn equal_runs(run: &dyn Fn(&How<'_>) -> Run) -> Result<(), Violation> {
    let (one, two) = (run(&How::FREELY), run(&How::FREELY));
    let at = one.demands.iter().zip(&two.demands).position(|(a, b)| a != b);
    ensure(one == two, || format!("two runs differ, first in step {at:?}"))
}

/// It moves: demands something, finite in every step, and ends without a fault, if it ends.
///
/// # Errors
/// The first [`Violation`].
pub fn demands_finite_numbers<G: Generator>(
    make: impl Fn() -> G,
    given: impl Fn(u64) -> Given<G>,
) -> Result<(), Violation> {
    moves(&Facts::of::<G>(), &run(make(), &given, &How::FREELY))
}

fn moves(facts: &Facts, run: &Run) -> Result<(), Violation> {
    ensure(!run.demands.is_empty(), || "it demands nothing".into())?;
    ensure(run.end != End::Fault, || format!("a fault in step {}", run.demands.len()))?;
    ensure(run.end != End::Done || facts.ends, || "it ends, but says that it does not".into())?;
    finite(run, &|| "as it is made".into())
}

fn finite(run: &Run, what: &dyn Fn() -> String) -> Result<(), Violation> {
    for (i, demand) in run.demands.iter().enumerate() {
        let bad = demand.iter().map(|word| f64::from_bits(*word)).find(|x| !x.is_finite());
        ensure(bad.is_none(), || format!("{}: it demands {bad:?} in step {i}", what()))?;
    }
    Ok(())
}

/// Made out of odd numbers, it is refused, throws a fault or demands finite numbers: never NaN, never a panic.
///
/// # Errors
/// The first [`Violation`].
pub fn refuses_odd_numbers<G: Generator>(
    given: impl Fn(u64) -> Given<G>,
    odd: impl Fn(f64) -> Vec<G>,
) -> Result<(), Violation> {
    for x in ODD {
        for (i, generator) in odd(x).into_iter().enumerate() {
            finite(&run(generator, &given, &How::FREELY), &|| format!("case {i} of {x}"))?;
        }
    }
    Ok(())
}

/// The path time of a run that is slowed down, suspended and resumed from step `at` on.
fn suspended(at: usize) -> impl Fn(usize) -> f64 {
    move |i| {
        DT * i.checked_sub(at).and_then(|k| [0.75, 0.5, 0.2, 0.0, 0.0, 0.0, 0.3, 0.6].get(k)).unwrap_or(&1.0)
    }
}

/// A sensorless, time-invariant generator that is suspended in any step ends where it ends undisturbed, to [`TOLERANCE`]. Any
/// other stays where it is while no path time passes and it is told the same.
///
/// # Errors
/// The first [`Violation`].
pub fn bears_suspension<G: Generator>(
    make: impl Fn() -> G,
    given: impl Fn(u64) -> Given<G>,
) -> Result<(), Violation> {
    suspensions(&Facts::of::<G>(), &|how| run(make(), &given, how))
}

fn suspensions(facts: &Facts, run: &dyn Fn(&How<'_>) -> Run) -> Result<(), Violation> {
    let free = run(&How::FREELY);
    if is_blind(facts.next_uses) && free.end == End::Done {
        for at in 0..free.demands.len() {
            let run = run(&How { dt: &suspended(at), ..How::FREELY });
            let off = match (free.demands.last(), run.demands.last()) {
                (Some(a), Some(b)) => difference(a, b),
                (_, _) => f64::INFINITY,
            };
            ensure(run.end == End::Done && off <= TOLERANCE, || {
                format!("suspended in step {at} it ends ({:?}) {off} from where it should", run.end)
            })?;
        }
        return Ok(());
    }
    let length = free.demands.len();
    for at in [1, length / 7, length / 2, length.saturating_sub(2)] {
        let dt = |i| if i <= at { DT } else { 0.0 };
        let run = run(&How { dt: &dt, known: &|step| step.min(at as u64), only_named: false });
        let Some(here) = run.demands.get(at) else { continue };
        for (i, demand) in run.demands.iter().enumerate().skip(at + 1).take(100) {
            let off = difference(here, demand);
            ensure(off <= TOLERANCE, || {
                format!("without path time it moves by {off} from step {at} to {i}")
            })?;
        }
    }
    Ok(())
}

/// No next step allocates; `allocated` counts the bytes so far.
///
/// # Errors
/// The first [`Violation`].
pub fn allocates_nothing<G: Generator>(
    mut generator: G,
    given: impl Fn(u64) -> Given<G>,
    allocated: impl Fn() -> usize,
) -> Result<(), Violation> {
    let tick = |step| Tick { step, dt: DT, duration: DT };
    let Given { order, e, v } = given(0);
    let first = generator.first_step(&order, &e, &v, tick(0));
    ensure(first.is_ok(), || "a fault in the first step".into())?;
    for step in 1..MOST as u64 {
        let Given { order, e, v } = given(step);
        let before = allocated();
        let stepped = generator.next_step(&order, &e, &v, tick(step));
        let bytes = allocated() - before;
        match stepped {
            Ok(Step::Next(_)) => {}
            Ok(Step::Done) | Err(_) => break,
        }
        ensure(bytes == 0, || format!("step {step} allocates {bytes} bytes"))?;
    }
    Ok(())
}

/// Tests of a generator; see [`conformance`](mod@crate::conformance).
#[macro_export]
macro_rules! generator_conformance {
    (
        $name:ident: $generator:ty,
        class: $class:expr,
        make: $make:expr,
        given: $given:expr,
        odd: $odd:expr
        $(, allocated: $allocated:path)? $(,)?
    ) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;
            use $crate::conformance;

            fn kept(outcome: Result<(), conformance::Violation>) {
                if let Err(violation) = outcome {
                    panic!("{violation}");
                }
            }

            fn make() -> $generator {
                $make
            }

            fn given(step: u64) -> conformance::Given<$generator> {
                let given: fn(u64) -> conformance::Given<$generator> = $given;
                given(step)
            }

            #[test]
            fn it_has_its_class_and_looks_at_nothing_else() {
                kept(conformance::has_its_class(make, given, $class));
            }

            #[test]
            fn equal_runs_are_equal_to_the_bit() {
                kept(conformance::is_deterministic(make, given));
            }

            #[test]
            fn it_demands_finite_numbers_and_ends_without_a_fault() {
                kept(conformance::demands_finite_numbers(make, given));
            }

            #[test]
            fn odd_numbers_are_refused_or_harmless() {
                let odd: fn(f64) -> Vec<$generator> = $odd;
                kept(conformance::refuses_odd_numbers(given, odd));
            }

            #[test]
            fn suspended_in_any_step_it_ends_where_it_should_or_stays() {
                kept(conformance::bears_suspension(make, given));
            }

            $(
                #[test]
                fn no_next_step_allocates() {
                    kept(conformance::allocates_nothing(make(), given, $allocated));
                }
            )?
        }
    };
}
