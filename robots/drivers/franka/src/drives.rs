//! The drives of an FR3 behind the Franka Control Interface.
//!
//! In: positions for the ends of the robot's periods of a millisecond. Out: an answer to each of its states, and what its
//! encoders read. A motion begins with the first demand for another position than that where the robot is held, and ends when
//! the drives are let go or switched off. While nobody
//! demands anything in a motion, the drives bring the robot to rest and hold it: the interface wants an answer to every state.

#![expect(
    clippy::disallowed_methods,
    reason = "before the cell runs, and after it was stopped, the robot is waited for"
)]

#[cfg(test)]
mod tests;

use core::time::Duration;
use std::net::SocketAddr;
use std::time::Instant;

use mrroc::pose::Wrench;
use mrroc::robot::{
    DriveFault, Driver, Load, Measured, Pace, Pulse, Recovery, Regulators, Robot, RobotStop, StopCause,
};
use mrroc_driver_kit::{Datagram, Guest};

use crate::behaviour::Behaviour;
use crate::limits;
use crate::message::{Answer, Mode, Request, State, command};
use crate::rejoining::{Course, Joints, Rejoining};
use crate::requests::Requests;
use crate::settings::FciSettings;
use crate::stops::{ABSENT, CLOSED, CUT_OFF, ENDED, NETWORK, OTHER_VERSION, REFUSED, TOO_FAR, stopped};

/// A period of the robot.
const PERIOD: Duration = Duration::from_millis(1);

/// How old a state may be when it is answered. An answer that comes after the robot's next state is none: it would have to be
/// known whether the robot has taken it.
const IN_TIME: Duration = Duration::from_micros(700);

/// How long to wait for the robot when the drives are opened, and when they are let go.
const PATIENCE: Duration = Duration::from_secs(2);

/// For how long the robot stands until its motion has ended and it has answered to a load (assumed; it is asked for 2 s).
const LOAD_TIME: Duration = Duration::from_millis(100);

/// The answer to a request for a motion that has begun. Its end is answered once more.
const STARTED: u8 = 1;

/// States within which the robot says why it has ended a motion.
const REASON: u64 = 5;

/// How far what the robot says that it follows may be from what it was told \[rad\]: it says so with 24 bits.
const LAST_BITS: f64 = 4e-7;

/// How far the robot may be from the demanded position \[rad\]. After 19 lost answers it is off by 12 mrad at most, at 10 rad/s²;
/// more has another cause.
const FARTHEST: f64 = 0.1;

/// Jerk [rad/s³] and acceleration [rad/s²] with which the drives bring the robot to rest by themselves.
const BRAKES: (f64, f64) = (1240.0, 7.5);

/// What became of answers so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answers {
    /// Periods for which the robot got no answer in time, and went on by itself.
    pub lost: u64,
    /// The farthest that a joint was told to be from its demanded position \[rad\].
    pub farthest: f64,
}

/// The drives. They are paced by the robot.
#[derive(Debug)]
pub struct Fci {
    settings: FciSettings,
    sets: Regulators,
    /// What the robot carries, if a program or the cell has said it.
    load: Option<Load>,
    link: Option<Link>,
}

/// Where a motion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// There is none.
    None,
    /// The robot was asked for one, by the request of this number.
    Asked(u32),
    /// It runs.
    Runs(u32),
    /// It is ending: the robot is told that it is over.
    Ends(u32),
}

/// The connection to a robot that has said something.
#[derive(Debug)]
struct Link {
    guest: Guest,
    requests: Requests,
    /// The robot's last state, and the same as a datagram while it is to be answered.
    said: State,
    heard: Instant,
    unanswered: Option<Datagram>,
    motion: Motion,
    /// The count of the state that was answered last, what the robot followed then, and what it follows since.
    told: Option<(u64, Course, Course)>,
    rejoining: Rejoining,
    /// Nobody demands anything.
    is_alone: bool,
    /// The motion is to end when the robot stands.
    is_to_end: bool,
    /// The robot has ended a motion, which is not told yet, and by when a state must say why.
    ended: Option<(DriveFault, u64)>,
    /// Recovery was asked for, by the request of this number.
    recovery: Option<u32>,
    /// What it is told of collisions, of its regulators and of what it carries.
    behaviour: Behaviour,
    /// It was asked for in this reset.
    has_recovered: bool,
    answers: Answers,
}

