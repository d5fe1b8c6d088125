//! Time as the processes of a cell count it.

/// Monotonic time since the cell started \[ns\].
pub type Nanos = u64;

/// Which time a cell runs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The machine's.
    Real,
    /// The cell's own: it goes on when every process has done what was due, as fast as the processor goes.
    Virtual,
}
