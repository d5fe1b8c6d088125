//! The drives of an FR3 behind the Franka Control Interface.
//!
//! In: positions for the ends of the robot's periods of a millisecond. Out: an answer to each of its states, and what its
//! encoders read. A motion begins with the first demand for another position than that where the robot is held, and ends when
//! the drives are let go or switched off. While nobody
//! demands anything in a motion, the drives bring the robot to rest and hold it: the interface wants an answer to every state.

#[cfg(test)]
mod tests;

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::pose::Wrench;
use mrroc::robot::{DriveFault, Driver, Load, Measured, Pace, Pulse, Recovery, Regulators, Robot};

use crate::behaviour::Behaviour;
use crate::link::{Answers, LAST_BITS, Link, Motion, answer};
use crate::message::{Mode, Request, State};
use crate::network::{Network, Sockets};
use crate::opening::{AwaitedMessage, FirstState, Opening, TIMEOUT};
use crate::rejoining::Joints;
use crate::requests::Requests;
use crate::settings::FciSettings;
use crate::stops::{ABSENT, CLOSED, CUT_OFF, stopped};

/// A period of the robot.
const PERIOD: Duration = Duration::from_millis(1);

/// For how long the robot stands until its motion has ended and it has answered to a load (assumed; it is asked for 2 s).
const LOAD_TIME: Duration = Duration::from_millis(100);

/// The drives. They are paced by the robot, and reach it through the network `N`.
#[derive(Debug)]
pub struct Fci<N = Sockets> {
    settings: FciSettings,
    network: N,
    sets: Regulators,
    /// What the robot carries, if a program or the cell has said it.
    load: Option<Load>,
    link: Option<Link>,
}

impl Fci {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: FciSettings) -> Fci {
        Fci::over(Sockets::new(SocketAddr::new(settings.robot, settings.port)), settings)
    }
}

impl<N: Network> Fci<N> {
    /// Drives that reach their robot by other means, with its clock: a model of one in the same process.
    #[must_use]
    pub fn over(network: N, settings: FciSettings) -> Fci<N> {
        Fci { settings, network, sets: Regulators::default(), load: None, link: None }
    }

    /// What became of answers since the drives were opened.
    #[must_use]
    pub fn answers(&self) -> Answers {
        self.link.as_ref().map_or_else(Answers::default, |link| link.answers)
    }

    /// Connects, and waits for the first state.
    fn connect(&mut self) -> Result<Link, DriveFault> {
        let network = &mut self.network;
        let began = network.now();
        let port = network.connect(TIMEOUT)?;
        let mut requests = Requests::new();
        let (id, bytes) = requests.write(Request::Connect { port });
        network.ask(bytes).map_err(|_| CUT_OFF)?;
        let mut opening = Opening::new(began, network.now(), id);
        loop {
            let came = match opening.poll(network.now())? {
                AwaitedMessage::Answer => match answer(network, &mut requests).map_err(|_| ABSENT)? {
                    Some(answer) => {
                        opening.answer(&answer)?;
                        true
                    }
                    None => false,
                },
                AwaitedMessage::State => match first(network) {
                    Some(first) => {
                        let FciSettings { collision, stiffness, .. } = self.settings;
                        let behaviour = Behaviour::new(collision, stiffness, self.sets, self.load);
                        return Ok(Link::new(requests, behaviour, network.now(), first));
                    }
                    None => false,
                },
            };
            if !came {
                network.wait();
            }
        }
    }

    /// A robot has one connection at a time: the one from before is closed.
    fn reconnect(&mut self) -> Result<(), DriveFault> {
        self.disconnect();
        match self.connect() {
            Ok(link) => {
                self.link = Some(link);
                Ok(())
            }
            Err(fault) => {
                self.network.close();
                Err(fault)
            }
        }
    }

    fn disconnect(&mut self) {
        self.link = None;
        self.network.close();
    }
}

/// The newest state, if one has come that can be read.
fn first(network: &mut impl Network) -> Option<FirstState> {
    let received = network.newest()?;
    let said = State::read(received.bytes)?;
    Some(FirstState { said, from: received.from, came: received.came })
}

impl<R: Robot<Joints = Joints>, N: Network> Driver<R> for Fci<N> {
    fn period(&self) -> Duration {
        PERIOD
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: self.settings.silence }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("Franka {}:{}", self.settings.robot, self.settings.port))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.reconnect()
    }

    fn close(&mut self) {
        let Some(link) = &mut self.link else { return };
        link.is_to_end = true;
        let until = self.network.now() + TIMEOUT;
        while link.motion != Motion::None && self.network.now() < until {
            match link.hear(&mut self.network) {
                Ok(Some(_)) if stopped(&link.said).is_none() => drop(link.hold(&mut self.network)),
                Ok(None) => self.network.wait(),
                Ok(Some(_)) | Err(_) => break,
            }
        }
        self.disconnect();
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let pulse = link.hear(&mut self.network)?;
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
            link.hold(&mut self.network)?;
        }
        Ok(pulse)
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        self.link.as_ref().map(Link::measured).ok_or(CLOSED)
    }

    fn held(&self) -> Option<Joints> {
        self.link.as_ref().map(|link| link.setpoint().q)
    }

    fn wrench(&self) -> Option<Wrench> {
        self.link.as_ref()?.said.external.wrench()
    }

    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let network = &mut self.network;
        let stays = (demanded - link.setpoint().q).amax() <= LAST_BITS;
        match link.motion {
            // A robot that moves is told nothing of these.
            Motion::None if !link.behaviour.is_known() => {
                link.tell_behaviour(network)?;
            }
            // Without a motion the robot holds by itself, and needs no answers.
            Motion::None if link.ended.is_some() || stays => {}
            Motion::None => {
                link.motion = Motion::Asked(link.ask(network, Request::Move)?);
            }
            Motion::Runs(_) if stays && !link.behaviour.is_known() => {
                link.is_to_end = true;
                link.hold(network)?;
            }
            Motion::Runs(_) => {
                link.is_to_end = false;
                link.is_alone = false;
                link.go_to(network, demanded)?;
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
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let is_lost = self.network.now().saturating_sub(link.heard) > self.settings.silence;
        let heard = link.hear(&mut self.network);
        if heard.is_err() || (is_lost && heard == Ok(None)) {
            self.reconnect()?;
        }
        let link = self.link.as_mut().ok_or(CLOSED)?;
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
        let Some(link) = &mut self.link else { return Ok(Recovery::Over) };
        link.hear(&mut self.network)?;
        match link.said.mode {
            Mode::Reflex if !link.has_recovered => {
                link.recovery = Some(link.ask(&mut self.network, Request::Recover)?);
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
