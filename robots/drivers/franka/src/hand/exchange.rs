//! What is said to the hand and what it says, in a thread of its own.
//!
//! In: the opening that is demanded. Out: the hand's newest state, or why there is no more of it. A position is told when it has been
//! demanded for [`STANDS`], and one motion at a time; another demand ends a motion that goes on.

#![expect(
    clippy::disallowed_methods,
    reason = "the thread keeps the time of the hand, beside that of the cell's periods"
)]

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::net::SocketAddr;
use std::time::Instant;

use mrroc::fault::Excess;
use mrroc::robot::{DriveFault, RobotStop, StopCause};
use mrroc_driver_kit::{Guest, Handed, Line, Number, Recalled, Speed, Talk, Watch};

use super::drives::HandSettings;
use super::message::{Answer, Outcome, Request, State, VERSION};

/// How long a demand must have stood before it is told: some servo periods and steps.
const STANDS: Duration = Duration::from_millis(20);

/// Demands that differ by less than this are one that stands, and by less than that from the last one that was told are no news \[m\]:
/// what is grasped must not be let go for the last digit of a number.
const SAME: f64 = 1e-7;
const NEWS: f64 = 1e-5;

/// How often the thread looks at what is demanded and what has come.
const PAUSE: Duration = Duration::from_millis(2);

/// How long the hand may take to accept the connection, and to answer it.
const CONNECT: Duration = Duration::from_secs(1);

/// How long the homing may take.
const HOMING: Duration = Duration::from_secs(30);

/// How long the fingers must have stood when the drives are opened, and for how long that is waited for.
const STOOD: Duration = Duration::from_millis(200);
const SETTLING: Duration = Duration::from_secs(6);

/// Fingers that move by less than this \[m\] stand.
const STILL: f64 = 1e-4;

/// Whether the hand may be homed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unhomed {
    /// One that is not homed is refused.
    Refused,
    /// One that is not homed is homed, while that is [asked for](Link::ask_for_homing).
    Homed,
}

/// What the thread and the drives hand to each other.
#[derive(Debug, Default)]
struct Shared {
    /// The opening that is demanded \[m\].
    demanded: Number,
    /// Whether fingers that close grasp.
    presses: AtomicBool,
    /// The newest state: openings \[m\] and speed [m/s].
    width: Number,
    max_width: Number,
    speed: Number,
    is_grasped: AtomicBool,
}

impl Handed for Shared {}

/// What the hand says, as the drives see it.
#[derive(Clone, Copy, Debug)]
pub struct Heard {
    /// The opening \[m\], and its speed [m/s].
    pub width: f64,
    pub speed: f64,
    pub is_grasped: bool,
}

/// An exchange that goes on.
#[derive(Debug)]
pub struct Link {
    talk: Talk<Shared, DriveFault>,
    /// How old the newest state may be.
    silence: Duration,
}

impl Link {
    /// Begins to connect, and returns.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(settings: &HandSettings, presses: bool, unhomed: Unhomed) -> Result<Link, DriveFault> {
        let settings = *settings;
        let shared = Shared { presses: AtomicBool::new(presses), ..Shared::default() };
        let work = move |shared: &Shared, watch: &Watch| exchange(shared, watch, &settings, unhomed);
        let talk = Talk::begin("hand", shared, CLOSED, work);
        let talk = talk.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
        Ok(Link { talk, silence: settings.silence })
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
        // The thread says so as well, unless it is given no time.
        if self.talk.watch().is_silent_for(self.silence) {
            return Err(SILENT);
        }
        let Shared { width, speed, is_grasped, .. } = self.talk.handed();
        let is_grasped = is_grasped.load(Ordering::Relaxed);
        Ok(Some(Heard { width: width.get(), speed: speed.get(), is_grasped }))
    }

    /// Where the fingers stood when they were heard first, or were told to go last \[m\].
    pub fn demanded(&self) -> f64 {
        self.talk.handed().demanded.get()
    }

    /// Where they are to go \[m\].
    ///
    /// # Errors
    /// They do not open or close as far as that.
    pub fn go_to(&self, width: f64) -> Result<(), DriveFault> {
        let limit = if width < 0.0 { 0.0 } else { self.talk.handed().max_width.get() };
        // Where they stand they may stay, by whatever a bit that is beyond.
        if width != self.demanded() && !(0.0..=limit).contains(&width) {
            return Err(DriveFault::exceeded(0, "demanded opening", Excess::new(width, limit, "m")));
        }
        self.talk.handed().demanded.set(width);
        Ok(())
    }

    /// Whether fingers that close grasp, from the next motion on.
    pub fn press(&self, presses: bool) {
        self.talk.handed().presses.store(presses, Ordering::Relaxed);
    }

    /// Lets a homing go on for a while.
    pub fn ask_for_homing(&self) {
        self.talk.ask();
    }
}

