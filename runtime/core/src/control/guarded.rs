//! Code of the user's in a process of the runtime.
//!
//! In: a call of a driver, an observer or a robot's kinematics. Out: what it returned; its panic is a fault.

use core::any::Any;

use crate::model::fault::Fault;

/// Runs code of the user's, a driver, an observer, a robot's kinematics; its panic is a fault of the process.
pub(crate) fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, Fault> {
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)) {
        Ok(returned) => Ok(returned),
        Err(panic) => Err(told(panic)),
    }
}

/// Once for all kinds of code, of which there are hundreds.
#[cold]
#[inline(never)]
fn told(panic: Box<dyn Any + Send>) -> Fault {
    crate::model::fault::panicked(&*panic)
}
