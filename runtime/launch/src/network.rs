//! What carries messages between the machines of a cell: a crate of its own, which a program joins in its `main`.
//!
//! In: the nodes of the cell, and which one this is. Out: wires to the others. The receiver of a message knows which node
//! has sent it, because a network lets nobody speak for another node.

use std::fmt::Debug;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use mrroc_core::cell::{Node, Nodes};

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
pub struct Joining<'a> {
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
    fn join(&self, joining: &Joining<'_>, hears: Arc<dyn Hears>) -> Result<Box<dyn Wires>, String>;

    /// Makes certificates for these nodes, in a folder that is not there or empty. Returns what was made and where to put it.
    ///
    /// # Errors
    /// What could not be made.
    fn certify(&self, nodes: &[Node], folder: &Path) -> Result<String, String>;
}

/// Who hears what comes from other nodes. It is called in threads of the network, and must not wait.
pub trait Hears: Send + Sync {
    /// This has come from the node at a place of the list.
    fn came(&self, from: usize, bytes: &[u8]);

    /// A node is there.
    fn is_there(&self, node: usize);

    /// A node is gone, or cannot be reached any more.
    fn is_lost(&self, node: usize);
}

/// The way to the other nodes.
pub trait Wires: Send + Sync {
    /// Sends this to a node. What is sent to one node comes in the order in which it was sent, as long as the node is there;
    /// what is sent to one that is not there is lost. It may wait while the network does not take more.
    fn send(&self, to: usize, bytes: &[u8]);
}
