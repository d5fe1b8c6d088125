//! What a cell in real time says when this machine was late: no test can tell anything by such a run.

/// How often a cell is started again that was late.
pub const STARTS: usize = 20;

/// Whether a cell ended because this machine was late.
#[must_use]
pub fn is_late(said: &str) -> bool {
    [
        "the process at the other end is gone",
        "too many steps were missed",
        "demanded acceleration exceeds",
        "demanded velocity exceeds",
    ]
    .iter()
    .any(|kind| said.contains(kind))
}
