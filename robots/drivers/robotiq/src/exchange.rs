//! The exchange of registers with a gripper, in a thread of its own: as fast as the device answers, whatever the EDP's periods.
//!
//! In: the newest position that is demanded. Out: the newest status, the speed of the fingers, and why it has ended. Both
//! sides hand this over in atomics, so that neither waits for the other.

#![expect(
    clippy::disallowed_methods,
    reason = "the exchange keeps the device's time, outside of the cell's periods"
)]

use core::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use core::time::Duration;
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::Instant;

use mrroc::robot::{DriveFault, RobotStop, StopCause};
use mrroc_driver_kit::{Handed, Number, Recalled, Speed, Talk, Watch};
use mrroc_modbus::client::{Broken, Client, lost};
use mrroc_modbus::message::{Asked, NoAnswer, Table};

use crate::drives::RobotiqSettings;
use crate::registers::{Fingers, REQUEST, Request, STATUS, Status};

/// The shortest time from one exchange to the next: a gripper takes 200 a second at most.
const PAUSE: Duration = Duration::from_millis(5);

/// How long the fingers may go on moving by what somebody else has told them, when the drives are opened.
const SETTLING: Duration = Duration::from_secs(6);

/// How long the gripper may take to become inactive, and to activate itself.
const RESET: Duration = Duration::from_secs(1);
const ACTIVATION: Duration = Duration::from_secs(20);

/// Exchanges after which a position that was told must have arrived.
const ECHOES: u32 = 100;

/// The fastest that fingers go: demands, not this, say how fast they are.
const SPEED: u8 = 255;

/// Whether the gripper may be activated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inactive {
    /// One that is not active is refused.
    Refused,
    /// One that is not active is activated, while that is [asked for](Link::ask_for_activation).
    Activated,
}

/// What the thread and the drives hand to each other.
#[derive(Debug, Default)]
struct Shared {
    /// The position and the force that are demanded, in the gripper's numbers.
    position: AtomicU8,
    force: AtomicU8,
    /// The newest status; the speed in the gripper's numbers a second.
    status: AtomicU64,
    speed: Number,
    socket: OnceLock<TcpStream>,
}

impl Handed for Shared {
    fn hang_up(&self) {
        // The other end may have closed it already.
        let _ = self.socket.get().map(|socket| socket.shutdown(Shutdown::Both));
    }
}

/// What the gripper says, as the drives see it.
#[derive(Clone, Copy, Debug)]
pub struct Heard {
    pub status: Status,
    /// The speed of the fingers, in its numbers a second: positive while they close.
    pub speed: f64,
}

/// An exchange that goes on.
#[derive(Debug)]
pub struct Link {
    talk: Talk<Shared, DriveFault>,
    /// How old the newest reading may be: an exchange is two questions.
    patience: Duration,
}

impl Link {
    /// Begins to connect, and returns.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(settings: &RobotiqSettings, inactive: Inactive) -> Result<Link, DriveFault> {
        let settings = *settings;
        let shared = Shared { force: AtomicU8::new(settings.force), ..Shared::default() };
        let work = move |shared: &Shared, watch: &Watch| exchange(shared, watch, &settings, inactive);
        let talk = Talk::begin("gripper", shared, CLOSED, work);
        let talk = talk.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
        Ok(Link { talk, patience: settings.patience * 2 })
    }

    /// The newest that was heard; `None` before the fingers are known to stand.
    ///
    /// # Errors
    /// Why nothing more is heard.
    pub fn heard(&self) -> Result<Option<Heard>, DriveFault> {
        self.talk.goes_on()?;
        if !self.talk.watch().has_heard() {
            return Ok(None);
        }
        if self.talk.watch().is_silent_for(self.patience) {
            return Err(lost("no reading came in time"));
        }
        let Shared { status, speed, .. } = self.talk.handed();
        let status = Status::from_word(status.load(Ordering::Relaxed));
        Ok(status.map(|status| Heard { status, speed: speed.get() }))
    }

    /// Where the fingers are held, or were told to go last.
    pub fn position(&self) -> u8 {
        self.talk.handed().position.load(Ordering::Relaxed)
    }

    /// Where they are to go.
    pub fn go_to(&self, position: u8) {
        self.talk.handed().position.store(position, Ordering::Relaxed);
    }

    /// With which force, from the next motion on.
    pub fn press_with(&self, force: u8) {
        self.talk.handed().force.store(force, Ordering::Relaxed);
    }

    /// Lets an activation go on for a while.
    pub fn ask_for_activation(&self) {
        self.talk.ask();
    }
}

