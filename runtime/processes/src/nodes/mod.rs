//! Cells on several machines.
//!
//! ```text
//!  launcher, MP, local ECPs ..                        ECP and EDP of a robot elsewhere
//!      shared memory, futexes                                shared memory, futexes
//!  carrier `node a`  ───────────── network ─────────────  agent `node b`
//! ```
//!
//! On each machine processes speak over shared memory as in a cell on one. What belongs to a process of another machine, its
//! boards and its futex, a stand-in has here ([`StandIn`](crate::link::StandIn)), and a carrier takes what is written there
//! to the other machine, and writes what comes from there. So no process of a cell knows of a network, no thread of a
//! network is in a process that has steps, and what is late or lost there is as late or lost as anywhere else.
//!
//! In: the cell's [`Nodes`](mrroc_core::cell::Nodes) and a network. On the launcher's machine the [`carrier`] is a process of
//! the cell. On each other machine an [`agent`] waits for a cell, compares what both have, starts the processes of its
//! node from its own executable and cell file, and ends them with the cell or when the other side is gone. [`message`] is
//! what they say, [`identity`] what they compare, [`phase`] how an agent keeps its node's steps with those of the MP,
//! [`link`] what `doctor` finds out about a network.

mod absence;
mod agent;
pub(crate) mod carrier;
mod identity;
pub(crate) mod link;
mod message;
mod phase;
mod pings;
mod run;
pub(crate) mod runs;
mod sending;
mod silence;
