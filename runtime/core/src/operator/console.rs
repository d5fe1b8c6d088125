//! The operator's console as the processes of a cell meet it: buttons come in, what they do goes out.

use super::button::Button;
use super::state::{EcpState, EdpState, MpState, VspState};

/// Where an MP hears its operator, and where all processes show what they do. Each method has an answer for processes
/// without a console.
pub trait Console {
    /// Whether there is one, on which buttons may be pressed.
    fn is_there(&self) -> bool {
        true
    }

    /// The button of a kind that the operator has pressed, and the number of that press, once.
    fn pressed(&self, _kind: usize) -> Option<(u64, Button)> {
        None
    }

    /// Shows what an MP does to whoever looks. It is called in every step and neither waits nor allocates.
    fn show(&self, _state: &MpState) {}

    /// Shows what the program of an ECP does to whoever looks. It neither waits nor allocates.
    fn show_ecp(&self, _state: &EcpState) {}

    /// Shows what an EDP has told its drives, and what they say of inputs and outputs, whenever a step begins. It neither waits nor
    /// allocates.
    fn show_edp(&self, _state: &EdpState<'_>) {}

    /// Shows what a VSP has aggregated. It neither waits nor allocates.
    fn show_vsp(&self, _state: &VspState<'_>) {}
}

/// A process that has no console: the [`Operator`](super::Operator)'s own handle is all that acts on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoConsole;

impl Console for NoConsole {
    fn is_there(&self) -> bool {
        false
    }
}
