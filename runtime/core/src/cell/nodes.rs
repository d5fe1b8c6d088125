//! On which machine each process of a cell runs, where they are on several.
//!
//! In: the machines, and where robots and sensors are. Out: the machine of a process.

use std::net::SocketAddr;

use crate::model::fault::{ProcessId, Role};
use crate::model::name::Name;

/// A machine of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Its name, which its certificate bears.
    pub name: Name,
    /// Where the other machines find it.
    pub address: SocketAddr,
}

/// The machines of a cell, and what is where.
///
/// A robot's ECP and EDP are on the robot's node; the MP is on that of the launcher. Each node has a plant of its own, in which
/// the simulated robots of that node move.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nodes {
    nodes: Vec<Node>,
    mp: usize,
    robots: Vec<(Name, usize)>,
    sensors: Vec<(Name, usize)>,
    /// A hash of the cell's file.
    file: u64,
}

impl Nodes {
    /// These nodes, the MP on the one at the place `mp` of the list. `file` is a hash of the cell's file.
    #[must_use]
    pub fn new(nodes: Vec<Node>, mp: usize, file: u64) -> Nodes {
        Nodes { nodes, mp, robots: Vec::new(), sensors: Vec::new(), file }
    }

    /// The same with a robot at a place of the list.
    #[must_use]
    pub fn with_robot(mut self, robot: Name, node: usize) -> Nodes {
        self.robots.push((robot, node));
        self
    }

    /// The same with a virtual sensor at a place of the list.
    #[must_use]
    pub fn with_sensor(mut self, sensor: Name, node: usize) -> Nodes {
        self.sensors.push((sensor, node));
        self
    }

    /// The nodes.
    #[must_use]
    pub fn all(&self) -> &[Node] {
        &self.nodes
    }

    /// The place of the node that has the MP, and the launcher.
    #[must_use]
    pub const fn mp(&self) -> usize {
        self.mp
    }

    /// The node that has the MP, and the launcher.
    #[must_use]
    pub fn first(&self) -> Option<&Node> {
        self.nodes.get(self.mp)
    }

    /// The place of the node of this name.
    #[must_use]
    pub fn position(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.name.as_str() == name)
    }

    /// A hash of the cell's file.
    #[must_use]
    pub const fn file(&self) -> u64 {
        self.file
    }

    /// The place of the node on which a process runs; `None` for the plant, which every node has. What nobody has placed is
    /// with the MP.
    #[must_use]
    pub fn of(&self, process: ProcessId) -> Option<usize> {
        let among = |placed: &[(Name, usize)]| {
            let found = placed.iter().find(|(name, _)| Some(*name) == process.name);
            Some(found.map_or(self.mp, |(_, node)| *node))
        };
        match process.role {
            Role::Mp => Some(self.mp),
            Role::Ecp | Role::Edp => among(&self.robots),
            Role::Vsp => among(&self.sensors),
            Role::Node => self.nodes.iter().position(|node| Some(node.name) == process.name),
            Role::Plant => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robots_processes_are_on_its_node_and_a_plant_is_on_each() {
        let name = |name: &str| Name::new(name).expect("a name");
        let node = |text: &str, port: u16| Node { name: name(text), address: ([127, 0, 0, 1], port).into() };
        let nodes = Nodes::new(vec![node("a", 1), node("b", 2)], 0, 7)
            .with_robot(name("left"), 0)
            .with_robot(name("right"), 1)
            .with_sensor(name("eye"), 1);
        let of = |role, who: &str| nodes.of(ProcessId::new(role, name(who)));
        for role in [Role::Ecp, Role::Edp] {
            assert_eq!((of(role, "left"), of(role, "right")), (Some(0), Some(1)));
        }
        assert_eq!(
            (of(Role::Vsp, "eye"), of(Role::Vsp, "right"), of(Role::Node, "b")),
            (Some(1), Some(0), Some(1))
        );
        assert_eq!((nodes.of(ProcessId::MP), nodes.of(ProcessId::PLANT)), (Some(0), None));
        assert_eq!((nodes.position("b"), nodes.position("c")), (Some(1), None));
    }
}
