//! What carries messages between the machines of a cell: a crate of its own, which a program joins in its `main`.
//!
//! In: the nodes of the cell, and which one this is. Out: wires to the others. The receiver of a message knows which node
//! has sent it, because a network lets nobody speak for another node.

use std::fmt::Debug;
use std::net::SocketAddr;
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};

use mrroc_core::cell::{Node, Nodes};
use mrroc_core::console::refused;

use crate::cell_file::{CellFile, ExternalEntry};

static NETWORK: OnceLock<&'static dyn Network> = OnceLock::new();

/// Lets the nodes of this program's cells speak with one another over `network`. Called once, in the first line of `main`; what
/// is given later counts for nothing.
pub fn nodes_over(network: &'static dyn Network) {
    // Only the first one can be set.
    let _ = NETWORK.set(network);
}

/// The network that this program was given.
#[must_use]
pub fn network() -> Option<&'static dyn Network> {
    NETWORK.get().copied()
}

/// What runs a gateway: the connection of programs on other machines to the sensors of this one.
pub type GatewayRunner = fn(&ExternalEntry, &'static dyn Network) -> Result<(), String>;

static GATEWAY_RUNNER: OnceLock<GatewayRunner> = OnceLock::new();

/// Has the gateways of this program's sensors run by `runner`: the crate of the sensors calls it. What is given later counts for
/// nothing.
pub fn gateways_by(runner: GatewayRunner) {
    // Only the first one can be set.
    let _ = GATEWAY_RUNNER.set(runner);
}

/// What a program without a network is told.
pub(crate) const NO_NETWORK: &str = "this program has no network to other machines\n help: depend on mrroc-zenoh, and write \
     mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh) as the first line of main";

/// Runs the gateway of the sensor `name` of a cell file, until the process that has started this one is gone.
pub(crate) fn run_gateway(cell: &Path, name: &str) -> ExitCode {
    let Some(network) = network() else { return refused(&NO_NETWORK) };
    let Some(run) = GATEWAY_RUNNER.get() else {
        return refused(&format!(
            "sensor `{name}` has no gateway\n help: give it `External` of mrroc-external in the program"
        ));
    };
    let file = match CellFile::read(cell) {
        Ok(file) => file,
        Err(error) => return refused(&error),
    };
    match file.external(name).map_err(|error| error.to_string()).and_then(|entry| run(entry, network)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&error),
    }
}

/// The gateway of one sensor: where the program that sends its readings calls from another machine.
#[derive(Clone, Copy, Debug)]
pub struct Gateway<'a> {
    /// The sensor.
    pub sensor: &'a str,
    /// Where it is called.
    pub address: SocketAddr,
    /// The folder with the gateway's certificate.
    pub keys: &'a Path,
}

/// What a network makes certificates for.
#[derive(Clone, Debug)]
pub struct CertificateRequest<'a> {
    /// The machines of the cell; none for a cell on one.
    pub nodes: &'a [Node],
    /// Of each sensor whose program is on another machine: its name, where it is called, and which node it is on.
    pub gateways: Vec<(&'a str, SocketAddr, Option<&'a str>)>,
}

/// Whether a node calls the others or waits to be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// It calls all others: the launcher's node.
    Calls,
    /// It waits at its own address.
    Waits,
}

/// A node that joins the others.
#[derive(Clone, Copy, Debug)]
pub struct JoinOptions<'a> {
    /// The nodes of the cell.
    pub nodes: &'a Nodes,
    /// Its place among them.
    pub me: usize,
    /// Whether it calls.
    pub side: Side,
    /// The folder with its certificate.
    pub keys: &'a Path,
}

/// A network between nodes.
pub trait Network: Debug + Sync {
    /// Joins. What happens is told to `hears` by threads of the network.
    ///
    /// # Errors
    /// Why this node cannot join, and what to do.
    fn join(&self, joining: &JoinOptions<'_>, hears: Arc<dyn NodeListener>)
    -> Result<Box<dyn Wires>, String>;

    /// Makes certificates for these nodes and gateways, in a folder that is not there or empty. Returns what was made and where to
    /// put it.
    ///
    /// # Errors
    /// What could not be made.
    fn certify(&self, whom: &CertificateRequest<'_>, folder: &Path) -> Result<String, String>;

    /// Opens the gateway of a sensor. Only who has the certificate of that sensor is heard. What happens is told to `hears` by threads
    /// of the network.
    ///
    /// # Errors
    /// Why it cannot be opened, and what to do.
    fn open_gateway(
        &self,
        gateway: &Gateway<'_>,
        hears: Arc<dyn GatewayListener>,
    ) -> Result<Box<dyn GatewayPort>, String>;
}

/// Who hears what comes from other nodes. It is called in threads of the network, and must not wait.
pub trait NodeListener: Send + Sync {
    /// This has come from the node at a place of the list.
    fn came(&self, from: usize, bytes: &[u8]);

    /// A node is there.
    fn is_there(&self, node: usize);

    /// A node is gone, or cannot be reached any more.
    fn is_lost(&self, node: usize);
}

/// Who hears at a gateway. It is called in threads of the network, and must not wait.
pub trait GatewayListener: Send + Sync {
    /// This has come from a program with the certificate of the sensor.
    fn came(&self, bytes: &[u8]);

    /// The program of this number is there.
    fn is_there(&self, program: u64);

    /// The program of this number has ended, or cannot be reached any more.
    fn is_lost(&self, program: u64);
}

/// The connection through a gateway to the programs at it.
pub trait GatewayPort: Send + Sync {
    /// Sends this to all of them; what is sent to none is lost.
    fn send(&self, bytes: &[u8]);
}

/// The connection to the other nodes.
pub trait Wires: Send + Sync {
    /// Sends this to a node. What is sent to one node comes in the order in which it was sent, as long as the node is there;
    /// what is sent to one that is not there is lost. It may wait while the network does not take more.
    fn send(&self, to: usize, bytes: &[u8]);
}
