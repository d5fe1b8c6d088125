//! Subscribers, programs of others: what each robot does, and what the coordinator does, in each step.
//!
//! In: what the processes of a cell show. Out: the newest of it at a port, by a thread of each process, which waits for nobody. Who
//! subscribes can change nothing.

mod message;
mod python;
mod subscriber;
#[cfg(test)]
mod tests;

use core::time::Duration;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;
use mrroc::console::complain;
use mrroc::fault::{Fault, FaultWords, Name, ProcessId, Role};
use mrroc::link::Clock;
use mrroc::observe::Subscription;
use mrroc::observe::layout::Layout;
use mrroc::observe::recording::RunRecord;
use mrroc::observe::ring::{Record, Ring, RingError, RingUse, Sink};
use mrroc::observe::step_observer::StepEvent;
use mrroc::payload::Wire;

use crate::port::{Ends, channel, folder, monotonic};
use message::{CellMessage, RobotMessage};
pub use subscriber::{Image, State, StepShown, Subscriber};

/// Messages that wait for a program that subscribes: those of a quarter of a second at 1 kHz.
pub(crate) const KEPT: usize = 256;

/// Records that wait for the thread of a process.
const LENGTH: usize = 1024;

/// How long that thread sleeps when there is nothing to show: a message is so much later at most.
const REST: Duration = Duration::from_millis(4);

/// How long it is waited for at the end.
const TIMEOUT: Duration = Duration::from_secs(3);

/// Its stack, on which iceoryx2 makes services \[bytes\].
const STACK: usize = 2 << 20;

/// Shows a cell to programs of others, which subscribe at a port of this name:
///
/// ```
/// # use mrroc_launch::cell_file::CellFile;
/// # let file = CellFile::parse("cell.toml", r#"
/// # step_ms = 2
/// # robots.arm = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }
/// # "#)?;
/// use mrroc_external::Subscribers;
///
/// let cell = file.cell(&mrroc_robots::simulated())?.shown_to(Subscribers::at("welding"));
/// # let _ = cell;
/// # Ok::<(), mrroc::cell::CellError>(())
/// ```
///
/// `cargo run -- external welding` prints the module for a program in Python.
#[derive(Clone, Debug)]
pub struct Subscribers {
    port: String,
    folder: PathBuf,
}

impl Subscribers {
    /// At the port of this name. Two cells at one port cannot run at a time: the second one is not shown, and says so.
    #[must_use]
    pub fn at(port: &str) -> Subscribers {
        Subscribers { port: port.to_owned(), folder: folder() }
    }
}

impl Subscription for Subscribers {
    fn name(&self) -> &str {
        &self.port
    }

    fn begin(
        &self,
        process: Option<ProcessId>,
        layout: &Layout,
        clock: Clock,
    ) -> Result<Option<Rc<dyn RunRecord>>, String> {
        let is_here = |role, name| process.is_none_or(|here| here == ProcessId::new(role, name));
        let robots = layout.robots.iter().filter_map(|robot| {
            let name = Name::new(&robot.name).ok()?;
            is_here(Role::Edp, name).then_some((name, robot.joints.len()))
        });
        let robots: Vec<_> = robots.collect();
        let has_mp = process.is_none_or(|here| here.role == Role::Mp);
        if robots.is_empty() && !has_mp {
            return Ok(None);
        }
        let port = self.port.clone();
        let about = RingUse {
            length: LENGTH,
            clock,
            rest: REST,
            flush: Duration::MAX,
            timeout: TIMEOUT,
            stack: STACK,
            is_asked_for: Box::new(|_, what| is_shown(what)),
            tell: Arc::new(move |trouble| tell(&port, trouble)),
        };
        let (port, folder) = (self.port.clone(), self.folder.clone());
        let open = move || {
            let show = Show::open(&folder, &port, &robots, has_mp).map_err(io::Error::other)?;
            Ok(Box::new(show) as Box<dyn Sink>)
        };
        let begun = Ring::begin("subscribers", about, Box::new(open)).map_err(|error| error.to_string())?;
        Ok(Some(Rc::new(begun)))
    }

