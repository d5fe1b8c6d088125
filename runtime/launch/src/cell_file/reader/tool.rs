//! Entries `[tools.NAME]` and `[frames.NAME]`.

use mrroc_core::nalgebra::{Matrix3, Vector3};
use mrroc_core::pose::Pose;
use mrroc_core::robot::{Load, Tool};
use toml::de::DeTable;

use super::pose::{IN_CELL, ON_FLANGE, POSE_KEYS};
use super::{Entry, Reader};

pub(in super::super) const TOOL_KEYS: [&str; 7] =
    ["xyz", "rpy", "quat_xyzw", "zyz", "mass", "centre", "inertia"];

impl Reader {
    /// Reads a tool: its frame on the flange, and what the flange carries with it.
    pub(super) fn tool(&mut self, Entry { name, table }: Entry<'_>) -> Option<(String, Tool)> {
        self.known(table, &TOOL_KEYS, "a tool has");
        let frame = self.pose_of(table, ON_FLANGE)?;
        let load = self.load(table)?;
        if let Some(wrong) = load.fault() {
            let help =
                "write mass [kg], centre [m] and inertia [kg m²] as they are measured, or leave them out";
            self.complain(&name.span, format!("tool `{}`: {wrong}", name.value), help.to_owned());
            return None;
        }
        Some((name.value, Tool { frame, load }))
    }

    /// Reads a frame in the world.
    pub(super) fn frame(&mut self, Entry { name, table }: Entry<'_>) -> Option<(String, Pose)> {
        self.known(table, &POSE_KEYS, "a frame has");
        Some((name.value, self.pose_of(table, IN_CELL)?))
    }

    /// Reads `mass`, `centre` and `inertia`; each is zero by default.
    fn load(&mut self, table: &DeTable<'_>) -> Option<Load> {
        let mass = match table.get("mass") {
            None => 0.0,
            Some(value) => self.number(value, "a mass [kg]")?.value,
        };
        let mut numbers = |key: &str, count: usize, expected: &str| {
            let Some(value) = table.get(key) else { return Some(vec![0.0; count]) };
            let numbers = self.numbers(value, expected)?;
            if numbers.value.len() != count {
                let what = format!("`{key}` has {} numbers", numbers.value.len());
                self.complain(&numbers.span, what, format!("write {expected}"));
                return None;
            }
            let values: Vec<_> = numbers.value.iter().map(|number| number.value).collect();
            if let [x, y, z] = *values {
                self.ask_about_place([x, y, z], ON_FLANGE, &numbers.span);
            }
            Some(values)
        };
        let centre = numbers("centre", 3, "three numbers [m]");
        let inertia = numbers("inertia", 6, "six numbers, xx, xy, xz, yy, yz, zz [kg m²]");
        let (centre, i) = (centre?, inertia?);
        let inertia = Matrix3::new(i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5]);
        Some(Load { mass, centre: Vector3::new(centre[0], centre[1], centre[2]), inertia })
    }
}
