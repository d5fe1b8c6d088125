//! The command line.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

use clap::Parser;

use crate::bags::BagOptions;

/// Shows the cell to the nodes of ROS 2, and lets them press its buttons.
#[derive(Debug, Parser)]
#[command(name = "ros2")]
pub struct Options {
    /// The file of the cell.
    #[arg(long, value_name = "FILE", default_value = "cell.toml")]
    pub cell: PathBuf,
    /// The domain of DDS, 0 to 232; without it `ROS_DOMAIN_ID`, or 0.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub domain: Option<u16>,
    /// The address of this machine that other participants of DDS are told, and on whose network they are looked for.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub address: IpAddr,
    /// The name of the node.
    #[arg(long, value_name = "NAME", default_value = "cell")]
    pub node: String,
    /// Let other nodes press the buttons of the console, and set the speed: all that reach this machine.
    #[arg(long)]
    pub buttons: bool,
    /// Let other nodes have the robots follow trajectories that the cell's program takes: all that reach this machine.
    #[arg(long)]
    pub goals: bool,
    /// Check the options, what the cell file says of topics, and bags, without DDS and without a cell that runs, and end: with exit status 2 if anything is
    /// wrong.
    #[arg(long, conflicts_with_all = ["export_moveit", "export_bag"])]
    pub check: bool,
    /// Write `moveit_controllers.yaml` and `joint_limits.yaml` for a configuration of MoveIt 2 into this folder, and end.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["export_bag", "from_bag", "sensors_from_bag", "buttons", "goals"])]
    pub export_moveit: Option<PathBuf>,
    #[command(flatten)]
    pub bags: BagOptions,
    /// Options of the cell's own program.
    #[arg(last = true, value_name = "OPTIONS")]
    _own: Vec<std::ffi::OsString>,
}
