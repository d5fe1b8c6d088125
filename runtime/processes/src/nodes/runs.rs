//! The runs of an agent: it waits for a cell, and has the processes of its node in it.
//!
//! In: what the carrier of the launcher's machine says. Out: one [`Run`] after the other of the cell whose file and program are the
//! same here as there.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use mrroc_core::cell::Cell;
use mrroc_core::console::{complain, refused, say};

use super::agent::{Agent, Event};
use super::message::NodeMessage;
use super::run::Run;

/// Runs the node `name` of the cell of the file at `file`, whose processes are started with `arguments`, until it is ended.
pub(crate) fn run(
    cell: Cell,
    name: &str,
    file: PathBuf,
    (arguments, quiet): (Vec<OsString>, bool),
) -> ExitCode {
    match Agent::join(cell, name, file, (arguments, quiet)) {
        Ok(agent) => serve(&agent),
        Err(error) => refused(&error),
    }
}

/// Takes part in one cell after the other.
fn serve(agent: &Agent) -> ExitCode {
    if !agent.plan.quiet {
        let address = agent.nodes.all()[agent.me].address;
        // Nothing waits for who reads it.
        let _ = say(&format!("node {} waits at {address}\n", agent.name()));
    }
    let mut next = None;
    loop {
        let (session, identity, seal) = match next.take() {
            Some(hello) => hello,
            None => match agent.events.recv() {
                Ok(Event::Came(from, session, NodeMessage::Hello(identity, seal))) if from == agent.mp() => {
                    (session, identity, seal)
                }
                Ok(_) => continue,
                Err(_) => return ExitCode::FAILURE,
            },
        };
        let first = agent.nodes.first().map_or("", |node| node.name.as_str());
        if let Some(why) = agent.own.differs(identity, first) {
            if !agent.plan.quiet {
                complain(&format!("node {}: refused: {why}", agent.name()));
            }
            agent.send(session, &NodeMessage::Refused(why));
            continue;
        }
        match Run::begin(agent, seal) {
            Ok(run) => next = run.go_on(),
            Err(why) => {
                complain(&format!("node {}: {why}", agent.name()));
                agent.send(session, &NodeMessage::Refused(why));
            }
        }
    }
}