impl Fci {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: FciSettings) -> Fci {
        Fci { settings, sets: Regulators::default(), load: None, link: None }
    }

    /// What became of answers since the drives were opened.
    #[must_use]
    pub fn answers(&self) -> Answers {
        self.link.as_ref().map_or_else(Answers::default, |link| link.answers)
    }

    fn link(&mut self) -> Result<&mut Link, DriveFault> {
        self.link.as_mut().ok_or(CLOSED)
    }
}

impl Link {
    /// Connects, and waits for the first state.
    fn open(settings: &FciSettings, sets: Regulators, load: Option<Load>) -> Result<Link, DriveFault> {
        let until = Instant::now() + PATIENCE;
        let address = SocketAddr::new(settings.robot, settings.port);
        let mut requests = Requests::connect(address, PATIENCE).map_err(|_| ABSENT)?;
        let own = requests.own_address().map_err(|_| CUT_OFF)?;
        let mut guest = Guest::expect(SocketAddr::new(own, 0), settings.robot)
            .map_err(|_| DriveFault::Other("this machine has no port for the robot's states"))?;
        let id = requests.ask(Request::Connect { port: guest.address().port() }).map_err(|_| CUT_OFF)?;
        let answer = requests.wait(id, PATIENCE).map_err(|_| ABSENT)?;
        if answer.status != 0 {
            return Err(OTHER_VERSION);
        }
        while Instant::now() < until {
            let datagram = guest.newest();
            if let Some(said) = datagram.as_ref().and_then(|datagram| State::read(datagram.bytes())) {
                return Ok(Link {
                    guest,
                    requests,
                    said,
                    heard: Instant::now(),
                    unanswered: datagram,
                    motion: Motion::None,
                    told: None,
                    rejoining: Rejoining::new(),
                    is_alone: true,
                    is_to_end: false,
                    ended: None,
                    recovery: None,
                    behaviour: Behaviour::new(settings.collision, settings.stiffness, sets, load),
                    has_recovered: false,
                    answers: Answers::default(),
                });
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        Err(ABSENT)
    }

    fn measured(&self) -> Measured<Joints> {
        Measured { position: self.said.q.into(), velocity: self.said.dq.into() }
    }

    /// Takes over what the robot has said and answered, as far as it has come. `None`: no new state.
    fn hear(&mut self) -> Result<Option<Pulse>, DriveFault> {
        while let Some(answer) = self.requests.answer().map_err(|_| CUT_OFF)? {
            self.take(answer)?;
        }
        let Some(datagram) = self.guest.newest() else { return Ok(None) };
        // What cannot be read is not answered: the robot counts that.
        let said = State::read(datagram.bytes()).filter(|said| said.count > self.said.count);
        let Some(said) = said else { return Ok(None) };
        let age = datagram.age();
        // The state before was not answered: nobody demands anything now.
        self.is_alone |= self.unanswered.is_some() && self.told.is_some();
        (self.said, self.heard, self.unanswered) = (said, Instant::now(), Some(datagram));
        self.follow();
        Ok(Some(Pulse { count: said.count, age }))
    }

    /// The robot's answer to a request.
    fn take(&mut self, answer: Answer) -> Result<(), DriveFault> {
        if self.behaviour.answered(answer.id, answer.status)? {
            return Ok(());
        }
        if self.recovery == Some(answer.id) {
            self.recovery = None;
            return match answer.status {
                0 => Ok(()),
                _ => Err(DriveFault::Stopped(
                    RobotStop::new(StopCause::Reflex).named("no recovery").at_pendant(),
                )),
            };
        }
        let is_of = |id| answer.id == id;
        match self.motion {
            // It has begun, which a state may have shown before; or it ended before that, or in the middle.
            Motion::Asked(id) | Motion::Runs(id) if is_of(id) && answer.status == STARTED => Ok(()),
            Motion::Asked(id) if is_of(id) => {
                self.has_ended(REFUSED);
                Ok(())
            }
            Motion::Runs(id) if is_of(id) => {
                self.has_ended(ENDED);
                Ok(())
            }
            Motion::Ends(id) if is_of(id) => {
                self.end();
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The robot has ended the motion. Its next state says why, if there is a reason.
    fn has_ended(&mut self, fault: DriveFault) {
        self.end();
        self.ended = Some((fault, self.said.count + REASON));
    }

    /// There is no motion.
    fn end(&mut self) {
        (self.motion, self.told, self.is_alone, self.is_to_end) = (Motion::None, None, true, false);
        self.rejoining.forget();
    }

    /// Where the motion is by the state that has come, and what the robot follows.
    fn follow(&mut self) {
        match self.motion {
            Motion::Asked(id) if self.said.follows_positions => self.motion = Motion::Runs(id),
            Motion::Ends(_) if !self.said.follows_positions => self.end(),
            _ => {}
        }
        let Some((count, before, after)) = self.told else { return };
        // A state in which the robot has not heard the first answer yet counts none as lost.
        let periods = self.said.count - count;
        let q_d = Joints::from(self.said.q_d);
        let off = |course: &Course| (course.q - q_d).amax();
        // Either the last answer came in time, or it did not and the robot went on by itself, or it came while this state was
        // being sent: then the robot still says where it was before.
        let heard = after.extrapolated(periods - 1);
        let unheard = before.extrapolated(periods);
        let unshown = before.extrapolated(periods - 1);
        let told = Course { q: q_d, dq: self.said.dq_d.into(), ddq: self.said.ddq_d.into() };
        let is = |course: &Course| off(course) <= LAST_BITS;
        let (course, lost) = if is(&heard) || is(&unshown) {
            (heard, periods - 1)
        } else if is(&unheard) {
            (unheard, periods)
        } else {
            (told, periods)
        };
        self.answers.lost += lost;
        self.told = Some((self.said.count, course, course));
    }

    /// What the robot follows now, where a motion runs.
    fn course(&self) -> Course {
        self.told.map_or_else(|| Course::at_rest(self.said.q_d.into()), |(_, _, course)| course)
    }

    /// Answers the state that is to be answered.
    fn answer(&mut self, next: Course, is_last: bool) -> Result<(), DriveFault> {
        let Some(datagram) = self.unanswered.take() else { return Ok(()) };
        let course = self.course();
        // One that comes too late is none: the robot has gone on by itself.
        if datagram.age() >= IN_TIME {
            self.told = Some((self.said.count, course, course.extrapolated(1)));
            return Ok(());
        }
        self.told = Some((self.said.count, course, next));
        let bytes = command(self.said.count, &next.q.into(), is_last);
        self.guest.answer(&datagram, &bytes).map_err(|_| NETWORK)
    }

    /// Brings the robot to rest and holds it, and ends the motion where it is to end.
    fn hold(&mut self) -> Result<(), DriveFault> {
        self.rejoining.forget();
        let course = self.course();
        let next = course.braked(BRAKES.0, BRAKES.1);
        let stands = next == Course::at_rest(course.q) && course.dq == Joints::zeros();
        if let Motion::Runs(id) = self.motion
            && self.is_to_end
            && stands
        {
            self.motion = Motion::Ends(id);
        }
        self.answer(next, matches!(self.motion, Motion::Ends(_)))
    }

    /// A position is demanded for the end of the period.
    fn go_to(&mut self, demanded: &Joints) -> Result<(), DriveFault> {
        let course = self.course();
        let (next, away) = self.rejoining.next(self.said.count, &course, demanded);
        let checked = limits::check(&course, &next);
        let checked = checked.and(if away > FARTHEST { Err(TOO_FAR) } else { Ok(()) });
        if let Err(fault) = checked {
            (self.is_alone, self.is_to_end) = (true, true);
            self.hold()?;
            return Err(fault);
        }
        self.answers.farthest = self.answers.farthest.max(away);
        self.answer(next, false)
    }
}

impl<R: Robot<Joints = Joints>> Driver<R> for Fci {
    fn period(&self) -> Duration {
        PERIOD
    }

    fn pace(&self) -> Pace {
        Pace::Robot { patience: self.settings.silence }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("Franka {}:{}", self.settings.robot, self.settings.port))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // A robot has one at a time.
        self.link = None;
        self.link = Some(Link::open(&self.settings, self.sets, self.load)?);
        Ok(())
    }

    fn close(&mut self) {
        let Some(link) = &mut self.link else { return };
        link.is_to_end = true;
        let until = Instant::now() + PATIENCE;
        while link.motion != Motion::None && Instant::now() < until {
            match link.hear() {
                Ok(Some(_)) if stopped(&link.said).is_none() => drop(link.hold()),
                Ok(None) => std::thread::sleep(Duration::from_micros(100)),
                Ok(Some(_)) | Err(_) => break,
            }
        }
        self.link = None;
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let link = self.link()?;
        let pulse = link.hear()?;
        if pulse.is_none() {
            return Ok(None);
        }
        let ended = link.ended.filter(|(_, by)| link.said.count >= *by).map(|(fault, _)| fault);
        if let Some(fault) = stopped(&link.said).or(ended) {
            link.end();
            link.ended = None;
            return Err(fault);
        }
        if link.is_alone && matches!(link.motion, Motion::Runs(_) | Motion::Ends(_)) {
            link.hold()?;
        }
        Ok(pulse)
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        self.link.as_ref().map(Link::measured).ok_or(CLOSED)
    }

    fn held(&self) -> Option<Joints> {
        self.link.as_ref().map(|link| link.course().q)
    }

    fn wrench(&self) -> Option<Wrench> {
        self.link.as_ref()?.said.external.wrench()
    }

    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let link = self.link()?;
        let stays = (demanded - link.course().q).amax() <= LAST_BITS;
        match link.motion {
            // A robot that moves is told nothing of these.
            Motion::None if !link.behaviour.is_known() => {
                let requests = &mut link.requests;
                let State { count, end_effector, .. } = &link.said;
                link.behaviour
                    .tell(*count, end_effector, |request| requests.ask(request).map_err(|_| CUT_OFF))?;
            }
            // Without a motion the robot holds by itself, and needs no answers.
            Motion::None if link.ended.is_some() || stays => {}
            Motion::None => {
                let id = link.requests.ask(Request::Move).map_err(|_| CUT_OFF)?;
                link.motion = Motion::Asked(id);
            }
            Motion::Runs(_) if stays && !link.behaviour.is_known() => {
                link.is_to_end = true;
                link.hold()?;
            }
            Motion::Runs(_) => {
                link.is_to_end = false;
                link.is_alone = false;
                link.go_to(demanded)?;
            }
            // The first states of a motion come soon; one that ends comes to its end before another begins.
            Motion::Asked(_) | Motion::Ends(_) => {}
        }
        Ok(link.measured())
    }

    fn has_regulator(&self, _joint: usize, set: u8) -> bool {
        let known =
            self.settings.stiffness[0].and(self.settings.stiffness.get(usize::from(set)).copied().flatten());
        set == 0 || known.is_some()
    }

    /// The robot is told when it stands: a motion that is at rest is ended for it, and begins again with the next demand.
    fn choose_regulators(&mut self, sets: &Regulators) {
        self.sets = *sets;
        if let Some(link) = &mut self.link {
            link.behaviour.choose(sets);
        }
    }

    /// The robot is told when it stands, as with regulators, what remains beside the end effector that Desk has. It takes the load off
    /// the wrench that it estimates.
    fn carry(&mut self, load: &Load) {
        self.load = Some(*load);
        if let Some(link) = &mut self.link {
            link.behaviour.carry(load);
        }
    }

    fn load_time(&self) -> Duration {
        LOAD_TIME
    }

    fn has_brakes(&self) -> bool {
        true
    }

    fn switch_off(&mut self) {
        // Without a motion the robot holds by itself. It is ended in the next periods.
        if let Some(link) = &mut self.link {
            (link.is_alone, link.is_to_end) = (true, true);
        }
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        let silence = self.settings.silence;
        let is_lost = self.link.as_ref().is_none_or(|link| link.heard.elapsed() > silence);
        let link = self.link()?;
        let heard = link.hear();
        if heard.is_err() || (is_lost && heard == Ok(None)) {
            self.link = None;
            self.link = Some(Link::open(&self.settings, self.sets, self.load)?);
        }
        let link = self.link()?;
        link.has_recovered = false;
        match stopped(&link.said) {
            None => Ok(()),
            Some(fault) => {
                link.end();
                Err(fault)
            }
        }
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Ok(link) = self.link() else { return Ok(Recovery::Over) };
        link.hear()?;
        match link.said.mode {
            Mode::Reflex if !link.has_recovered => {
                link.recovery = Some(link.requests.ask(Request::Recover).map_err(|_| CUT_OFF)?);
                link.has_recovered = true;
                Ok(Recovery::GoesOn)
            }
            // Its answer comes before the state that shows it.
            Mode::Reflex | Mode::Recovering => Ok(Recovery::GoesOn),
            _ if link.recovery.is_some() => Ok(Recovery::GoesOn),
            _ => Ok(Recovery::Over),
        }
    }
}
