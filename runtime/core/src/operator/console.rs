//! The operator's console as an MP meets it: buttons come in, what the MP does goes out.

use super::button::Button;
use super::state::MpState;

/// Where an MP hears its operator and shows what it does. Each method has an answer for an MP without a console.
pub trait Console {
    /// The button of a kind that the operator has pressed, and the number of that press, once.
    fn pressed(&self, _kind: usize) -> Option<(u64, Button)> {
        None
    }

    /// Shows what an MP does to whoever looks. It is called in every step and neither waits nor allocates.
    fn show(&self, _state: &MpState) {}
}

/// An MP that has no console: the [`Operator`](super::Operator)'s own handle is all that acts on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoConsole;

impl Console for NoConsole {}