impl Recalled for Link {
    type Fault = DriveFault;

    fn has_heard(&self) -> Result<bool, DriveFault> {
        self.heard().map(|heard| heard.is_some())
    }

    /// Ends the exchange: the gripper goes on holding what it was told last.
    fn hang_up(&self) {
        self.talk.hang_up();
    }

    fn is_over(&self) -> bool {
        self.talk.is_over()
    }
}

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the gripper is not connected");

/// What goes on in the thread.
struct Exchange<'a> {
    shared: &'a Shared,
    watch: &'a Watch,
    client: Client,
    patience: Duration,
    /// What was written last.
    told: Option<Request>,
    speed: Speed,
}

fn exchange(
    shared: &Shared,
    watch: &Watch,
    settings: &RobotiqSettings,
    inactive: Inactive,
) -> Result<(), DriveFault> {
    let client = Client::connect(settings.address, settings.unit, settings.patience)?;
    if let Some(socket) = client.socket() {
        // The first of it.
        let _ = shared.socket.set(socket);
    }
    let patience = settings.patience * 2;
    let mut exchange = Exchange { shared, watch, client, patience, told: None, speed: Speed::from(0.0) };
    let mut status = exchange.status()?;
    if !status.is_active() && inactive == Inactive::Activated {
        exchange.activate()?;
        status = exchange.status()?;
    }
    exchange.stand(status)?;
    exchange.follow()
}