impl Recalled for Link {
    type Fault = DriveFault;

    fn has_heard(&self) -> Result<bool, DriveFault> {
        self.heard().map(|heard| heard.is_some())
    }

    /// Ends the exchange: the hand goes on holding what it holds.
    fn hang_up(&self) {
        self.talk.hang_up();
    }

    fn is_over(&self) -> bool {
        self.talk.is_over()
    }
}

const fn stop(cause: StopCause, name: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(cause).named(name))
}

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the hand is not connected");
pub(crate) const NOT_HOMED: DriveFault = DriveFault::Other(
    "the hand is not homed: take out what it holds, then home it in Desk or write homed = false: its fingers will move",
);
pub(crate) const OTHER_VERSION: DriveFault =
    DriveFault::Other("the hand speaks another version of its interface than 3");
const UNREACHABLE: DriveFault =
    stop(StopCause::CommunicationLost, "nothing accepts a connection at its address: is the hand mounted?");
const HUNG_UP: DriveFault = stop(StopCause::CommunicationLost, "connection closed by the robot");
const SILENT: DriveFault = stop(StopCause::CommunicationLost, "no state came in time");
const NO_HAND: DriveFault = stop(StopCause::CommunicationLost, "what answers is no Franka Hand");
const ENDLESS: DriveFault =
    stop(StopCause::ProtectiveStop, "its motion does not end: is something in its way?");
const SHORT: DriveFault =
    stop(StopCause::ProtectiveStop, "it did not come to the opening: is something in its way?");
const BY_OTHERS: DriveFault = stop(StopCause::PendantInControl, "somebody else has ended its motion");
const MOVED_BY_OTHERS: DriveFault = stop(StopCause::PendantInControl, "somebody else moves its fingers");

/// A motion of the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Homing,
    Grasp,
    Move,
}

impl Motion {
    /// Why the hand does not do it.
    const fn failed(self) -> DriveFault {
        let name = match self {
            Motion::Homing => "homing failed: is something in its way?",
            Motion::Grasp => "grasp failed",
            Motion::Move => "move failed",
        };
        stop(StopCause::ProtectiveStop, name)
    }
}

/// A motion that the hand was asked for and has not answered.
#[derive(Clone, Copy, Debug)]
struct Flight {
    id: u32,
    motion: Motion,
    /// The request that ends it.
    stop: Option<u32>,
    /// Since when it, or its stop, is not answered.
    since: Instant,
}

/// What goes on in the thread.
struct Exchange<'a> {
    shared: &'a Shared,
    watch: &'a Watch,
    settings: &'a HandSettings,
    line: Line,
    guest: Guest,
    /// The number of the last request.
    last: u32,
    /// The newest state, and when it came.
    state: Option<State>,
    came: Instant,
    flight: Option<Flight>,
    speed: Speed,
    /// Whether the drives may see the states: the fingers have stood.
    shows: bool,
}

fn exchange(
    shared: &Shared,
    watch: &Watch,
    settings: &HandSettings,
    unhomed: Unhomed,
) -> Result<(), DriveFault> {
    let mut exchange = Exchange::connect(shared, watch, settings)?;
    let state = exchange.first_state()?;
    if state.max_width <= 0.0 {
        match unhomed {
            Unhomed::Refused => return Err(NOT_HOMED),
            Unhomed::Homed => exchange.home()?,
        }
    }
    exchange.stand()?;
    exchange.follow()
}

