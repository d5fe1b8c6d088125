//! The protocol of the hand: what it is asked for, and what its answers and states mean.
//!
//! A position is told when it has been demanded for [`STANDS`], and one motion at a time; another demand ends a motion that goes on.
//! The hand answers a request when its motion is over, over the connection, and sends its states as datagrams.

use core::sync::atomic::Ordering;
use core::time::Duration;
use std::sync::Arc;

use mrroc::robot::{DriveFault, StopCause};
use mrroc_driver_kit::{Cutting, NotConnected, Protocol, Received, Speed};

use super::faults::{
    BY_OTHERS, ENDLESS, HUNG_UP, MOVED_BY_OTHERS, NO_HAND, NO_PORT, NOT_HOMED, OTHER_VERSION, SHORT, SILENT,
    UNREACHABLE, stop,
};
use super::message::{Answer, Outcome, Request, State, VERSION};
use super::settings::HandSettings;
use super::shared::Shared;

/// How long the hand may take to accept the connection, and to answer it.
pub(super) const CONNECT: Duration = Duration::from_secs(1);

/// How long a demand must have stood before it is told: some servo periods and steps.
const STANDS: Duration = Duration::from_millis(20);

/// Demands that differ by less than this are one that stands, and by less than that from the last one that was told are no news \[m\]:
/// what is grasped must not be let go for the last digit of a number.
const SAME: f64 = 1e-7;
const NEWS: f64 = 1e-5;

/// How often it is looked at what is demanded and which state has come.
const PAUSE: Duration = Duration::from_millis(2);

/// How long the homing may take.
const HOMING: Duration = Duration::from_secs(30);

/// How long the fingers must have stood when the drives are opened, and for how long that is waited for.
const STOOD: Duration = Duration::from_millis(200);
const SETTLING: Duration = Duration::from_secs(6);

/// Fingers that move by less than this \[m\] stand.
const STILL: f64 = 1e-4;

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
    since: Duration,
}

/// How far it has come.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// Nothing was said.
    New,
    /// It was asked by the first request to send its states, at this time.
    Connecting(Duration),
    /// Its first state is waited for.
    Connected,
    /// It is not homed, and nobody asks for that.
    Unasked,
    /// What a connection that is gone has asked for is ended: a homing that was cut off goes on, and another one beside it fails.
    EndingOthers,
    /// It homes, or stops homing where nobody asks for it any more.
    Homing {
        /// Whether it was told to stop.
        is_stopped: bool,
    },
    /// Its homing is over, and the state that shows it comes until then.
    Homed(Duration),
    /// Its fingers should stand.
    Standing {
        /// Since when that is waited for.
        began: Duration,
        /// Since when they have stood at this opening \[m\].
        stood: (Duration, f64),
    },
    /// It is told what is demanded.
    Following {
        /// The opening that it was told last, or where it stood \[m\].
        told: f64,
        /// The opening that is demanded \[m\], and since when.
        stands: (f64, Duration),
    },
}

/// Whether the hand may be homed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unhomed {
    /// One that is not homed is refused.
    Refused,
    /// One that is not homed is homed, while that is asked for.
    Homed,
}

/// The protocol, and what is known of the hand.
pub(super) struct HandProtocol {
    shared: Arc<Shared>,
    settings: HandSettings,
    unhomed: Unhomed,
    phase: Phase,
    /// Bytes of an answer that is not there as a whole.
    bytes: Vec<u8>,
    /// The number of the last request.
    last: u32,
    /// The newest state, and when it came.
    state: Option<State>,
    came: Duration,
    flight: Option<Flight>,
    speed: Speed,
    /// Whether the drives may see the states: the fingers have stood.
    shows: bool,
}

impl Protocol for HandProtocol {
    type Fault = DriveFault;

    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, DriveFault> {
        self.bytes.extend_from_slice(received.bytes);
        match self.phase {
            Phase::New => {
                let id = self.ask(Request::Connect { port: received.port }, send);
                (self.phase, self.came) = (Phase::Connecting(now), now);
                debug_assert_eq!(id, 1, "the first request");
            }
            Phase::Connecting(_) => self.connect(now)?,
            _ => {
                self.hear(now, &received)?;
                // As far as it goes without waiting.
                while self.go_on(now, send)? {}
            }
        }
        // What has come before the end was read.
        if received.is_closed {
            return Err(HUNG_UP);
        }
        Ok(now + PAUSE)
    }

