//! Cells of mrroc on several machines: their nodes speak with one another over [zenoh](https://zenoh.io), peer to peer, with
//! certificates on both sides.
//!
//! In: the table `[nodes]` of `cell.toml`, and one line in a program's `main`. Out: the same cell, with robots and sensors on
//! machines of their own.
//!
//! ```no_run
//! # use mrroc_core::cell::Cell;
//! fn main() {
//!     mrroc_launch::network::nodes_over(&mrroc_zenoh::Zenoh);
//!     // and then what it did before: mrroc::launch(cell, film())
//! }
//! ```
//!
//! [`Zenoh`] joins a node to the others (`session`), and opens the `gateway` of a sensor whose program is on another machine;
//! `certificates` are made by `PROGRAM certificates FOLDER`, and `access`
//! says which node may say what. What nodes say to one another, and when robots stop, is none of this crate's business:
//! that is in `mrroc-processes`.

#![forbid(unsafe_code)]

mod access;
mod certificates;
mod gateway;
mod session;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use mrroc_launch::network::{
    CertificateRequest, Gateway, GatewayListener, GatewayPort, JoinOptions, Network, NodeListener, Wires,
};

/// The network of zenoh.
#[derive(Clone, Copy, Debug)]
pub struct Zenoh;

impl Network for Zenoh {
    fn join(
        &self,
        joining: &JoinOptions<'_>,
        hears: Arc<dyn NodeListener>,
    ) -> Result<Box<dyn Wires>, String> {
        session::join(joining, hears).map(|wires| Box::new(wires) as Box<dyn Wires>)
    }

    fn certify(&self, whom: &CertificateRequest<'_>, folder: &Path) -> Result<String, String> {
        certificates::make(whom, folder).map_err(|error| format!("{}: {error}", folder.display()))
    }

    fn open_gateway(
        &self,
        gateway: &Gateway<'_>,
        hears: Arc<dyn GatewayListener>,
    ) -> Result<Box<dyn GatewayPort>, String> {
        gateway::open(gateway, hears).map(|gateway| Box::new(gateway) as Box<dyn GatewayPort>)
    }
}
