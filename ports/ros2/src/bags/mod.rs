//! Bags: recordings for the tools of ROS 2, trajectories that robots follow, and messages in the place of those of other nodes.

mod export;
mod file;
mod read;
mod series;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use clap::Args;

pub use export::export;
use read::Wanted;
pub use read::{Source, body};

use crate::trajectories::Request;

/// What the command line says of bags.
#[derive(Debug, Args)]
pub struct BagOptions {
    /// Have the robots follow the trajectories of a bag, one after another, when the cell's program takes goals. The bridge keeps running afterwards.
    #[arg(long, value_name = "BAG", conflicts_with = "export_bag")]
    from_bag: Option<PathBuf>,
    /// Take the messages of topics that are sensors of the cell from a bag instead of from other nodes, each as long after the cell's first step as it is after
    /// the first message of the bag.
    #[arg(long, value_name = "BAG", conflicts_with = "export_bag")]
    pub sensors_from_bag: Option<PathBuf>,
    /// The topic of the bag whose trajectories are meant.
    #[arg(long, value_name = "TOPIC", requires = "from_bag")]
    topic: Option<String>,
    /// The robot that the bag's joints belong to; without it their names must say so.
    #[arg(long, value_name = "NAME", requires = "from_bag")]
    pub robot: Option<String>,
    /// The time that the robots have to get to the first point of each trajectory.
    #[arg(long, value_name = "SECONDS", requires = "from_bag", default_value_t = 0.0, value_parser = seconds)]
    approach: f64,
    /// Of joint states in the bag, take points that are at least so many seconds apart.
    #[arg(long, value_name = "SECONDS", requires = "from_bag", default_value_t = 0.0, value_parser = seconds)]
    every: f64,
    /// Write a recording of this cell, RECORDING, as a bag of rosbag2 into this folder, which is made, and end.
    #[arg(long, value_name = "FOLDER", requires = "recording", conflicts_with_all = ["buttons", "goals"])]
    pub export_bag: Option<PathBuf>,
    /// The recording that is exported: a file that `--record` has written.
    #[arg(value_name = "RECORDING", requires = "export_bag")]
    pub recording: Option<PathBuf>,
}

impl BagOptions {
    /// Whether goals of a bag are asked for.
    pub const fn has_goals(&self) -> bool {
        self.from_bag.is_some()
    }

    /// The goals of the bag that was named, if one was.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn goals(&self) -> Result<Option<Vec<Request>>, String> {
        let Some(bag) = &self.from_bag else { return Ok(None) };
        let wanted = Wanted { topic: self.topic.clone(), approach: self.approach, every: self.every };
        Source::at(bag)?.goals(&wanted).map(Some)
    }
}

/// A time on the command line \[s\].
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=600.0).contains(seconds));
    seconds.ok_or_else(|| "it is a number of seconds, 0 to 600".to_owned())
}
