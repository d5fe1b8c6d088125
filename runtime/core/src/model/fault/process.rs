//! Who met a fault.

use core::fmt;

use mrroc_macros::Payload;

use crate::model::name::Name;

/// The role of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Role {
    /// Master process, the coordinator.
    Mp,
    /// Effector control process.
    Ecp,
    /// Effector driver process.
    Edp,
    /// Virtual sensor process.
    Vsp,
    /// The simulated drives of a cell, where they are a process of their own.
    Plant,
    /// What carries the messages of one machine's processes to other machines.
    Node,
}

/// Who a process is: `mp`, `ecp rnt`, `edp rnt`, `vsp force`, `plant`, `node left`; in a lower cell `mp press`, `ecp press.rnt`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcessId {
    /// What it does.
    pub role: Role,
    /// Whose it is; `None` for the plant and the uppermost MP.
    pub name: Option<Name>,
}

impl ProcessId {
    /// The MP.
    pub const MP: ProcessId = ProcessId { role: Role::Mp, name: None };

    /// The simulated drives.
    pub const PLANT: ProcessId = ProcessId { role: Role::Plant, name: None };

    /// The process of a robot, a sensor or a machine.
    #[must_use]
    pub const fn new(role: Role, name: Name) -> ProcessId {
        ProcessId { role, name: Some(name) }
    }

    /// Whether it is a process of a cell that is a robot of another one, `mp press` or `edp press.arm`.
    #[must_use]
    pub fn is_of_lower_cell(&self) -> bool {
        self.cell().is_some()
    }

    /// The name of the cell that it is in, of a process of a lower cell.
    #[must_use]
    pub fn cell(&self) -> Option<Name> {
        match self.role {
            Role::Mp => self.name,
            Role::Ecp | Role::Edp | Role::Vsp => self.name.as_ref().and_then(Name::cell),
            Role::Plant | Role::Node => None,
        }
    }
}

impl fmt::Display for ProcessId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let role = match self.role {
            Role::Mp => "mp",
            Role::Ecp => "ecp",
            Role::Edp => "edp",
            Role::Vsp => "vsp",
            Role::Plant => "plant",
            Role::Node => "node",
        };
        match &self.name {
            Some(name) => write!(f, "{role} {name}"),
            None => f.write_str(role),
        }
    }
}
