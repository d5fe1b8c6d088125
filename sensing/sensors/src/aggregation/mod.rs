//! What a program makes of what sensors give: `f_v` (eq. 14), without a cell and without physics.

mod debounce;
mod lateral;
mod passages;

pub use debounce::{Debounce, Edge};
pub use lateral::{Lateral, Laterals};
pub use passages::{Passage, Passages};
