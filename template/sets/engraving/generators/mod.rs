//! Motions, a file each; `mrroc-new generator --list` shows those of the library, to be copied and changed.

mod rosette;
pub use rosette::{DEPTH, rosette}; // FILL IN: your curve