impl Exchange<'_> {
    fn goes_on(&self) -> Result<(), DriveFault> {
        if self.watch.ends() { Err(CLOSED) } else { Ok(()) }
    }

    fn read(&mut self) -> Result<Status, Broken> {
        let answer = self.client.ask(Asked::Read(Table::InputRegisters, STATUS, 3))?;
        let &[a, b, c] = answer.registers() else { return Err(NoAnswer::Length.into()) };
        Ok(Status::new([a, b, c]))
    }

    /// The status, asked for again while the device is only busy.
    fn status(&mut self) -> Result<Status, DriveFault> {
        let until = Instant::now() + self.patience;
        loop {
            self.goes_on()?;
            match self.read() {
                Err(Broken::NoAnswer(why)) if why.passes() && Instant::now() < until => {
                    std::thread::sleep(PAUSE);
                }
                answer => return Ok(answer?),
            }
        }
    }

    fn write(&mut self, request: Request) -> Result<(), Broken> {
        self.client.ask(Asked::Write(REQUEST, request.registers()))?;
        self.told = Some(request);
        Ok(())
    }

    /// Activates it, while that is asked for. Where it is not, the fingers stop, and begin anew when it is.
    fn activate(&mut self) -> Result<(), DriveFault> {
        'anew: loop {
            while !self.watch.is_asked() {
                self.goes_on()?;
                std::thread::sleep(PAUSE);
            }
            // Faults are cleared, and an activation begins, where the request to be active rises.
            self.write(Request::Rest)?;
            self.wait_until(RESET, Status::is_reset, NOT_RESET)?;
            self.write(Request::Activate)?;
            let until = Instant::now() + ACTIVATION;
            loop {
                let status = self.status()?;
                if status.is_active() {
                    return Ok(());
                }
                if let Some(stop) = status.stop().filter(|_| status.must_be_activated_anew()) {
                    return Err(stop.into());
                }
                if !self.watch.is_asked() {
                    self.write(Request::Rest)?;
                    continue 'anew;
                }
                if Instant::now() > until {
                    self.write(Request::Rest)?;
                    return Err(NOT_ACTIVATED);
                }
                std::thread::sleep(PAUSE);
            }
        }
    }

    /// Waits for a state for so long.
    fn wait_until(
        &mut self,
        patience: Duration,
        is_so: fn(Status) -> bool,
        otherwise: DriveFault,
    ) -> Result<Status, DriveFault> {
        let until = Instant::now() + patience;
        loop {
            let status = self.status()?;
            if is_so(status) {
                return Ok(status);
            }
            if Instant::now() > until {
                return Err(otherwise);
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Learns where the fingers are held, once they stand. Nothing is written.
    fn stand(&mut self, status: Status) -> Result<(), DriveFault> {
        // It may have been told nothing before, which it calls a fault until it is.
        let status = match status.is_idle() {
            true => self.wait_until(RESET, |status| !status.is_idle(), IDLE)?,
            false => status,
        };
        healthy(status)?;
        // Where it goes to no position it stands.
        let stands = |status: Status| !status.goes() || status.fingers() != Fingers::Moving;
        let status = self.wait_until(SETTLING, stands, MOVED_BY_OTHERS)?;
        let position = if status.goes() { status.told() } else { status.position() };
        self.shared.position.store(position, Ordering::Relaxed);
        self.speed = Speed::from(status.position().into());
        self.show(status);
        Ok(())
    }

    /// Exchanges until it is to end: writes what is demanded, once that is something else than what holds the fingers,
    /// and reads.
    fn follow(&mut self) -> Result<(), DriveFault> {
        let held = self.shared.position.load(Ordering::Relaxed);
        let mut unheard = 0;
        let mut next = Instant::now();
        loop {
            self.goes_on()?;
            let position = self.shared.position.load(Ordering::Relaxed);
            let force = self.shared.force.load(Ordering::Relaxed);
            let request = Request::GoTo { position, speed: SPEED, force };
            let is_news = self.told != Some(request);
            // What somebody has closed with another force keeps it until it is moved.
            let is_held = position == held && !matches!(self.told, Some(Request::GoTo { .. }));
            let asked = if is_held { self.read() } else { self.write(request).and_then(|()| self.read()) };
            match asked {
                Ok(status) => {
                    healthy(status)?;
                    let differs = !is_held && !is_news && (status.told() != position || !status.goes());
                    unheard = if differs { unheard + 1 } else { 0 };
                    if unheard > ECHOES {
                        return Err(TOLD_BY_OTHERS);
                    }
                    self.show(status);
                }
                // The drives see how old the newest reading is.
                Err(Broken::NoAnswer(why)) if why.passes() => {
                    if self.watch.is_silent_for(self.patience) {
                        return Err(lost(why.name()));
                    }
                }
                Err(broken) => return Err(broken.into()),
            }
            next = (next + PAUSE).max(Instant::now());
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
    }

    fn show(&mut self, status: Status) {
        if let Some(speed) = self.speed.at(status.position().into()) {
            self.shared.speed.set(speed);
        }
        self.shared.status.store(status.to_word(), Ordering::Relaxed);
        self.watch.hear();
    }
}

fn healthy(status: Status) -> Result<(), DriveFault> {
    status.stop().map_or(Ok(()), |stop| Err(stop.into()))
}

const IDLE: DriveFault = lost("fault 9: it was told nothing for a second");
const NOT_RESET: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::Failure).named("it does not let itself be reset"));
const NOT_ACTIVATED: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::Failure).named("its activation was not over after 20 s"));
const MOVED_BY_OTHERS: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::PendantInControl).named("somebody else moves its fingers"));
const TOLD_BY_OTHERS: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::PendantInControl)
        .named("somebody else tells it where to go, or it does not take it"),
);
