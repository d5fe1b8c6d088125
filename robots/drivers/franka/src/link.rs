//! What is known of a robot that is connected, and what it is answered.
//!
//! In: its states and its answers to requests, with the times at which they came. Out: an answer to each state of a motion, and
//! requests. The network and its clock are handed in.

use core::time::Duration;
use std::io;
use std::net::SocketAddr;

use mrroc::robot::{DriveFault, Measured, Pulse, RobotStop, StopCause};

use crate::behaviour::Behaviour;
use crate::limits;
use crate::message::{Answer, Request, State, command};
use crate::network::Network;
use crate::opening::FirstState;
use crate::rejoining::{Joints, Rejoining, Setpoint};
use crate::requests::Requests;
use crate::stops::{CUT_OFF, ENDED, NETWORK, REFUSED, TOO_FAR};

/// How old a state may be when it is answered. An answer that comes after the robot's next state is none: it would have to be
/// known whether the robot has taken it.
pub(crate) const IN_TIME: Duration = Duration::from_micros(700);

/// The answer to a request for a motion that has begun. Its end is answered once more.
pub(crate) const STARTED: u8 = 1;

/// States within which the robot says why it has ended a motion.
pub(crate) const REASON: u64 = 5;

/// How far what the robot says that it follows may be from what it was told \[rad\]: it says so with 24 bits.
pub(crate) const LAST_BITS: f64 = 4e-7;

/// How far the robot may be from the demanded position \[rad\]. After 19 lost answers it is off by 12 mrad at most, at 10 rad/s²;
/// more has another cause.
pub(crate) const FARTHEST: f64 = 0.1;

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

/// Where a motion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    /// There is none.
    None,
    /// The robot was asked for one, by the request of this number.
    Asked(u32),
    /// It runs.
    Runs(u32),
    /// It is ending: the robot is told that it is over.
    Ends(u32),
}

/// A robot that has said something.
#[derive(Debug)]
pub(crate) struct Link {
    requests: Requests,
    /// The robot's last state, when it was read, and, while it is to be answered, who sent it and when it came in.
    pub said: State,
    pub heard: Duration,
    unanswered: Option<(SocketAddr, Duration)>,
    pub motion: Motion,
    /// The count of the state that was answered last, what the robot followed then, and what it follows since.
    told: Option<(u64, Setpoint, Setpoint)>,
    rejoining: Rejoining,
    /// Nobody demands anything.
    pub is_alone: bool,
    /// The motion is to end when the robot stands.
    pub is_to_end: bool,
    /// The robot has ended a motion, which is not told yet, and by when a state must say why.
    pub ended: Option<(DriveFault, u64)>,
    /// Recovery was asked for, by the request of this number.
    pub recovery: Option<u32>,
    /// What it is told of collisions, of its regulators and of what it carries.
    pub behaviour: Behaviour,
    /// It was asked for in this reset.
    pub has_recovered: bool,
    pub answers: Answers,
}

/// The next answer to a request, if one has come.
///
/// # Errors
/// The connection has ended, or what comes is no answer.
pub(crate) fn answer(network: &mut impl Network, requests: &mut Requests) -> io::Result<Option<Answer>> {
    let len = network.read(requests.room())?;
    requests.filled(len);
    requests.next().map_err(|()| io::ErrorKind::InvalidData.into())
}

impl Link {
    /// To a robot that has said its first state, which is read now.
    pub fn new(requests: Requests, behaviour: Behaviour, now: Duration, first: FirstState) -> Link {
        Link {
            requests,
            said: first.said,
            heard: now,
            unanswered: Some((first.from, first.came)),
            motion: Motion::None,
            told: None,
            rejoining: Rejoining::new(),
            is_alone: true,
            is_to_end: false,
            ended: None,
            recovery: None,
            behaviour,
            has_recovered: false,
            answers: Answers::default(),
        }
    }

    /// Asks the robot for something, and says the number of the request.
    pub fn ask(&mut self, network: &mut impl Network, request: Request) -> Result<u32, DriveFault> {
        let (id, bytes) = self.requests.write(request);
        network.ask(bytes).map_err(|_| CUT_OFF)?;
        Ok(id)
    }

    /// Tells the robot the next of what it does not know yet of its behaviour.
    pub fn tell_behaviour(&mut self, network: &mut impl Network) -> Result<(), DriveFault> {
        let State { count, end_effector, .. } = &self.said;
        let requests = &mut self.requests;
        self.behaviour.tell(*count, end_effector, |request| {
            let (id, bytes) = requests.write(request);
            network.ask(bytes).map_err(|_| CUT_OFF)?;
            Ok(id)
        })
    }

