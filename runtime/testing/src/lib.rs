//! Fault injection, for tests of the runtime and of programs that run on it.
//!
//! In: a cell. Out: one run of it for each fault in each step, and a verdict on each run.
//!
//! A [`Sweep`] runs a cell many times on the memory link, each time with one fault in one step: a process is killed or
//! stalled; a link loses, doubles, swaps, delays or alters messages; the operator presses a button. In every run it
//! checks what SAFETY.md promises:
//!
//! - the drives get no NaN and nothing beyond a limit of position, velocity or acceleration;
//! - a run that goes on to its end leaves the robots where the undisturbed run does;
//! - a run that stops reports the cause, and all robots stand within the bound that follows from their limits and from
//!   the steps in which a lost peer is noticed;
//! - a robot that stands after the stop does not move again, and no gripper opens;
//! - the run ends.
//!
//! ```
//! use mrroc::testing::{LinkFault, Press, Sweep};
//! use mrroc::prelude::*;
//! use mrroc_robots::{Irp6, SimulatedIrp6};
//!
//! /// Turns the column by 0.02 rad, smoothly, in 0.2 s of path time.
//! struct Turn { t: f64 }
//!
//! #[generator(mp)]
//! fn turn(c: &mut Turn, t: Tick) -> Step<(Irp6,)> {
//!     if c.t >= 0.2 {
//!         return Step::Done;
//!     }
//!     c.t = (c.t + t.dt).min(0.2);
//!     let u = c.t / 0.2;
//!     let mut q = Irp6::READY;
//!     q[0] += 0.02 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
//!     Step::Next((Demand::joints(q),))
//! }
//!
//! let cell = || {
//!     let arm = SimulatedIrp6::new(Irp6::nominal(), &Irp6::READY);
//!     Cell::new(std::time::Duration::from_millis(2))
//!         .robot(RobotSetup::new("irp6", Irp6::nominal(), arm))
//!         .program(|mp| {
//!             let mut irp6 = mp.robot::<Irp6>("irp6")?;
//!             mp.move_robots((&mut irp6,), (), Turn { t: 0.0 }).map(drop)
//!         })
//! };
//! let report = Sweep::new(cell)
//!     .every(25)
//!     .kills()
//!     .stalls(5)
//!     .links(LinkFault::Drop, 1)
//!     .presses(Press::Abort)
//!     .run();
//! assert!(report.is_clean(), "{report}");
//! ```
//!
//! A [`FaultySensor`] replaces a sensor and a [`FaultyDrive`] replaces drives. [`Sweep::own`] runs a cell with one of
//! them, or with any other fault of your own, which begins in a different step in each run.
//!
//! [`Sweep::forking`] injects faults into copies of one run, which makes it possible to cover every step of a long program.
//!
//! A [`RandomOperator`] runs a cell under operators who press what comes to hand, and checks every servo period.
//!
//! A failure names its [`Case`] with the seed; [`Sweep::repeat`] runs that case again.

mod case;
mod channel;
mod check;
mod drive;
mod forks;
mod link;
mod motion_monitor;
mod operator;
mod random;
#[doc(hidden)]
pub mod readers;
mod report;
mod sensor;
mod stage;
mod sweep;
mod trial;
mod verdict;

pub use case::{Case, Channel, Injected, LinkFault, Press, Wire};
pub use drive::{DriveTrouble, FaultyDrive};
pub use motion_monitor::first_beyond_limits;
pub use operator::{OperatorReport, RandomOperator};
pub use report::{Failure, SweepReport, Tally};
pub use sensor::{FaultySensor, SensorFault};
pub use sweep::Sweep;
