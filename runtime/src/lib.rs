//! `mrroc` extends Rust by the two instructions that programming any number of robots with any sensors needs.
//!
//! **Wait** holds until an initial condition is met. **Move** generates the next state of any number of robots
//! from their states and the readings of any number of virtual sensors, step by step, until a terminal condition.
//! What changes from motion to motion is plugged in as a plain step function: a [`condition`](macro@condition) or a
//! [`generator`](macro@generator).
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc_robots::{Irp6, SimulatedIrp6, Six};
//!
//! /// Turns the column by half a radian in two seconds, smoothly.
//! struct Turn { from: Six, t: f64 }
//!
//! #[generator(mp, first = learn)]
//! fn turn(c: &mut Turn, t: Tick) -> Step<(Irp6,)> {
//!     if c.t >= 2.0 {
//!         return Step::Done;
//!     }
//!     c.t += t.dt;
//!     let u = (c.t / 2.0).min(1.0);
//!     let mut q = c.from;
//!     q[0] += 0.5 * u * u * (3.0 - 2.0 * u);
//!     Step::Next((Demand::joints(q),))
//! }
//!
//! /// Only the first step needs to know where the arm is.
//! fn learn(c: &mut Turn, e: &State<(Irp6,)>, t: Tick) -> Step<(Irp6,)> {
//!     c.from = e.0.demanded().joints;
//!     turn(c, t)
//! }
//!
//! let start = Irp6::READY;
//! let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
//! let report = Cell::new(std::time::Duration::from_millis(2))
//!     .robot(RobotSetup::new("irp6", Irp6::nominal(), arm))
//!     .program(move |mp| {
//!         let mut irp6 = mp.robot::<Irp6>("irp6")?;
//!         mp.move_robots((&mut irp6,), (), Turn { from: start, t: 0.0 })?;
//!         assert!((irp6.measured().joints[0] - 0.5).abs() < 1e-3);
//!         Ok(())
//!     })
//!     .run()?;
//! assert!(report.time.as_secs_f64() > 2.0);
//! # Ok::<(), mrroc::cell::CellError>(())
//! ```
//!
//! A program sees its robots and sensors as typed lists: a motion for `(Rnt, Polycrank)` takes exactly the handles
//! `(&mut rnt, &mut polycrank)`. Which of the coordinator's order, the robots' states and the sensors' readings a step
//! function takes is its [`Class`](generator::Class) (section 6 of the paper). The class decides what is exchanged in a
//! step.
//!
//! ARCHITECTURE.md shows how the processes of a [`Cell`](cell::Cell) run a program; SAFETY.md says what happens after a
//! fault.

#![forbid(unsafe_code)]

mod parts;

pub use mrroc_core::*;

pub use mrroc_launch::cell_file;
pub use mrroc_testing as testing;

/// What a program names most: `use mrroc::prelude::*;`.
pub mod prelude {
    pub use mrroc_core::prelude::*;
    pub use mrroc_launch::cell_file::CellFile;
}

/// The command line of a task program.
pub mod launch {
    pub use mrroc_core::cell::RunPicture;
    pub use mrroc_core::link::Clock;
    pub use mrroc_launch::network::nodes_over;
    pub use mrroc_launch::{Launch, Ran, files, own_number, own_option};

    pub use crate::parts::{launch, program};
}
/// Cells as processes of the operating system.
#[cfg(all(feature = "processes", target_os = "linux"))]
pub use mrroc_processes as processes;
pub use parts::launch;

/// Recordings of a run in an MCAP file, and their replay.
#[cfg(feature = "recording")]
pub use mrroc_recording as recording;