    fn not_connected(&self, why: NotConnected) -> DriveFault {
        match why {
            NotConnected::Unreachable => UNREACHABLE,
            NotConnected::NoPort => NO_PORT,
        }
    }
}

impl HandProtocol {
    pub(super) fn new(shared: Arc<Shared>, settings: HandSettings, unhomed: Unhomed) -> HandProtocol {
        HandProtocol {
            shared,
            settings,
            unhomed,
            phase: Phase::New,
            bytes: Vec::new(),
            last: 0,
            state: None,
            came: Duration::ZERO,
            flight: None,
            speed: Speed::from(Duration::ZERO, 0.0),
            shows: false,
        }
    }

    fn ask(&mut self, request: Request, send: &mut Vec<u8>) -> u32 {
        self.last = self.last.wrapping_add(1);
        send.extend(request.bytes(self.last));
        self.last
    }

    /// The next answer that has come.
    fn answer(&mut self) -> Result<Option<Answer>, DriveFault> {
        match Answer::cut(&self.bytes) {
            Cutting::Frame(len) if len <= self.bytes.len() => {
                let frame: Vec<u8> = self.bytes.drain(..len).collect();
                Answer::read(&frame).map(Some).ok_or(NO_HAND)
            }
            Cutting::Frame(_) | Cutting::More => Ok(None),
            Cutting::Bad => Err(NO_HAND),
        }
    }

    /// The answer to the first request.
    fn connect(&mut self, now: Duration) -> Result<(), DriveFault> {
        let Phase::Connecting(since) = self.phase else { return Ok(()) };
        match self.answer()? {
            Some(answer) if answer.id == self.last && (answer.status, answer.version) == (0, VERSION) => {
                self.phase = Phase::Connected;
                Ok(())
            }
            Some(answer) if answer.id == self.last => Err(OTHER_VERSION),
            Some(_) => Err(NO_HAND),
            None if now - since >= CONNECT => Err(NO_HAND),
            None => Ok(()),
        }
    }

