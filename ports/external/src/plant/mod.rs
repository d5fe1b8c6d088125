//! The drives of a robot that moves in a simulator that others wrote, such as MuJoCo.
//!
//! In: the position for the end of each servo period. Out: an order at the robot's port, and the state that the simulator answered
//! to the order before. Under the virtual clock that answer is waited for; in real time it is there, or it is late. It is the answer
//! to the order before, so that one simulator can have several robots of a cell: their orders of one period come one after the
//! other, and it makes its step when it has them all.

mod message;
mod python;
#[cfg(test)]
pub(crate) mod tests;

use core::time::Duration;
use std::path::PathBuf;
use std::time::Instant;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use mrroc::console::complain;
use mrroc::link::Clock;
use mrroc::robot::{Begin, DriveFault, MAX_JOINTS, RobotStop, Simulated, Simulator, StopCause};
use mrroc_launch::cell_file::PlantEntry;

use crate::port::{Ends, channel, folder, monotonic};
use message::{LAYOUT, PlantOrder, PlantRequest, PlantState, Says, Untrue, VERSION, name_of};

/// The connection to the simulator in which a robot of `cell.toml` moves, for
/// [`Kinds::plants`](mrroc_launch::cell_file::Kinds::plants):
///
/// ```
/// # use mrroc_launch::cell_file::CellFile;
/// # let file = CellFile::parse("cell.toml", r#"
/// # step_ms = 2
/// # robots.arm = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0], plant = { port = "mujoco" } }
/// # "#)?;
/// let cell = file.cell(&mrroc_robots::simulated().plants(mrroc_external::plant))?;
/// assert_eq!(cell.hardware(), ["robot arm in the simulator at port mujoco"]);
/// # Ok::<(), mrroc::cell::CellError>(())
/// ```
#[must_use]
pub fn plant(entry: &PlantEntry) -> Box<dyn Simulator> {
    Box::new(Plant::new(entry, folder()))
}

/// Orders that wait for a simulator that is slower than its cell.
pub(crate) const ORDERS: usize = 64;

/// For how long answers may be late in a row, of a cell in real time.
const LATE: Duration = Duration::from_millis(100);

/// How often a simulator is asked that has not begun.
const AGAIN: Duration = Duration::from_millis(50);

/// For how long an answer is waited for that another robot has waited for in vain.
const ONCE_MORE: Duration = Duration::from_millis(500);

/// How often it is looked whether a simulator that says nothing has ended.
const LOOK: Duration = Duration::from_millis(100);

const fn lost(why: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(StopCause::CommunicationLost).named(why))
}

const NONE_THERE: DriveFault =
    lost("no simulator is at its port: start it, or run the cell with --simulated");
const SILENT: DriveFault = lost("its simulator does not answer: look at what it prints");
const ENDED: DriveFault = lost("its simulator has ended: start it again");
const TOO_LATE: DriveFault = lost("its simulator answers too late for real time");
const CLOSED: DriveFault = DriveFault::Other("its port to a simulator is not open");
const NO_PORT: DriveFault = DriveFault::Other(
    "its port cannot be opened: another cell has it, or a program made it with other messages; end that",
);
const FAILED: DriveFault =
    DriveFault::Other("its simulator says that it cannot go on: look at what it prints");
const OTHER_VERSION: DriveFault =
    DriveFault::Other("its simulator has another version of the port: make its module anew");
const OTHER_ROBOT: DriveFault = DriveFault::Other("its simulator answers for another robot");
const OTHER_JOINTS: DriveFault = DriveFault::Other("its simulator answers with another number of joints");
const NOT_FINITE: DriveFault = DriveFault::Other("its simulator answers with a number that is not finite");
const NOT_ORDERED: DriveFault = DriveFault::Other("its simulator answers for a period that has not begun");

impl Untrue {
    const fn fault(self) -> DriveFault {
        match self {
            Untrue::Version => OTHER_VERSION,
            Untrue::Robot => OTHER_ROBOT,
            Untrue::Joints => OTHER_JOINTS,
            Untrue::NotFinite => NOT_FINITE,
            Untrue::Failed => FAILED,
        }
    }
}

/// A robot in a simulator.
struct Plant {
    robot: String,
    name: [u8; mrroc::fault::MAX_NAME],
    port: String,
    robots: Vec<String>,
    timeout: Duration,
    folder: PathBuf,
    link: Option<Link>,
}

