//! Programs of others that subscribe to what a cell does while it runs. What shows them the cell is a crate of its own, a [`Subscription`].
//!
//! In: what the processes of a cell show. Out: the same to programs that nobody waits for.

use core::fmt;
use std::rc::Rc;

use crate::model::fault::ProcessId;
use crate::model::time::Clock;
use crate::observe::layout::Layout;
use crate::observe::recording::RunRecord;

/// Shows what happens in a cell to programs of others, while it happens.
pub trait Subscription: fmt::Debug {
    /// By which name programs find the cell.
    fn name(&self) -> &str;

    /// Begins to show what happens in this process; without one in all of them, which are in this process of the operating
    /// system. Nothing, if subscribers are shown nothing of it.
    ///
    /// # Errors
    /// Why nothing can be shown, and what to do. The cell runs all the same.
    fn begin(
        &self,
        process: Option<ProcessId>,
        layout: &Layout,
        clock: Clock,
    ) -> Result<Option<Rc<dyn RunRecord>>, String>;

    /// The Python module by which a program subscribes at a cell of this layout.
    fn python(&self, layout: &Layout) -> String;
}
