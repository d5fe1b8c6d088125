//! Jobs: what a controller is asked for that takes longer than a period.
//!
//! In: the time, the controller's connections, and whether its script has called. Out: how far the job has come. Nothing here waits:
//! a job goes on whenever it is asked for.

use core::time::Duration;
use std::io;
use std::net::SocketAddr;

use mrroc_driver_kit::{Cutting, MAX_FRAME};

use super::dashboard::{self, Aim, Dialogue, Next, Outcome};
use super::network::{Connection, Network};
use super::{Job, JobState};

/// How long a controller may take to answer a call.
pub(super) const CALL: Duration = Duration::from_secs(2);

/// How long a script may take to call this machine.
pub(super) const START: Duration = Duration::from_secs(5);

/// How long a person may take to start a program at the pendant.
pub(super) const PLAY: Duration = Duration::from_secs(18);

/// How long a protective stop is tried to be released: a controller lets that be done five seconds after it.
pub(super) const UNLOCK: Duration = Duration::from_secs(10);

/// Where a controller is asked for something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Addresses {
    pub dashboard: SocketAddr,
    pub secondary: SocketAddr,
}

/// A job that goes on.
#[derive(Debug)]
pub(super) struct Running<N: Network> {
    addresses: Addresses,
    aim: Aim,
    /// The script that is sent.
    script: String,
    stage: Stage<N>,
    /// The script's call is waited for.
    pub starts: bool,
    until: Duration,
    late: &'static str,
}

/// How far it has come.
enum Stage<N: Network> {
    /// Nothing is to be done.
    Waits,
    /// It cannot be done.
    Refused(&'static str),
    /// The dashboard is called.
    CallsDashboard(N::Call),
    /// The dashboard is asked.
    Asks(N::Connection, Dialogue),
    /// The secondary interface, which takes scripts, is called.
    CallsSecondary(N::Call),
    /// The script has been sent. The connection is kept and listened to: one that is closed with something unread takes what was sent with it.
    Sent(N::Connection),
}

impl<N: Network> core::fmt::Debug for Stage<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Stage::Waits => "Waits",
            Stage::Refused(_) => "Refused",
            Stage::CallsDashboard(_) => "CallsDashboard",
            Stage::Asks(..) => "Asks",
            Stage::CallsSecondary(_) => "CallsSecondary",
            Stage::Sent(_) => "Sent",
        })
    }
}

/// The stream of the secondary interface: nothing in it is looked at.
fn unread(bytes: &[u8]) -> Cutting {
    if bytes.is_empty() { Cutting::More } else { Cutting::Frame(bytes.len().min(MAX_FRAME)) }
}

impl<N: Network> Running<N> {
    /// Begins a job now. `offers`: a program node of the pendant is given the script when it asks for one.
    pub(super) fn begin(network: &mut N, job: Job, addresses: Addresses, offers: bool) -> Running<N> {
        const NOT_CALLED: &str = "the script was sent, and does not call this machine";
        const NOT_PLAYED: &str =
            "start the program with the External Control node at the pendant, then reset";
        let (aim, timeout, late) = match (&job, offers) {
            (Job::Start(_), false) => (Aim::Ask, START, NOT_CALLED),
            (Job::Start(_), true) => (Aim::Ask, START, NOT_PLAYED),
            (Job::Offer(_), _) => (Aim::Ask, PLAY, NOT_PLAYED),
            (Job::Unlock, _) => (Aim::Unlock, UNLOCK, "the controller does not release it"),
        };
        let until = network.now() + timeout;
        let starts = aim == Aim::Ask;
        let (script, stage) = match job {
            Job::Offer(_) if offers => (String::new(), Stage::Waits),
            Job::Offer(_) => {
                (String::new(), Stage::Refused("no address was given at which External Control asks"))
            }
            Job::Start(script) => (script, call_dashboard(network, addresses)),
            Job::Unlock => (String::new(), call_dashboard(network, addresses)),
        };
        Running { addresses, aim, script, stage, starts, until, late }
    }

    /// How far it has come at this time; [`JobState::Busy`] while it goes on, or the script has been sent and not called.
    pub(super) fn poll(&mut self, network: &mut N) -> JobState {
        let now = network.now();
        // As many steps as can be done now.
        loop {
            let (stage, is_over) = match core::mem::replace(&mut self.stage, Stage::Waits) {
                Stage::Waits => (Stage::Waits, true),
                Stage::Refused(why) => return JobState::Refused(why),
                Stage::CallsDashboard(mut call) => match network.called(&mut call) {
                    None => (Stage::CallsDashboard(call), true),
                    Some(Ok(connection)) => {
                        (Stage::Asks(connection, Dialogue::new(self.aim, now, self.until)), false)
                    }
                    Some(Err(_)) => match self.take(network, Outcome::Silent) {
                        Ok(stage) => (stage, false),
                        Err(state) => return state,
                    },
                },
                Stage::Asks(mut connection, mut dialogue) => {
                    let is_open = connection.is_open();
                    let line = connection.oldest();
                    let had_line = line.is_some();
                    match dialogue.poll(now, line.map(|line| line.bytes), is_open) {
                        Next::Wait => (Stage::Asks(connection, dialogue), !had_line),
                        Next::Send(command) => {
                            // A connection that is lost is told when it is read.
                            let _ = connection.send(format!("{command}\n").as_bytes());
                            (Stage::Asks(connection, dialogue), false)
                        }
                        Next::Over(outcome) => match self.take(network, outcome) {
                            Ok(stage) => (stage, false),
                            Err(state) => return state,
                        },
                    }
                }
                Stage::CallsSecondary(mut call) => match network.called(&mut call) {
                    None => (Stage::CallsSecondary(call), true),
                    Some(called) => match called.and_then(|connection| send(connection, &self.script)) {
                        Ok(connection) => (Stage::Sent(connection), false),
                        Err(_) => return REFUSED,
                    },
                },
                Stage::Sent(mut connection) => {
                    while connection.oldest().is_some() {}
                    (Stage::Sent(connection), true)
                }
            };
            self.stage = stage;
            if is_over {
                return JobState::Busy;
            }
        }
    }

    /// Goes on after the dashboard has said this, or tells what has become of the job.
    fn take(&self, network: &mut N, outcome: Outcome) -> Result<Stage<N>, JobState> {
        match (self.aim, outcome) {
            (_, Outcome::Local) => Err(JobState::Local),
            // PolyScope X has no dashboard.
            (Aim::Ask, _) => Ok(Stage::CallsSecondary(network.call(self.addresses.secondary, CALL, unread))),
            (Aim::Unlock, Outcome::Released) => Err(JobState::Done),
            (Aim::Unlock, Outcome::Held) => Err(JobState::Refused("the controller does not release it")),
            (Aim::Unlock, Outcome::Silent | Outcome::Remote) => {
                Err(JobState::Refused("its dashboard does not answer"))
            }
        }
    }

    /// Why it has taken too long at this time, if it has.
    pub(super) fn late(&self, now: Duration) -> Option<JobState> {
        (now > self.until).then_some(JobState::Refused(self.late))
    }
}

const REFUSED: JobState = JobState::Refused("the controller takes no script at its secondary interface");

fn call_dashboard<N: Network>(network: &mut N, addresses: Addresses) -> Stage<N> {
    Stage::CallsDashboard(network.call(addresses.dashboard, dashboard::ANSWER, dashboard::cut))
}

fn send<C: Connection>(mut connection: C, script: &str) -> io::Result<C> {
    connection.send(script.as_bytes())?;
    Ok(connection)
}
