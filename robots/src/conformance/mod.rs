//! What every robot must keep, as tests that any robot can run: of this crate or of another.
//!
//! ```ignore
//! mrroc_robots::kinematics_conformance!(irp6, Irp6::nominal(), start());
//! mrroc_robots::driver_conformance!(irp6_drives, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start()), start());
//! mrroc_robots::homing_conformance!(irp6_homing, Irp6::nominal(), |q| Unhomed::new(Irp6::nominal(), q), [start()], jammed);
//! ```
//!
//! Each macro writes a module of tests whose names are sentences; the checks behind them return the first
//! [`Violation`] with the numbers, among them the joint positions, and draw from a stated seed.

mod cell;
mod driver;
mod homing;
mod kinematics;

pub use cell::{bears_lost_demands, ticks_once_a_period};
pub use driver::{comes_to_rest, follows_slowly, is_deterministic, measures_at_rest, refuses};
pub use homing::{finds_its_marks, searches_alike, trips_where_jammed};
pub use kinematics::{
    frames_end_at_the_flange, inverse_returns_poses, jacobian_is_the_derivative, limits_are_sound,
    nothing_is_nan, solutions_are_complete,
};

/// Seed of all random draws.
pub const SEED: u64 = 20_080_131;

/// How many poses inverse kinematics must give back: 100,000, and 10,000 where a build has debug assertions.
pub const POSES: usize = if cfg!(debug_assertions) { 10_000 } else { 100_000 };

/// A promise that a robot does not keep, with the figures.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} (seed {SEED})")]
pub struct Violation(String);

/// A violation unless `holds`.
fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation(what())) }
}

/// Tests of a robot's kinematics: `kinematics_conformance!(module_name, robot, start)`.
///
/// `robot` is an expression of a type that implements [`Kinematics`](crate::Kinematics); `start` is an attainable joint
/// position of it.
#[macro_export]
macro_rules! kinematics_conformance {
    ($name:ident, $robot:expr, $start:expr) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            fn kept(outcome: Result<(), $crate::conformance::Violation>) {
                if let Err(violation) = outcome {
                    panic!("{violation}");
                }
            }

            #[test]
            fn limits_are_finite_in_order_and_hold_the_start() {
                kept($crate::conformance::limits_are_sound(&$robot, &$start));
            }

            #[test]
            fn inverse_returns_poses_to_1e_9() {
                kept($crate::conformance::inverse_returns_poses(&$robot, $crate::conformance::POSES));
            }

            #[test]
            fn solutions_are_distinct_and_each_is_its_own_nearest() {
                kept($crate::conformance::solutions_are_complete(&$robot, 5_000));
            }

            #[test]
            fn the_jacobian_is_the_derivative_of_the_pose() {
                kept($crate::conformance::jacobian_is_the_derivative(&$robot, 2_000));
            }

            #[test]
            fn frames_begin_finite_and_end_at_the_flange() {
                kept($crate::conformance::frames_end_at_the_flange(&$robot, 1_000));
            }

            #[test]
            fn no_answer_is_nan() {
                kept($crate::conformance::nothing_is_nan(&$robot, &$start));
            }
        }
    };
}

/// Tests of a driver: `driver_conformance!(module_name, robot, driver, start)`.
///
/// `driver` is an expression that makes a driver of `robot` at rest at the joint positions `start`.
#[macro_export]
macro_rules! driver_conformance {
    ($name:ident, $robot:expr, $driver:expr, $start:expr) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            fn kept(outcome: Result<(), $crate::conformance::Violation>) {
                if let Err(violation) = outcome {
                    panic!("{violation}");
                }
            }

            #[test]
            fn it_measures_the_start_at_rest_and_its_period_fits_a_step() {
                kept($crate::conformance::measures_at_rest(&$robot, $driver, &$start));
            }

            #[test]
            fn it_follows_a_slow_demand_of_every_joint() {
                kept($crate::conformance::follows_slowly(&$robot, || $driver, &$start));
            }

            #[test]
            fn it_refuses_what_no_drive_can_take_and_keeps_the_cause() {
                kept($crate::conformance::refuses(&$robot, || $driver, &$start));
            }

            #[test]
            fn it_brakes_to_rest_after_a_fault() {
                kept($crate::conformance::comes_to_rest(&$robot, $driver, &$start));
            }

            #[test]
            fn equal_demands_give_equal_motion_to_the_bit() {
                kept($crate::conformance::is_deterministic(&$robot, || $driver, &$start));
            }

            #[test]
            fn a_cell_calls_it_once_a_period() {
                kept($crate::conformance::ticks_once_a_period(&$robot, || $driver));
            }

            #[test]
            fn it_bears_lost_demands_and_programs_that_give_up() {
                kept($crate::conformance::bears_lost_demands(&$robot, || $driver, &$start));
            }
        }
    };
}

/// Tests of homing: `homing_conformance!(module_name, robot, |start| unhomed, starts, |joint| jammed)`.
///
/// The first closure makes drives that do not know that `robot` stands at the joint positions `start`, the second such drives
/// whose `joint`, from 0, does not move; `starts` are several attainable joint positions.
#[macro_export]
macro_rules! homing_conformance {
    ($name:ident, $robot:expr, $unhomed:expr, $starts:expr, $jammed:expr) => {
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            fn kept(outcome: Result<(), $crate::conformance::Violation>) {
                if let Err(violation) = outcome {
                    panic!("{violation}");
                }
            }

            #[test]
            fn it_finds_its_marks_from_everywhere_and_then_stands_within_its_limits() {
                kept($crate::conformance::finds_its_marks(&$robot, $unhomed, &$starts));
            }

            #[test]
            fn equal_searches_are_equal_to_the_bit() {
                kept($crate::conformance::searches_alike(&$robot, $unhomed, &$starts));
            }

            #[test]
            fn a_jammed_motor_ends_the_search_by_its_name() {
                kept($crate::conformance::trips_where_jammed(&$robot, $jammed));
            }
        }
    };
}