/// An open port.
struct Link {
    orders: Publisher<ipc::Service, PlantOrder, ()>,
    states: Subscriber<ipc::Service, PlantState, ()>,
    service: PortFactory<ipc::Service, PlantState, ()>,
    /// The next order, as far as it is known.
    order: PlantOrder,
    clock: Clock,
    period: Duration,
    /// The state that was told last, and at the end of which period it was.
    state: Option<Simulated>,
    answered: Option<u64>,
    /// The last period that was ordered, and when.
    ordered: Option<u64>,
    sent: Instant,
    /// Answers that were late, all of them and the last ones in a row.
    late: u64,
    late_in_a_row: u32,
    /// Periods that were ordered.
    periods: u64,
    /// When it was asked to begin last.
    asked: Option<Instant>,
    ends: Ends,
}

impl Plant {
    fn new(entry: &PlantEntry, folder: PathBuf) -> Plant {
        Plant {
            robot: entry.robot().to_owned(),
            name: name_of(entry.robot()),
            port: entry.port().to_owned(),
            robots: entry.robots().to_vec(),
            timeout: entry.timeout(),
            folder,
            link: None,
        }
    }

    /// Opens the port, if it is not open, and begins anew.
    fn begin(&mut self, begin: &Begin<'_>) -> Result<(), DriveFault> {
        let order = PlantOrder {
            version: VERSION,
            kind: PlantRequest::Begin as u32,
            layout: LAYOUT,
            session: monotonic(),
            period: begin.first,
            time: 0,
            length: PlantOrder::length_of(begin.period),
            late: 0,
            clock: u32::from(begin.clock == Clock::Real),
            joints: begin.start.len() as u32,
            robot: self.name,
            demanded: padded(begin.start),
        };
        if self.link.is_none() {
            let ends = Ends::open(&self.folder).map_err(|_| NO_PORT)?;
            let name = |direction: &str| format!("{}/{}/{direction}", self.port, self.robot);
            let orders = channel::<PlantOrder>(&ends.node, &name("orders"), ORDERS).map_err(|_| NO_PORT)?;
            let service = channel::<PlantState>(&ends.node, &name("states"), 1).map_err(|_| NO_PORT)?;
            self.link = Some(Link {
                orders: orders.publisher_builder().create().map_err(|_| NO_PORT)?,
                states: service.subscriber_builder().create().map_err(|_| NO_PORT)?,
                service,
                order,
                clock: begin.clock,
                period: begin.period,
                state: None,
                answered: None,
                ordered: None,
                sent: Instant::now(),
                late: 0,
                late_in_a_row: 0,
                periods: 0,
                asked: None,
                ends,
            });
        }
        if let Some(link) = &mut self.link {
            link.order = order;
            (link.state, link.answered, link.ordered, link.asked) = (None, None, None, None);
            link.late_in_a_row = 0;
        }
        Ok(())
    }
}

/// A joint vector of a message.
fn padded(joints: &[f64]) -> [f64; MAX_JOINTS] {
    core::array::from_fn(|i| joints.get(i).copied().unwrap_or(0.0))
}

/// How long something has been waited for.
struct Wait(Instant);

impl Wait {
    fn begin() -> Wait {
        Wait(Instant::now())
    }

    fn time(&self) -> Duration {
        self.0.elapsed()
    }

    /// A moment: a short one at first, because a simulator may answer at once.
    fn moment(&self) {
        if self.time() < Duration::from_micros(30) {
            core::hint::spin_loop();
        } else {
            std::thread::sleep(Duration::from_micros(20));
        }
    }
}

impl Link {
    fn send(&mut self, kind: PlantRequest) {
        self.order.kind = kind as u32;
        self.order.time = monotonic();
        self.order.late = self.late;
        // Whether somebody takes it, the answer tells.
        let _ = self.orders.send_copy(self.order);
    }

    /// Takes the newest state that belongs to this opening of the port, if one has come.
    fn hear(&mut self, says: Says) -> Result<Option<u64>, DriveFault> {
        let Some(sample) = self.states.receive().ok().flatten() else { return Ok(None) };
        let told = *sample;
        drop(sample);
        // A program whose fields differ has no session, either.
        let is_ours = told.version != VERSION || told.layout != LAYOUT || told.session == self.order.session;
        if !is_ours {
            return Ok(None);
        }
        let state = told.read(&self.order.robot, self.order.joints as usize).map_err(Untrue::fault)?;
        if told.kind != says as u32 {
            return Ok(None);
        }
        self.state = Some(state);
        Ok(Some(told.period))
    }

    /// Asks the simulator to let the robot stand where it begins, every now and then; its answer, once it is there.
    fn ask(&mut self, wait: &Wait) -> Result<Option<Simulated>, DriveFault> {
        if self.hear(Says::Placed)?.is_some() {
            return Ok(self.state);
        }
        if self.asked.is_none_or(|asked| asked.elapsed() >= AGAIN) {
            self.send(PlantRequest::Begin);
            self.asked = Some(Instant::now());
        }
        wait.moment();
        Ok(None)
    }

