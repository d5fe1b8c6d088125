//! Generators that break a promise each, and are found out.

use mrroc::generator::{Class, Generator, Level, Uses};
use mrroc::prelude::*;
use mrroc_generators::conformance::{self, Violation};
use mrroc_robots::Irp6;

use super::kit::{alone, bytes};

/// What it does wrong.
#[derive(Clone, Copy, PartialEq)]
enum Vice {
    None,
    /// Its class does not say that it looks at the robot.
    Peeps,
    /// Demands what is no number.
    Raves,
    /// Counts steps instead of path time.
    Counts,
    /// Allocates.
    Hoards,
    /// Does not do the same twice.
    Dithers,
    /// Counts steps, and never ends.
    Drifts,
}

struct Vicious {
    vice: Vice,
    time: f64,
}

std::thread_local! { static CALLS: std::cell::Cell<u32> = const { std::cell::Cell::new(0) }; }

impl Generator for Vicious {
    type Robots = Irp6;
    type Language = mrroc::generator::Motion;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class::new(Level::Ecp, Uses { state: true, tick: true, ..Uses::NOTHING });

    fn first_step(
        &mut self,
        c0: &Order<()>,
        e: &State<Irp6>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Irp6>, Fault> {
        self.next_step(c0, e, v, t)
    }

    fn next_step(
        &mut self,
        _: &Order<()>,
        e: &State<Irp6>,
        _: &Reading<()>,
        t: Tick,
    ) -> Result<Step<Irp6>, Fault> {
        let goes_by_steps = matches!(self.vice, Vice::Counts | Vice::Drifts);
        self.time += if goes_by_steps { conformance::DT } else { t.dt };
        // All but the one that counts end where the time says, exactly.
        let x = if self.vice == Vice::Counts { self.time + 0.1 * t.dt } else { self.time.min(0.5) };
        if self.time > 0.6 && self.vice != Vice::Drifts {
            return Ok(Step::Done);
        }
        let x = match self.vice {
            Vice::None | Vice::Counts => x,
            Vice::Drifts => self.time,
            Vice::Peeps => e.demanded().pose.translation.x,
            Vice::Raves => f64::NAN,
            Vice::Hoards => *std::hint::black_box(Box::new(x)),
            Vice::Dithers => f64::from(CALLS.replace(CALLS.get() + 1)),
        };
        Ok(Step::Next(Demand::pose(Pose::translation(x, 0.0, 0.0))))
    }
}

/// Which promises a generator with this vice breaks.
fn broken(vice: Vice) -> Vec<&'static str> {
    let make = || Vicious { vice, time: 0.0 };
    let outcomes: [(&str, Result<(), Violation>); 6] = [
        ("class", conformance::has_its_class(make, alone, "ECP f*0(c)")),
        ("determinism", conformance::is_deterministic(make, alone)),
        ("finite", conformance::demands_finite_numbers(make, alone)),
        ("odd", conformance::refuses_odd_numbers(alone, |_| vec![make()])),
        ("suspension", conformance::bears_suspension(make, alone)),
        ("allocation", conformance::allocates_nothing(make(), alone, bytes)),
    ];
    outcomes.iter().filter(|(_, outcome)| outcome.is_err()).map(|(name, _)| *name).collect()
}

#[test]
fn each_vice_is_found_and_virtue_is_not() {
    assert_eq!(broken(Vice::None), [""; 0]);
    assert_eq!(broken(Vice::Peeps), ["class"]);
    assert_eq!(broken(Vice::Raves), ["finite", "odd"]);
    assert_eq!(broken(Vice::Counts), ["suspension"]);
    assert_eq!(broken(Vice::Drifts), ["suspension"]);
    assert_eq!(broken(Vice::Hoards), ["allocation"]);
    let dithers = broken(Vice::Dithers);
    assert!(dithers.contains(&"determinism"), "{dithers:?}");
}

#[test]
fn a_class_that_is_not_the_declared_one_is_told() {
    let make = || Vicious { vice: Vice::None, time: 0.0 };
    let violation = conformance::has_its_class(make, alone, "ECP f*2(c, e)").expect_err("another class");
    assert_eq!(violation.to_string(), "the class is ECP f*0(c), not ECP f*2(c, e)");
}
