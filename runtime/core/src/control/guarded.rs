//! Code of the user's in a process of the runtime.
//!
//! In: a call of a driver, an observer or a robot's kinematics. Out: what it returned; its panic is a fault.

use crate::model::fault::Fault;

/// Runs code of the user's, a driver, an observer, a robot's kinematics; its panic is a fault of the process.
pub(crate) fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, Fault> {
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
    caught.map_err(|panic| crate::model::fault::panicked(&*panic))
}
