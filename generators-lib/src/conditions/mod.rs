//! Conditions made of conditions: what a Wait waits for, put together by logic and by time.
//!
//! | written | holds |
//! |---|---|
//! | [`all((a, b))`](all) | when every part holds |
//! | [`any((a, b))`](any) | when at least one part holds |
//! | [`not(a)`](not) | when `a` does not |
//! | [`a.held_for(t)`](ConditionExt::held_for) | when `a` has held in every step for `t` seconds: an on-delay, as for switches that bounce |
//! | [`elapsed(t)`](elapsed()) | when `t` seconds of the Wait have passed |
//! | [`elapsed_since(a, t)`](elapsed_since()) | when `t` seconds have passed since `a` held for the first time |
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc_generators::conditions::{ConditionExt, all, any, elapsed};
//!
//! # struct Camera;
//! # impl Sensor for Camera {
//! #     const KIND: &'static str = "camera";
//! #     type Reading = Seen;
//! #     type Configuration = ();
//! # }
//! # #[derive(Clone, Copy, Payload)]
//! # struct Seen { part: bool }
//! #[condition(mp)]
//! fn part_seen(v: &Reading<(Camera,)>) -> bool {
//!     v.0.reading().is_some_and(|seen| seen.part)
//! }
//!
//! #[condition(mp)]
//! fn closed<R: Robot>(c: &mut Closed<R>, e: &State<(R,)>) -> bool {
//!     e.0.measured().joints[0] < c.width
//! }
//! # struct Closed<R> { width: f64, of: std::marker::PhantomData<R> }
//!
//! fn grasped<R: Robot>(mp: &mut Mp, gripper: &mut mrroc::generator::RobotHandle<R>) -> Result<(), Fault> {
//!     let mut camera = mp.sensor::<Camera>("camera")?;
//!     let closed = Closed { width: 0.06, of: std::marker::PhantomData::<R> };
//!     let grasped = all((part_seen {}, closed.held_for(0.2)));
//!     mp.wait_until((gripper,), (&mut camera,), any((grasped, elapsed(5.0)))).map(drop)
//! }
//! ```
//!
//! **Lists.** The parts of `all` and `any` look at the same robots and read the same sensors, in the same order; a part that
//! looks at no robot or reads no sensor goes with any list. [`separate`] puts parts together that have robots and sensors of
//! their own each. Parts of an ECP that read the coordinator's order read the same type of it, and the first one reads it.
//!
//! **Time** is that of the steps, [`Tick::duration`](mrroc::generator::Tick::duration): it passes at the same pace whatever the
//! operator's speed, and a step that comes late counts for the periods that it skipped. A suspended Wait asks no condition, so no
//! time passes for it.
//!
//! **Every part is asked in every step**, also where the outcome is known before: a timer sees each step, and a fault that a
//! part throws is not missed. Timers count from the first step in which they are asked, and go on where they were when a
//! condition that a Wait gave back is used again: make a new one for each Wait.

mod all;
mod any;
mod elapsed;
mod elapsed_since;
mod group;
mod held_for;
mod not;
mod parts;
mod stopwatch;

pub use all::{All, all};
pub use any::{Any, any};
pub use elapsed::{Elapsed, elapsed};
pub use elapsed_since::{ElapsedSince, elapsed_since};
pub use held_for::{ConditionExt, HeldFor};
pub use not::{Not, not};
pub use parts::{Parts, Separate, separate};