    /// Takes over what has come.
    fn hear(&mut self, now: Duration, received: &Received<'_>) -> Result<(), DriveFault> {
        while let Some(answer) = self.answer()? {
            self.take(answer)?;
        }
        if let Some(state) = received.datagram.and_then(State::read) {
            (self.state, self.came) = (Some(state), now);
            self.show(now, &state);
        }
        if now - self.came > self.settings.silence {
            return Err(SILENT);
        }
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

    fn begin(&mut self, now: Duration, motion: Motion, request: Request, send: &mut Vec<u8>) {
        let id = self.ask(request, send);
        self.flight = Some(Flight { id, motion, stop: None, since: now });
    }

    /// Ends the motion that goes on, unless that was asked for.
    fn stop(&mut self, now: Duration, send: &mut Vec<u8>) {
        if let Some(flight) = self.flight.filter(|flight| flight.stop.is_none()) {
            let stop = Some(self.ask(Request::Stop, send));
            self.flight = Some(Flight { stop, since: now, ..flight });
        }
    }

    fn is_homed(&self) -> bool {
        self.state.is_some_and(|state| state.max_width > 0.0)
    }

    /// Whether what goes on has gone on for longer than this.
    fn is_endless(&self, now: Duration, timeout: Duration) -> bool {
        self.flight.is_some_and(|flight| now - flight.since > timeout)
    }

    /// Goes on to the next phase: whether that may go on at once.
    fn go_on(&mut self, now: Duration, send: &mut Vec<u8>) -> Result<bool, DriveFault> {
        let is_asked = self.shared.times.is_asked(now);
        let Some(state) = self.state else { return Ok(false) };
        let next = match self.phase {
            Phase::Connected if state.max_width > 0.0 => standing(now),
            Phase::Connected if self.unhomed == Unhomed::Refused => return Err(NOT_HOMED),
            Phase::Connected => Phase::Unasked,
            Phase::Unasked if is_asked => {
                let id = self.ask(Request::Stop, send);
                self.flight = Some(Flight { id, motion: Motion::Homing, stop: Some(id), since: now });
                Phase::EndingOthers
            }
            Phase::EndingOthers if self.is_endless(now, self.settings.timeout) => return Err(ENDLESS),
            Phase::EndingOthers if self.flight.is_none() && !is_asked => Phase::Unasked,
            Phase::EndingOthers if self.flight.is_none() => {
                self.begin(now, Motion::Homing, Request::Homing, send);
                Phase::Homing { is_stopped: false }
            }
            Phase::Homing { .. } if self.is_endless(now, HOMING) => return Err(ENDLESS),
            Phase::Homing { .. } if self.flight.is_some() => {
                // Where it is not asked for, the homing is stopped, and begins anew when it is.
                if !is_asked {
                    self.phase = Phase::Homing { is_stopped: true };
                    self.stop(now, send);
                }
                return Ok(false);
            }
            Phase::Homing { is_stopped: true } if !self.is_homed() => Phase::Unasked,
            // The state that shows it comes after the answer.
            Phase::Homing { .. } => Phase::Homed(now + self.settings.silence),
            Phase::Homed(_) if self.is_homed() => standing(now),
            Phase::Homed(until) if now > until => return Err(NOT_HOMED),
            Phase::Standing { began, stood } => return self.stand(now, began, stood, &state),
            Phase::Following { told, stands } => {
                self.follow(now, told, stands, send)?;
                return Ok(false);
            }
            Phase::New | Phase::Connecting(_) | Phase::Unasked | Phase::EndingOthers | Phase::Homed(_) => {
                return Ok(false);
            }
        };
        self.phase = next;
        Ok(true)
    }

    /// Learns where the fingers stand. Nothing is told to them.
    fn stand(
        &mut self,
        now: Duration,
        began: Duration,
        stood: (Duration, f64),
        state: &State,
    ) -> Result<bool, DriveFault> {
        let stood = if (state.width - stood.1).abs() > STILL { (now, state.width) } else { stood };
        if now - stood.0 > STOOD {
            self.shared.demanded.set(state.width);
            self.speed = Speed::from(now, state.width);
            self.shows = true;
            self.show(now, state);
            self.phase = Phase::Following { told: state.width, stands: (state.width, now) };
            return Ok(true);
        }
        if now - began > SETTLING {
            return Err(MOVED_BY_OTHERS);
        }
        self.phase = Phase::Standing { began, stood };
        Ok(false)
    }

    /// Tells it what is demanded.
    fn follow(
        &mut self,
        now: Duration,
        told: f64,
        stands: (f64, Duration),
        send: &mut Vec<u8>,
    ) -> Result<(), DriveFault> {
        let demanded = self.shared.demanded.get();
        let stands = if (demanded - stands.0).abs() > SAME { (demanded, now) } else { stands };
        self.phase = Phase::Following { told, stands };
        let is_news = (demanded - told).abs() > NEWS && now - stands.1 >= STANDS;
        match self.flight {
            Some(flight) if now - flight.since > self.settings.timeout => {
                // A grasp presses on what it has found; its stop would let that fall.
                if flight.motion == Motion::Move {
                    self.stop(now, send);
                }
                return Err(ENDLESS);
            }
            // Fingers that grasp go on when they shall be narrower still: a stop would open them.
            Some(flight) if is_news && !(flight.motion == Motion::Grasp && self.closes(demanded)) => {
                self.stop(now, send);
            }
            None if is_news => {
                self.phase = Phase::Following { told: demanded, stands };
                self.go_to(now, demanded, send);
            }
            Some(_) | None => {}
        }
        Ok(())
    }

    /// Whether the fingers are wider than this \[m\].
    fn closes(&self, width: f64) -> bool {
        self.state.is_some_and(|state| width < state.width)
    }

    fn go_to(&mut self, now: Duration, width: f64, send: &mut Vec<u8>) {
        let Some(state) = self.state else { return };
        let HandSettings { speed, force, .. } = self.settings;
        if width >= state.width {
            return self.begin(now, Motion::Move, Request::Move { width, speed }, send);
        }
        // What it holds it holds on, however much narrower it is told to be.
        if state.is_grasped {
            return;
        }
        if self.shared.presses.load(Ordering::Relaxed) {
            // Fingers that come to the opening hold nothing.
            let band = (0.0, state.max_width);
            return self.begin(now, Motion::Grasp, Request::Grasp { width, band, speed, force }, send);
        }
        self.begin(now, Motion::Move, Request::Move { width, speed }, send);
    }

    fn show(&mut self, now: Duration, state: &State) {
        if let Some(speed) = self.speed.at(now, state.width) {
            self.shared.speed.set(speed);
        }
        self.shared.width.set(state.width);
        self.shared.max_width.set(state.max_width);
        self.shared.is_grasped.store(state.is_grasped, Ordering::Relaxed);
        if self.shows {
            self.shared.times.hear(now);
        }
    }
}

const fn standing(now: Duration) -> Phase {
    Phase::Standing { began: now, stood: (now, f64::INFINITY) }
}
