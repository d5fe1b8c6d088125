//! What the macros make of the code that a programmer writes, and the errors with which they answer mistakes.

mod behaviour;
#[allow(unreachable_pub, dead_code)]
mod cell;
mod diagnostics;
