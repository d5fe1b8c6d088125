//! Motions, a file each; `mrroc-new generator --list` shows those of the library, to be copied and changed.

mod take;
pub use take::{CLOSE, DOWN, Take};
