//! The kinds of robots that a cell file may name.

use mrroc_core::cell::{AnyRobot, CellError, RobotSetup};
use mrroc_core::robot::Robot;

use super::entry::RobotEntry;

type Make = Box<dyn Fn(&RobotEntry) -> Result<Box<dyn AnyRobot>, CellError>>;

/// The kinds of robots that a program knows, each with the function that makes a set-up: the model and the drives.
#[derive(Default)]
pub struct Kinds(Vec<(String, Make)>);

impl Kinds {
    /// No kinds.
    #[must_use]
    pub fn new() -> Kinds {
        Kinds::default()
    }

    /// Adds the kind that the file calls `name`. If the kind exists already, its set-up is replaced, for example to use
    /// the drives of a real robot in place of simulated ones.
    #[must_use]
    pub fn with<R: Robot>(
        mut self,
        name: &str,
        set_up: impl Fn(&RobotEntry) -> Result<RobotSetup<R>, CellError> + 'static,
    ) -> Kinds {
        let make: Make = Box::new(move |entry| {
            let mut setup = set_up(entry)?;
            if !entry.is_homed() && setup.is_homed() {
                return Err(entry.refuse_unhomed());
            }
            // The name of a robot comes from the file and not from its set-up.
            setup.rename(entry.name());
            Ok(Box::new(match entry.tool {
                Some(tool) => setup.tool(tool),
                None => setup,
            }))
        });
        self.0.retain(|(known, _)| known != name);
        self.0.push((name.to_owned(), make));
        self
    }

    pub(super) fn set_up(&self, entry: &RobotEntry) -> Result<Box<dyn AnyRobot>, CellError> {
        match self.0.iter().find(|(name, _)| name == entry.kind()) {
            Some((_, make)) => make(entry),
            None => {
                let known: Vec<_> = self.0.iter().map(|(name, _)| &**name).collect();
                Err(entry.unknown_kind(&known))
            }
        }
    }
}
