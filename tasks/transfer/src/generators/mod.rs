//! The four motions of the task, a file each: `separate` and `common`, on each level.

mod ecp_common;
mod ecp_separate;
mod mp_common;
mod mp_separate;

pub use ecp_common::Transmit;
pub use ecp_separate::Approach;
pub use mp_common::Carry;
pub use mp_separate::Trigger;