    /// Whether a simulator has the port, as far as those that were killed have been removed.
    fn is_there(&self) -> bool {
        self.ends.node.try_cleanup_dead_nodes();
        self.service.dynamic_config().number_of_publishers() > 0
    }

    /// Waits for the answer to the last order, if there was one.
    fn await_answer(&mut self, timeout: Duration) -> Result<(), DriveFault> {
        let Some(ordered) = self.ordered else { return Ok(()) };
        let wait = Wait::begin();
        let mut look = LOOK;
        loop {
            match self.hear(Says::Stepped)? {
                Some(period) if period == ordered => return Ok(()),
                Some(period) if period > ordered => return Err(NOT_ORDERED),
                Some(_) | None => {}
            }
            let waited = wait.time();
            // Another robot of this simulator may have waited for long already, while this one could not.
            if waited >= timeout || waited >= ONCE_MORE && self.sent.elapsed() >= timeout {
                return Err(SILENT);
            }
            if waited >= look {
                if !self.is_there() {
                    return Err(ENDED);
                }
                look = waited + LOOK;
            }
            wait.moment();
        }
    }

    /// Takes the newest answer, and counts it if that to the last order is not there.
    fn take_answer(&mut self) -> Result<(), DriveFault> {
        let Some(ordered) = self.ordered else { return Ok(()) };
        // It may be that of a later period, which this robot was too late to order and another one was not.
        self.answered = self.hear(Says::Stepped)?.or(self.answered);
        if self.answered.is_some_and(|answered| answered >= ordered) {
            self.late_in_a_row = 0;
            return Ok(());
        }
        self.late += 1;
        self.late_in_a_row += 1;
        if self.period * self.late_in_a_row < LATE {
            return Ok(());
        }
        Err(if self.is_there() { TOO_LATE } else { ENDED })
    }

    fn step(
        &mut self,
        period: u64,
        demanded: Option<&[f64]>,
        timeout: Duration,
    ) -> Result<Simulated, DriveFault> {
        match self.clock {
            Clock::Virtual => self.await_answer(timeout)?,
            Clock::Real => self.take_answer()?,
        }
        self.order.period = period;
        if let Some(demanded) = demanded {
            self.order.demanded = padded(demanded);
        }
        self.send(if demanded.is_some() { PlantRequest::Follow } else { PlantRequest::StandBy });
        (self.ordered, self.sent) = (Some(period), Instant::now());
        self.periods += 1;
        self.state.ok_or(CLOSED)
    }
}

impl Simulator for Plant {
    fn hardware(&self) -> String {
        format!("robot {} in the simulator at port {}", self.robot, self.port)
    }

    fn python(&self) -> Option<String> {
        Some(python::module(&self.port, &self.robots))
    }

    fn open(&mut self, begin: &Begin<'_>) -> Result<Simulated, DriveFault> {
        self.begin(begin)?;
        let timeout = self.timeout;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let wait = Wait::begin();
        while wait.time() < timeout {
            if let Some(state) = link.ask(&wait)? {
                return Ok(state);
            }
        }
        Err(if link.is_there() { SILENT } else { NONE_THERE })
    }

    fn open_again(&mut self, begin: &Begin<'_>) -> Result<Option<Simulated>, DriveFault> {
        // Between a loss and its end nothing is ordered.
        let is_asked = self.link.as_ref().is_some_and(|link| link.asked.is_some() && link.ordered.is_none());
        if !is_asked {
            self.begin(begin)?;
        }
        let link = self.link.as_mut().ok_or(CLOSED)?;
        link.is_there();
        let placed = link.ask(&Wait::begin());
        if !matches!(placed, Ok(None)) {
            link.asked = None;
        }
        placed
    }

    fn step(&mut self, period: u64, demanded: Option<&[f64]>) -> Result<Simulated, DriveFault> {
        let timeout = self.timeout;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let stepped = link.step(period, demanded, timeout);
        if stepped.is_err() {
            // Its other robots need not wait for this one.
            link.send(PlantRequest::End);
            (link.ordered, link.asked) = (None, None);
        }
        stepped
    }

    fn close(&mut self) {
        let Some(mut link) = self.link.take() else { return };
        link.send(PlantRequest::End);
        if link.late > 0 {
            let Link { late, periods, .. } = link;
            let (robot, port) = (&self.robot, &self.port);
            complain(&format!(
                "note: {robot}: {late} of {periods} answers of the simulator at port `{port}` were late"
            ));
        }
    }
}