impl<'a> Exchange<'a> {
    fn connect(
        shared: &'a Shared,
        watch: &'a Watch,
        settings: &'a HandSettings,
    ) -> Result<Exchange<'a>, DriveFault> {
        let line = Line::call(settings.address, CONNECT, Answer::cut).map_err(|_| UNREACHABLE)?;
        let own = line.own_address().map_err(|_| HUNG_UP)?;
        let guest = Guest::expect(SocketAddr::new(own, 0), settings.address.ip())
            .map_err(|_| DriveFault::Other("this machine has no port for the hand's states"))?;
        let now = Instant::now();
        let mut exchange = Exchange {
            shared,
            watch,
            settings,
            line,
            guest,
            last: 0,
            state: None,
            came: now,
            flight: None,
            speed: Speed::from(0.0),
            shows: false,
        };
        let port = exchange.guest.address().port();
        let id = exchange.ask(Request::Connect { port })?;
        while now.elapsed() < CONNECT {
            exchange.goes_on()?;
            match exchange.answer()? {
                Some(answer) if answer.id == id && (answer.status, answer.version) == (0, VERSION) => {
                    return Ok(exchange);
                }
                Some(answer) if answer.id == id => return Err(OTHER_VERSION),
                Some(_) => return Err(NO_HAND),
                None => std::thread::sleep(PAUSE),
            }
        }
        Err(NO_HAND)
    }

    fn goes_on(&self) -> Result<(), DriveFault> {
        if self.watch.ends() { Err(CLOSED) } else { Ok(()) }
    }

    fn ask(&mut self, request: Request) -> Result<u32, DriveFault> {
        self.last = self.last.wrapping_add(1);
        self.line.send(&request.bytes(self.last)).map_err(|_| self.ended())?;
        Ok(self.last)
    }

    /// Why the line has ended.
    fn ended(&self) -> DriveFault {
        if self.line.refused().malformed > 0 { NO_HAND } else { HUNG_UP }
    }

    /// The next answer that has come.
    fn answer(&mut self) -> Result<Option<Answer>, DriveFault> {
        // What has come before the end is read first.
        let is_open = self.line.is_open();
        match self.line.oldest() {
            Some(frame) => Answer::read(frame.bytes()).map(Some).ok_or(NO_HAND),
            None if !is_open => Err(self.ended()),
            None => Ok(None),
        }
    }

    /// Takes over what has come, and waits a little.
    fn hear(&mut self) -> Result<(), DriveFault> {
        self.goes_on()?;
        while let Some(answer) = self.answer()? {
            self.take(answer)?;
        }
        if let Some(state) = self.guest.newest().and_then(|datagram| State::read(datagram.bytes())) {
            (self.state, self.came) = (Some(state), Instant::now());
            self.show(&state);
        }
        if self.came.elapsed() > self.settings.silence {
            return Err(SILENT);
        }
        std::thread::sleep(PAUSE);
        Ok(())
    }

    /// The hand's answer to a request.
    fn take(&mut self, answer: Answer) -> Result<(), DriveFault> {
        let Some(flight) = self.flight else { return Ok(()) };
        let outcome = answer.outcome().ok_or(NO_HAND)?;
        if flight.stop == Some(answer.id) {
            self.flight = None;
            let failed = stop(StopCause::ProtectiveStop, "stop failed");
            return if outcome == Outcome::Failed { Err(failed) } else { Ok(()) };
        }
        // One that is being stopped has ended, however, when its stop is answered. Others have been stopped before.
        if flight.id != answer.id || flight.stop.is_some() {
            return Ok(());
        }
        self.flight = None;
        match (outcome, flight.motion) {
            (Outcome::Done, _) | (Outcome::Unsuccessful, Motion::Grasp) => Ok(()),
            (Outcome::Unsuccessful, Motion::Move) => Err(SHORT),
            (Outcome::Failed | Outcome::Unsuccessful, motion) => Err(motion.failed()),
            (Outcome::Aborted, _) => Err(BY_OTHERS),
        }
    }

    fn begin(&mut self, motion: Motion, request: Request) -> Result<(), DriveFault> {
        let id = self.ask(request)?;
        self.flight = Some(Flight { id, motion, stop: None, since: Instant::now() });
        Ok(())
    }

    /// Ends the motion that goes on, unless that was asked for.
    fn stop(&mut self) -> Result<(), DriveFault> {
        if let Some(flight) = self.flight.filter(|flight| flight.stop.is_none()) {
            let stop = Some(self.ask(Request::Stop)?);
            self.flight = Some(Flight { stop, since: Instant::now(), ..flight });
        }
        Ok(())
    }

    /// Ends what was asked for by a connection that is gone: a homing that was cut off goes on, and another one beside it fails.
    fn end_others(&mut self) -> Result<(), DriveFault> {
        let id = self.ask(Request::Stop)?;
        self.flight = Some(Flight { id, motion: Motion::Homing, stop: Some(id), since: Instant::now() });
        while let Some(flight) = self.flight {
            if flight.since.elapsed() > self.settings.patience {
                return Err(ENDLESS);
            }
            self.hear()?;
        }
        Ok(())
    }

    fn first_state(&mut self) -> Result<State, DriveFault> {
        loop {
            self.hear()?;
            if let Some(state) = self.state {
                return Ok(state);
            }
        }
    }

    fn is_homed(&self) -> bool {
        self.state.is_some_and(|state| state.max_width > 0.0)
    }

    /// Homes it, while that is asked for. Where it is not, the homing is stopped, and begins anew when it is.
    fn home(&mut self) -> Result<(), DriveFault> {
        loop {
            while !self.watch.is_asked() {
                self.hear()?;
            }
            self.end_others()?;
            if !self.watch.is_asked() {
                continue;
            }
            self.begin(Motion::Homing, Request::Homing)?;
            let mut is_stopped = false;
            while let Some(flight) = self.flight {
                self.hear()?;
                if !self.watch.is_asked() {
                    is_stopped = true;
                    self.stop()?;
                }
                if flight.since.elapsed() > HOMING {
                    return Err(ENDLESS);
                }
            }
            // The state that shows it comes after the answer.
            let until = Instant::now() + self.settings.silence;
            while !self.is_homed() && !is_stopped {
                if Instant::now() > until {
                    return Err(NOT_HOMED);
                }
                self.hear()?;
            }
            if self.is_homed() {
                return Ok(());
            }
        }
    }

    /// Learns where the fingers stand. Nothing is told to them.
    fn stand(&mut self) -> Result<(), DriveFault> {
        let began = Instant::now();
        let mut stood = (began, f64::INFINITY);
        loop {
            let state = self.first_state()?;
            if (state.width - stood.1).abs() > STILL {
                stood = (Instant::now(), state.width);
            }
            if stood.0.elapsed() > STOOD {
                self.shared.demanded.set(state.width);
                self.speed = Speed::from(state.width);
                self.shows = true;
                self.show(&state);
                return Ok(());
            }
            if began.elapsed() > SETTLING {
                return Err(MOVED_BY_OTHERS);
            }
        }
    }

    /// Tells it what is demanded, until it is to end.
    fn follow(&mut self) -> Result<(), DriveFault> {
        let mut told = self.shared.demanded.get();
        let mut stands = (told, Instant::now());
        loop {
            self.hear()?;
            let demanded = self.shared.demanded.get();
            if (demanded - stands.0).abs() > SAME {
                stands = (demanded, Instant::now());
            }
            let is_news = (demanded - told).abs() > NEWS && stands.1.elapsed() >= STANDS;
            match self.flight {
                Some(flight) if flight.since.elapsed() > self.settings.patience => {
                    // A grasp presses on what it has found; its stop would let that fall.
                    if flight.motion == Motion::Move {
                        self.stop()?;
                    }
                    return Err(ENDLESS);
                }
                // Fingers that grasp go on when they shall be narrower still: a stop would open them.
                Some(flight) if is_news && !(flight.motion == Motion::Grasp && self.closes(demanded)) => {
                    self.stop()?;
                }
                None if is_news => {
                    told = demanded;
                    self.go_to(demanded)?;
                }
                Some(_) | None => {}
            }
        }
    }

    /// Whether the fingers are wider than this \[m\].
    fn closes(&self, width: f64) -> bool {
        self.state.is_some_and(|state| width < state.width)
    }

    fn go_to(&mut self, width: f64) -> Result<(), DriveFault> {
        let Some(state) = self.state else { return Ok(()) };
        let HandSettings { speed, force, .. } = *self.settings;
        if width >= state.width {
            return self.begin(Motion::Move, Request::Move { width, speed });
        }
        // What it holds it holds on, however much narrower it is told to be.
        if state.is_grasped {
            return Ok(());
        }
        if self.shared.presses.load(Ordering::Relaxed) {
            // Fingers that come to the opening hold nothing.
            let band = (0.0, state.max_width);
            return self.begin(Motion::Grasp, Request::Grasp { width, band, speed, force });
        }
        self.begin(Motion::Move, Request::Move { width, speed })
    }

    fn show(&mut self, state: &State) {
        if let Some(speed) = self.speed.at(state.width) {
            self.shared.speed.set(speed);
        }
        self.shared.width.set(state.width);
        self.shared.max_width.set(state.max_width);
        self.shared.is_grasped.store(state.is_grasped, Ordering::Relaxed);
        if self.shows {
            self.watch.hear();
        }
    }
}
