//! Tables `[nodes.NAME]`, and on which of them robots and sensors are.

use std::net::SocketAddr;

use mrroc_core::cell::{Node, Nodes};
use mrroc_core::fault::Name;
use mrroc_core::payload::layout_hash;
use mrroc_core::suggestion::suggestion;
use toml::de::DeTable;

use super::super::entry::{RobotEntry, SensorEntry};
use super::super::error::At;
use super::{Reader, Value};

pub(in super::super) const NODE_KEYS: [&str; 2] = ["address", "mp"];

const ADDRESS: &str = "\"192.168.1.2:7447\", this node's address in the network between them and a port";

impl Reader {
    /// Reads the name of the node on which something is; [`nodes`](Reader::nodes) looks whether there is one.
    pub(super) fn node(&mut self, value: &Value<'_>) -> Option<At<String>> {
        let text = self.text(value, "the name of a node, in quotes")?.to_owned();
        Some(At { value: text, span: value.span() })
    }

    /// The nodes, and what is on each; `None` for a cell on one machine.
    pub(super) fn nodes(
        &mut self,
        table: &DeTable<'_>,
        robots: &[RobotEntry],
        sensors: &[SensorEntry],
    ) -> Option<Nodes> {
        let entries = self.entries(table, "nodes");
        let named: Vec<_> = entries.iter().map(|entry| entry.name.value.clone()).collect();
        let mut list: Vec<Node> = Vec::new();
        let mut mps: Vec<(usize, At<bool>)> = Vec::new();
        let first = entries.first().map(|entry| entry.name.span.clone());
        for entry in entries {
            self.known(entry.table, &NODE_KEYS, "a node has");
            if let Some(mp) = entry.table.get("mp").and_then(|value| self.truth(value, "true or false"))
                && mp.value
            {
                mps.push((list.len(), mp));
            }
            let Some(value) = entry.table.get("address") else {
                let what = format!("node `{}` has no `address`", entry.name.value);
                self.complain(&entry.name.span, what, format!("write address = {ADDRESS}"));
                continue;
            };
            let Some(address) = self.address_of_node(value, &list) else { continue };
            if let Ok(name) = Name::new(&entry.name.value) {
                list.push(Node { name, address });
            }
        }
        let unplaced = |at: Option<&At<String>>| at.filter(|at| !named.contains(&at.value)).cloned();
        let placed = robots.iter().map(|robot| robot.node.as_ref());
        let placed: Vec<_> = placed.chain(sensors.iter().map(|sensor| sensor.node.as_ref())).collect();
        for at in placed.into_iter().filter_map(unplaced) {
            let help = match named.is_empty() {
                true => format!("write a table [nodes.{}] with its address", at.value),
                false => suggestion(&at.value, &named.iter().collect::<Vec<_>>(), "the nodes are"),
            };
            self.complain(&at.span, format!("no node `{}`", at.value), help);
        }
        let first = first?;
        let mp = match mps.as_slice() {
            [(mp, _)] => *mp,
            [] => {
                let help = "write mp = true into the table of the node on which you start the cell";
                self.complain(&first, "no node has the MP".to_owned(), help.to_owned());
                return None;
            }
            [_, (_, second), ..] => {
                let help = "leave mp out but in the table of the node on which you start the cell";
                self.complain(&second.span, "two nodes have the MP".to_owned(), help.to_owned());
                return None;
            }
        };
        if !self.errors.is_empty() {
            return None;
        }
        let place = |at: &Option<At<String>>| {
            at.as_ref().and_then(|at| list.iter().position(|node| node.name.as_str() == at.value))
        };
        let mut nodes = Nodes::new(list.clone(), mp, layout_hash(0, &self.source.text));
        let of_robot = |name: &str| {
            let found = robots.iter().find(|robot| robot.name() == name);
            found.and_then(|robot| place(&robot.node)).unwrap_or(mp)
        };
        for robot in robots {
            nodes = nodes.with_robot(Name::new(robot.name()).ok()?, of_robot(robot.name()));
            self.together(robot, robots, &of_robot, &list);
        }
        for sensor in sensors {
            let robot = sensor.of.as_deref().map(of_robot);
            let node = place(&sensor.node).or(robot).unwrap_or(mp);
            nodes = nodes.with_sensor(Name::new(&sensor.name).ok()?, node);
            let readers = sensor.readers.iter().flatten().map(String::as_str);
            let stranger = readers.chain(sensor.of.as_deref()).find(|reader| {
                let reader = of_robot(reader);
                reader != node && reader != mp && node != mp
            });
            if let Some(stranger) = stranger {
                let at = sensor.node.as_ref().map_or(first.clone(), |at| at.span.clone());
                let what = format!(
                    "sensor `{}` is on node `{}` and robot `{stranger}` on node `{}`, and neither has the MP",
                    sensor.name,
                    list[node].name.as_str(),
                    list[of_robot(stranger)].name.as_str()
                );
                let help = format!(
                    "put both on one node, or one of them on `{}`, the node of the MP",
                    list[mp].name.as_str()
                );
                self.complain(&at, what, help);
            }
        }
        Some(nodes)
    }

    fn address_of_node(&mut self, value: &Value<'_>, others: &[Node]) -> Option<SocketAddr> {
        let text = self.text(value, ADDRESS)?;
        let wrong = match text.parse::<SocketAddr>() {
            Err(_) => format!("`{text}` is no address of a network with a port"),
            Ok(address) if address.ip().is_unspecified() || address.port() == 0 => {
                format!("`{text}` is no address at which others could find a node")
            }
            Ok(address) => {
                let node = others.iter().find(|other| other.address == address);
                let gateway = self.gateways.iter().find(|(_, known)| *known == address);
                match (node, gateway) {
                    (Some(other), _) => format!("node `{}` has this address already", other.name.as_str()),
                    (None, Some((sensor, _))) => {
                        format!("the program of sensor `{sensor}` calls at this address")
                    }
                    (None, None) => return Some(address),
                }
            }
        };
        self.complain(&value.span(), wrong, format!("write address = {ADDRESS}"));
        None
    }

    /// Refuses a robot apart from the one on which it is mounted, and apart from others in its simulator.
    fn together(
        &mut self,
        robot: &RobotEntry,
        robots: &[RobotEntry],
        of_robot: &impl Fn(&str) -> usize,
        nodes: &[Node],
    ) {
        let here = of_robot(robot.name());
        let span = robot.node.as_ref().map_or(&robot.name.span, |at| &at.span);
        let apart = |other: &str| (of_robot(other) != here).then(|| nodes[of_robot(other)].name);
        if let Some(on) = robot.mounted_on()
            && let Some(node) = apart(on)
        {
            let what = format!(
                "robot `{}` is mounted on `{on}`, which is on node `{}`",
                robot.name(),
                node.as_str()
            );
            self.complain(span, what, format!("write node = \"{}\" for both", node.as_str()));
        }
        let Some(plant) = robot.plant() else { return };
        let first =
            robots.iter().find(|other| other.plant().is_some_and(|other| other.port() == plant.port()));
        if let Some(first) = first
            && let Some(node) = apart(first.name())
        {
            let what = format!(
                "robot `{}` is in the simulator of `{}`, which is on node `{}`",
                robot.name(),
                first.name(),
                node.as_str()
            );
            self.complain(
                span,
                what,
                format!("write node = \"{}\" for both, or give it another port", node.as_str()),
            );
        }
    }
}