    fn python(&self, layout: &Layout) -> String {
        python::module(&self.port, layout)
    }
}

/// Whether subscribers are shown this.
fn is_shown(what: &StepEvent) -> bool {
    matches!(
        what,
        StepEvent::Step(_) | StepEvent::Image { .. } | StepEvent::Fault { .. } | StepEvent::End { .. }
    )
}

fn tell(port: &str, trouble: &RingError) {
    match trouble {
        // Messages are numbered by their steps: a subscriber sees which are missing.
        RingError::Slow | RingError::Stuck { .. } | RingError::Lost { .. } => {}
        RingError::Failed(why) => complain(&format!("warning: nobody can subscribe at `{port}`: {why}")),
    }
}

/// A robot that is shown.
struct Shown {
    edp: ProcessId,
    joints: usize,
    images: Publisher<ipc::Service, RobotMessage, ()>,
}

/// The thread's end: what is published.
struct Show {
    ends: Ends,
    robots: Vec<Shown>,
    cell: Option<Publisher<ipc::Service, CellMessage, ()>>,
    /// What the coordinator does, as it was published last.
    newest: CellMessage,
}

impl Show {
    /// The name of the service for what a robot does.
    fn images(port: &str, robot: &dyn core::fmt::Display) -> String {
        format!("{port}/{robot}/images")
    }

    /// The name of the service for what the coordinator does.
    fn steps(port: &str) -> String {
        format!("{port}/steps")
    }

    fn open(folder: &Path, port: &str, robots: &[(Name, usize)], has_mp: bool) -> Result<Show, String> {
        let ends = Ends::open(folder)?;
        let taken = || format!("another cell is shown at port `{port}`; give one of them another name");
        let shown = robots.iter().map(|&(name, joints)| {
            let service = channel(&ends.node, &Show::images(port, &name), KEPT)?;
            let images = service.publisher_builder().create().map_err(|_| taken())?;
            Ok(Shown { edp: ProcessId::new(Role::Edp, name), joints, images })
        });
        let shown = shown.collect::<Result<Vec<_>, String>>()?;
        let cell = has_mp.then(|| channel(&ends.node, &Show::steps(port), KEPT)).transpose()?;
        let cell =
            cell.map(|service| service.publisher_builder().create().map_err(|_| taken())).transpose()?;
        Ok(Show { ends, robots: shown, cell, newest: CellMessage::BLANK })
    }

    fn show_cell(&mut self) {
        self.newest.sent = monotonic();
        if let Some(cell) = &self.cell {
            // Nobody may have subscribed, which is nobody's fault.
            let _ = cell.send_copy(self.newest);
        }
    }
}

impl Sink for Show {
    fn put(&mut self, record: &Record) -> io::Result<()> {
        match record.what {
            StepEvent::Image { step, mode } => {
                if let Some(robot) = self.robots.iter().find(|robot| robot.edp == record.by) {
                    let message = RobotMessage::of(step, record.time, mode, robot.joints, record.words());
                    let _ = robot.images.send_copy(RobotMessage { sent: monotonic(), ..message });
                }
            }
            StepEvent::Step(step) => {
                self.newest.begin(record.time, &step);
                self.show_cell();
            }
            StepEvent::Fault { step } | StepEvent::End { step } => {
                let fault = FaultWords::get(record.words()).ok().map(Fault::from);
                self.newest.stopped(step, fault.as_ref(), matches!(record.what, StepEvent::End { .. }));
                self.show_cell();
            }
            _ => {}
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self, _: u64) -> io::Result<()> {
        // A program that was killed has left its ends behind.
        self.ends.node.try_cleanup_dead_nodes();
        Ok(())
    }
}
