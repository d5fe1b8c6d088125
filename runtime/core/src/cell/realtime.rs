//! What the processes of a cell ask of the machine: `[realtime]` of `cell.toml`.
//!
//! In: the file's table. Out: for each process a priority, whether its memory stays in place, and a core. Nothing is asked
//! of a machine unless the table is there, and what is asked and not permitted is refused unless the table says otherwise.

use crate::model::fault::{ProcessId, Role};

/// The highest priority that may be asked for: above it are the kernel's own threads.
pub const MAX_PRIORITY: u8 = 95;

/// What to do when the machine does not permit what is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permission {
    /// Nothing runs.
    Required,
    /// The cell runs without it, and says so.
    BestEffort,
}

/// What the processes of a cell ask of the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Realtime {
    /// Whether it runs without what the machine does not permit.
    pub permission: Permission,
    /// Priority under SCHED_FIFO, from 1 to [`MAX_PRIORITY`].
    pub priority: u8,
    /// Whether memory stays in place: no page is fetched in a step.
    pub lock_memory: bool,
    /// Cores for the robots; `None`: all that the process may use. An empty list pins nothing.
    pub cores: Option<Vec<usize>>,
}

impl Realtime {
    /// A priority and memory in its place, where the machine permits them.
    pub const PREFERRED: Realtime =
        Realtime { permission: Permission::BestEffort, priority: 50, lock_memory: true, cores: None };
}

impl Realtime {
    /// The core of a process, of those that it may use. A robot's ECP and EDP share one: on the same core the one wakes
    /// the other three to ten times sooner than across cores. The MP shares the first robot's: of all places that is the
    /// best for it (docs/decisions/0011-processes-and-shared-memory.md). The others run where there is room.
    pub fn core(&self, process: ProcessId, robots: &[ProcessId], usable: &[usize]) -> Option<usize> {
        let cores = self.cores.as_deref().unwrap_or(usable);
        let place = match process.role {
            Role::Mp => 0,
            Role::Ecp | Role::Edp => robots.iter().position(|robot| robot.name == process.name)?,
            Role::Vsp | Role::Plant | Role::Node => return None,
        };
        // With one core there is nothing to choose.
        cores.get(place.checked_rem(cores.len())?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::name::Name;

    fn process(role: Role, name: &str) -> ProcessId {
        ProcessId::new(role, Name::new(name).expect("a name"))
    }

    #[test]
    fn a_robots_processes_share_a_core_and_robots_take_turns() {
        let robots: Vec<_> = ["a", "b", "c"].map(|name| process(Role::Ecp, name)).into();
        let mut realtime =
            Realtime { permission: Permission::Required, priority: 50, lock_memory: true, cores: None };
        for (cores, usable, chosen) in [
            (None, &[0, 1][..], [Some(0), Some(1), Some(0)]),
            (None, &[2, 5, 7], [Some(2), Some(5), Some(7)]),
            (Some(vec![3]), &[0, 1], [Some(3); 3]),
            (Some(vec![]), &[0, 1], [None; 3]),
        ] {
            realtime.cores = cores;
            for (robot, core) in ["a", "b", "c"].into_iter().zip(chosen) {
                for role in [Role::Ecp, Role::Edp] {
                    assert_eq!(realtime.core(process(role, robot), &robots, usable), core);
                }
            }
            assert_eq!(realtime.core(ProcessId::MP, &robots, usable), chosen[0]);
            assert_eq!(realtime.core(process(Role::Vsp, "a"), &robots, usable), None);
        }
    }
}
