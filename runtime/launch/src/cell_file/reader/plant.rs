//! Keys `plant` of tables `[robots.NAME]`.

use core::time::Duration;
use std::rc::Rc;

use mrroc_core::fault::Name;
use toml::de::DeValue;

use super::super::entry::RobotEntry;
use super::super::plant::PlantEntry;
use super::{Reader, Value};

pub(in super::super) const PLANT_KEYS: [&str; 2] = ["port", "timeout_ms"];

/// A process of a cell computes for less than a minute without waiting, or counts as stuck.
const LONGEST: Duration = Duration::from_secs(50);

impl Reader {
    /// Reads in which simulator a robot moves.
    pub(super) fn plant(&mut self, value: &Value<'_>, robot: &str) -> Option<PlantEntry> {
        const FORM: &str = "{ port = \"mujoco\" }";
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, FORM);
            return None;
        };
        self.known(table, &PLANT_KEYS, "a plant has");
        let timeout = match table.get("timeout_ms") {
            None => PlantEntry::TIMEOUT,
            Some(value) => {
                let timeout = self.duration(value)?;
                if timeout > LONGEST {
                    let what = format!("{} ms", timeout.as_millis());
                    let help = format!("write a number of milliseconds up to {}", LONGEST.as_millis());
                    self.complain(&value.span(), what, help);
                }
                timeout
            }
        };
        let Some(port) = table.get("port") else {
            self.complain(
                &value.span(),
                "a plant without `port`".to_owned(),
                format!("write plant = {FORM}"),
            );
            return None;
        };
        let name = self.text(port, "a name, in quotes")?;
        match Name::new(name) {
            Ok(name) => Some(PlantEntry {
                source: Rc::clone(&self.source),
                robot: robot.to_owned(),
                port: name.as_str().to_owned(),
                span: value.span(),
                timeout,
                robots: Vec::new(),
            }),
            Err(bad) => {
                let help = "write port = \"..\" with such a name".to_owned();
                self.complain(&port.span(), bad.to_string(), help);
                None
            }
        }
    }
}

/// Tells each robot in a simulator which others are in it.
pub(super) fn introduce(robots: &mut [RobotEntry]) {
    let places = robots.iter().filter_map(|robot| robot.plant());
    let places: Vec<_> = places.map(|plant| (plant.port.clone(), plant.robot.clone())).collect();
    for plant in robots.iter_mut().filter_map(|robot| robot.plant.as_mut()) {
        let here = places.iter().filter(|(port, _)| *port == plant.port);
        plant.robots = here.map(|(_, robot)| robot.clone()).collect();
    }
}