    pub fn measured(&self) -> Measured<Joints> {
        Measured { position: self.said.q.into(), velocity: self.said.dq.into() }
    }

    /// Takes over what the robot has said and answered, as far as it has come. `None`: no new state.
    pub fn hear(&mut self, network: &mut impl Network) -> Result<Option<Pulse>, DriveFault> {
        while let Some(answer) = answer(network, &mut self.requests).map_err(|_| CUT_OFF)? {
            self.take(answer)?;
        }
        let Some(received) = network.newest() else { return Ok(None) };
        // What cannot be read is not answered: the robot counts that.
        let said = State::read(received.bytes).filter(|said| said.count > self.said.count);
        let Some(said) = said else { return Ok(None) };
        let (from, came) = (received.from, received.came);
        let now = network.now();
        // The state before was not answered: nobody demands anything now.
        self.is_alone |= self.unanswered.is_some() && self.told.is_some();
        (self.said, self.heard, self.unanswered) = (said, now, Some((from, came)));
        self.follow();
        Ok(Some(Pulse { count: said.count, age: now.saturating_sub(came) }))
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
        self.ended = Some((fault, self.said.count.saturating_add(REASON)));
    }

    /// There is no motion.
    pub fn end(&mut self) {
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
        let off = |setpoint: &Setpoint| (setpoint.q - q_d).amax();
        // Either the last answer came in time, or it did not and the robot went on by itself, or it came while this state was
        // being sent: then the robot still says where it was before.
        let heard = after.extrapolated(periods - 1);
        let unheard = before.extrapolated(periods);
        let unshown = before.extrapolated(periods - 1);
        let told = Setpoint { q: q_d, dq: self.said.dq_d.into(), ddq: self.said.ddq_d.into() };
        let is = |setpoint: &Setpoint| off(setpoint) <= LAST_BITS;
        let (setpoint, lost) = if is(&heard) || is(&unshown) {
            (heard, periods - 1)
        } else if is(&unheard) {
            (unheard, periods)
        } else {
            (told, periods)
        };
        self.answers.lost = self.answers.lost.saturating_add(lost);
        self.told = Some((self.said.count, setpoint, setpoint));
    }

    /// What the robot follows now, where a motion runs.
    pub fn setpoint(&self) -> Setpoint {
        self.told.map_or_else(|| Setpoint::at_rest(self.said.q_d.into()), |(_, _, setpoint)| setpoint)
    }

    /// Answers the state that is to be answered.
    fn answer(
        &mut self,
        network: &mut impl Network,
        next: Setpoint,
        is_last: bool,
    ) -> Result<(), DriveFault> {
        let Some((from, came)) = self.unanswered.take() else { return Ok(()) };
        let setpoint = self.setpoint();
        // One that comes too late is none: the robot has gone on by itself.
        if network.now().saturating_sub(came) >= IN_TIME {
            self.told = Some((self.said.count, setpoint, setpoint.extrapolated(1)));
            return Ok(());
        }
        self.told = Some((self.said.count, setpoint, next));
        let bytes = command(self.said.count, &next.q.into(), is_last);
        network.send(from, &bytes).map_err(|_| NETWORK)
    }

    /// Brings the robot to rest and holds it, and ends the motion where it is to end.
    pub fn hold(&mut self, network: &mut impl Network) -> Result<(), DriveFault> {
        self.rejoining.forget();
        let setpoint = self.setpoint();
        let next = setpoint.braked(BRAKES.0, BRAKES.1);
        let stands = next == Setpoint::at_rest(setpoint.q) && setpoint.dq == Joints::zeros();
        if let Motion::Runs(id) = self.motion
            && self.is_to_end
            && stands
        {
            self.motion = Motion::Ends(id);
        }
        self.answer(network, next, matches!(self.motion, Motion::Ends(_)))
    }

    /// A position is demanded for the end of the period.
    pub fn go_to(&mut self, network: &mut impl Network, demanded: &Joints) -> Result<(), DriveFault> {
        let setpoint = self.setpoint();
        let (next, away) = self.rejoining.next(self.said.count, &setpoint, demanded);
        let checked = limits::check(&setpoint, &next);
        let checked = checked.and(if away > FARTHEST { Err(TOO_FAR) } else { Ok(()) });
        if let Err(fault) = checked {
            (self.is_alone, self.is_to_end) = (true, true);
            self.hold(network)?;
            return Err(fault);
        }
        self.answers.farthest = self.answers.farthest.max(away);
        self.answer(network, next, false)
    }
}
