//! Subscribers, programs of others: what each robot does, what the coordinator does, and what sensors read, in each step.
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
use mrroc::observe::step_observer::{ReadingState, StepEvent};
use mrroc::payload::Wire;

use crate::port::{Ends, channel, folder, monotonic};
use message::{CellMessage, ReadingMessage, RobotMessage};
pub use subscriber::{Image, ReadingShown, State, StepShown, Subscriber};

/// Messages that wait for a program that subscribes: images and steps of a quarter of a second at 1 kHz. Readings of all sensors of a process share so many.
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
        let parts = Parts::of(process, layout);
        if parts.robots.is_empty() && !parts.has_mp && parts.readers.is_empty() {
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
            let show = Show::open(&folder, &port, parts).map_err(io::Error::other)?;
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
        StepEvent::Step(_)
            | StepEvent::Image { .. }
            | StepEvent::Reading { state: ReadingState::There, .. }
            | StepEvent::Fault { .. }
            | StepEvent::End { .. }
    )
}

fn tell(port: &str, trouble: &RingError) {
    match trouble {
        // Messages are numbered by their steps: a subscriber sees which are missing.
        RingError::Slow | RingError::Stuck { .. } | RingError::Lost { .. } => {}
        RingError::Failed(why) => complain(&format!("warning: nobody can subscribe at `{port}`: {why}")),
    }
}

/// What of a cell a process shows, or all of them in one.
struct Parts {
    /// Whose images.
    robots: Vec<(Name, usize)>,
    /// Whether what the coordinator does.
    has_mp: bool,
    /// Whose readings: the MP's, and those of ECPs.
    readers: Vec<ProcessId>,
    /// All sensors, with the layouts of their readings.
    sensors: Vec<(Name, u64)>,
}

impl Parts {
    fn of(process: Option<ProcessId>, layout: &Layout) -> Parts {
        let is_here = |role, name| process.is_none_or(|here| here == ProcessId::new(role, name));
        let robots = layout.robots.iter().filter_map(|robot| Some((Name::new(&robot.name).ok()?, robot)));
        let sensors = layout.sensors.iter();
        let layouts = sensors.filter_map(|of| Some((Name::new(&of.name).ok()?, of.reading_layout)));
        let sensors: Vec<_> = layouts.collect();
        let has_mp = process.is_none_or(|here| here.role == Role::Mp);
        let reads = |robot: &String| layout.sensors.iter().any(|sensor| sensor.readers.contains(robot));
        let ecps = robots
            .clone()
            .filter(|(name, robot)| is_here(Role::Ecp, *name) && robot.ecp_program && reads(&robot.name));
        let ecps = ecps.map(|(name, _)| ProcessId::new(Role::Ecp, name));
        let mp = (has_mp && !sensors.is_empty()).then_some(ProcessId::MP);
        let readers = mp.into_iter().chain(ecps).collect();
        let robots = robots.filter(|(name, _)| is_here(Role::Edp, *name));
        let robots = robots.map(|(name, robot)| (name, robot.joints.len())).collect();
        Parts { robots, has_mp, readers, sensors }
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
    /// Who collects readings, and where they go.
    readers: Vec<(ProcessId, Publisher<ipc::Service, ReadingMessage, ()>)>,
    /// All sensors, with the layouts of their readings.
    sensors: Vec<(Name, u64)>,
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

    /// The name of the service for the readings that the ECP of a robot collects, or the MP.
    fn readings(port: &str, robot: Option<&dyn core::fmt::Display>) -> String {
        robot.map_or_else(|| format!("{port}/sensors"), |robot| format!("{port}/{robot}/sensors"))
    }

    fn open(folder: &Path, port: &str, parts: Parts) -> Result<Show, String> {
        let ends = Ends::open(folder)?;
        let robots = parts.robots.iter().map(|&(name, joints)| {
            let images = Show::publisher(&ends, port, &Show::images(port, &name))?;
            Ok(Shown { edp: ProcessId::new(Role::Edp, name), joints, images })
        });
        let robots = robots.collect::<Result<Vec<_>, String>>()?;
        let cell = parts.has_mp.then(|| Show::publisher(&ends, port, &Show::steps(port))).transpose()?;
        let readers = parts.readers.iter().map(|&by| {
            let name = by.name.as_ref().map(|name| name as &dyn core::fmt::Display);
            Ok((by, Show::publisher(&ends, port, &Show::readings(port, name))?))
        });
        let readers = readers.collect::<Result<Vec<_>, String>>()?;
        Ok(Show { ends, robots, cell, readers, sensors: parts.sensors, newest: CellMessage::BLANK })
    }

    fn publisher<M: ZeroCopySend + core::fmt::Debug + 'static>(
        ends: &Ends,
        port: &str,
        service: &str,
    ) -> Result<Publisher<ipc::Service, M, ()>, String> {
        channel(&ends.node, service, KEPT)?
            .publisher_builder()
            .create()
            .map_err(|_| format!("another cell is shown at port `{port}`; give one of them another name"))
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
            StepEvent::Reading { sensor, step, taken, .. } => {
                let readings = self.readers.iter().find(|(by, _)| *by == record.by);
                let known = self.sensors.iter().find(|(name, _)| *name == sensor);
                if let (Some((_, readings)), Some((_, layout))) = (readings, known) {
                    let message =
                        ReadingMessage::of(sensor, *layout, [step, taken], record.time, record.words());
                    let _ = readings.send_copy(ReadingMessage { sent: monotonic(), ..message });
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
