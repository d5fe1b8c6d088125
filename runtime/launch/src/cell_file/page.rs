//! Compares the page of the book about `cell.toml` with the keys that the reader knows.

use super::CellFile;
use super::reader::cell::{CELL_KEYS, REALTIME_KEYS, RECORDING_KEYS};
use super::reader::external::EXTERNAL_KEYS;
use super::reader::lower::LOWER_KEYS;
use super::reader::node::NODE_KEYS;
use super::reader::obstacle::{OBSTACLE_KEYS, SHAPE_KEYS};
use super::reader::plant::PLANT_KEYS;
use super::reader::pose::POSE_KEYS;
use super::reader::robot::ROBOT_KEYS;
use super::reader::sensor::SENSOR_KEYS;
use super::reader::signal::{INPUT_KEYS, OUTPUT_KEYS};
use super::reader::tool::TOOL_KEYS;
use super::reader::topic::{PUBLISHED_KEYS, TOPIC_KEYS};

const PAGE: &str = include_str!("../../../../docs/src/cell.md");

/// The tables, by the names that the page gives them and in its order, with the keys of each table.
const TABLES: [(&str, &[&str]); 17] = [
    ("## The cell", &CELL_KEYS),
    ("## A robot", &ROBOT_KEYS),
    ("A pose is", &POSE_KEYS),
    ("### Inputs", &INPUT_KEYS),
    ("### Outputs", &OUTPUT_KEYS),
    ("### A simulator that others wrote", &PLANT_KEYS),
    ("## A tool", &TOOL_KEYS),
    ("## An obstacle", &OBSTACLE_KEYS),
    ("### Its shape", &SHAPE_KEYS),
    ("## A lower cell", &LOWER_KEYS),
    ("## A virtual sensor", &SENSOR_KEYS),
    ("### Readings that a program of another sends", &EXTERNAL_KEYS),
    ("### Messages of ROS 2 as readings", &TOPIC_KEYS),
    ("## A topic of the bridge to ROS 2", &PUBLISHED_KEYS),
    ("## A node", &NODE_KEYS),
    ("## `[realtime]`", &REALTIME_KEYS),
    ("## `[recording]`", &RECORDING_KEYS),
];

#[test]
fn every_key_that_the_reader_knows_and_no_other_is_in_the_page_about_the_cell_file() {
    let mut rest = PAGE;
    for (i, (title, keys)) in TABLES.iter().enumerate() {
        let (_, after) = rest.split_once(title).unwrap_or_else(|| panic!("no part {title}"));
        let end = TABLES.get(i + 1).map_or(after.len(), |(next, _)| after.find(next).unwrap_or(0));
        let told = after[..end].lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
        let mut told: Vec<_> = told.collect();
        let mut known = keys.to_vec();
        told.sort_unstable();
        known.sort_unstable();
        assert_eq!(told, known, "{title}");
        rest = after;
    }
}

#[test]
fn the_example_of_the_page_is_a_cell_file_that_has_every_key() {
    let example =
        PAGE.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    CellFile::parse("cell.md", example).expect("nothing is wrong with it");
    for (_, keys) in TABLES {
        for key in keys {
            let forms = [format!("{key} = "), format!("[{key}"), format!(".{key}]")];
            let is_there = forms.iter().any(|form| example.contains(form));
            assert!(is_there, "{key}");
        }
    }
}
