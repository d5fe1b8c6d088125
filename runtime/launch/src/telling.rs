//! `calibration ROBOT`, `export-urdf ROBOT` and `external NAME`: print what a part of the cell tells of itself.
//!
//! In: a cell, and the name of one of its robots or sensors. Out: the text of the file that the robot's entry names as
//! `calibration`, a URDF, or a Python module.

use std::path::Path;
use std::process::ExitCode;

use mrroc_core::cell::{AnyRobot, Cell};
use mrroc_core::console::{refused, say};
use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::suggestion::suggestion;

use super::cell_file::CellFile;
use super::external;
use super::network::{CertificateRequest, NO_NETWORK, network, run_gateway};

/// What a part of the cell is asked for instead of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PartRequest {
    /// Its calibration, of its controller.
    Calibration,
    /// Itself as a URDF.
    Urdf,
    /// The Python module of the program that sends its readings, or simulates it.
    Python,
    /// To have the processes of a machine of this name.
    Node,
    /// To make certificates for all machines, in a folder of this name.
    Certificates,
    /// To run the gateway of a sensor, for the process of that sensor.
    Gateway,
    /// To show it in a browser.
    Panel,
}

impl PartRequest {
    /// What the first word of a command line asks for.
    pub fn of(word: &str) -> Option<PartRequest> {
        match word {
            "calibration" => Some(PartRequest::Calibration),
            "export-urdf" => Some(PartRequest::Urdf),
            "external" => Some(PartRequest::Python),
            "node" => Some(PartRequest::Node),
            "certificates" => Some(PartRequest::Certificates),
            "gateway" => Some(PartRequest::Gateway),
            "panel" => Some(PartRequest::Panel),
            _ => None,
        }
    }
}

/// Prints what the robot, or the sensor, of this name tells. Nothing moves.
pub(super) fn tell(cell: &mut Cell, file: &Path, name: &str, asked: PartRequest) -> ExitCode {
    match asked {
        PartRequest::Python => external::tell(cell, name),
        PartRequest::Calibration => of_robot(cell, name, calibration),
        PartRequest::Urdf => of_robot(cell, name, urdf),
        PartRequest::Certificates => certificates(cell, file, name),
        PartRequest::Gateway => run_gateway(file, name),
        // What is no word of a robot or a sensor is asked of the processes.
        PartRequest::Node | PartRequest::Panel => refused(&"that is no part of a cell"),
    }
}

/// Makes certificates for the machines of the cell, and for programs on other machines that send what its sensors read.
fn certificates(cell: &Cell, file: &Path, folder: &str) -> ExitCode {
    // A program with a command line of its own may have no cell file.
    let file = match file.exists() {
        false => None,
        true => match CellFile::read(file) {
            Ok(file) => Some(file),
            Err(error) => return refused(&error),
        },
    };
    let gateways: Vec<_> = file.iter().flat_map(CellFile::gateways).collect();
    let nodes = cell.nodes();
    if nodes.is_none() && gateways.is_empty() {
        return refused(
            &"cell.toml has no nodes\n help: write a table [nodes.NAME] for each machine, or `address` into \
              [sensors.NAME.external] for a program on another one",
        );
    }
    let Some(network) = network() else { return refused(&NO_NETWORK) };
    let place = |name: &str| {
        let (nodes, id) = (nodes?, ProcessId::new(Role::Vsp, Name::new(name).ok()?));
        nodes.all().get(nodes.of(id)?).map(|node| node.name.as_str())
    };
    let gateways = gateways
        .iter()
        .filter_map(|gateway| Some((gateway.name(), gateway.address()?, place(gateway.name()))))
        .collect();
    let whom = CertificateRequest { nodes: nodes.map_or(&[], |nodes| nodes.all()), gateways };
    match network.certify(&whom, Path::new(folder)) {
        Ok(told) => say(&told),
        Err(error) => refused(&error),
    }
}

fn of_robot(cell: &mut Cell, name: &str, tell: fn(&mut dyn AnyRobot) -> ExitCode) -> ExitCode {
    let names: Vec<String> = cell.robots_mut().map(|robot| robot.name().to_owned()).collect();
    if let Some(robot) = cell.robots_mut().find(|robot| robot.name() == name) {
        return tell(robot);
    }
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    refused(&format!("no robot `{name}`\n help: {}", suggestion(name, &known, "the cell has")))
}

fn calibration(robot: &mut dyn AnyRobot) -> ExitCode {
    let told = robot.calibration();
    let name = robot.name();
    match told {
        Ok(Some(text)) => say(&text),
        Ok(None) => refused(&format!(
            "the drives of robot `{name}` tell no calibration\n help: leave `calibration` out of its table in cell.toml"
        )),
        Err(fault) => refused(&format!("robot `{name}`: {fault}")),
    }
}

fn urdf(robot: &mut dyn AnyRobot) -> ExitCode {
    match robot.urdf() {
        Some(text) => say(&text),
        None => refused(&format!(
            "robot `{}`, a {}, gives no URDF\n help: a model in Rust gives one by `Robot::urdf`",
            robot.name(),
            robot.kind_name()
        )),
    }
}
