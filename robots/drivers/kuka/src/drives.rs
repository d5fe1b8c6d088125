//! The drives of an arm behind a controller with the Robot Sensor Interface.
//!
//! In: positions for the ends of the controller's periods. Out: an answer to each of its messages, with corrections against
//! where the arm was when the interface was switched on; what the axes read.

#[cfg(test)]
mod tests;

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::{
    Channels, DriveFault, Driver, Load, Measured, Outputs, Pace, Pulse, Robot, RobotStop, Signals, StopCause,
};
use mrroc_driver_kit::Counted;

use crate::message::FromController;
use crate::network::{Network, Sockets};
use crate::opening::{Opening, SILENT};
use crate::session::{Joints, Sent, Session};
use crate::settings::RsiSettings;
use crate::words::{self, Words};

/// Periods for which the controller may say nothing: as many as its own `Timeout` usually allows to be late.
const SILENCE: u32 = 100;

/// Answers in a row that the controller may not take, as far as it counts them, before that is told: half of what its own `Timeout`
/// usually allows.
const REFUSED: u64 = 50;

/// The drives. They are paced by the controller, and reach it through the network `N`.
#[derive(Debug)]
pub struct Rsi<N = Sockets> {
    settings: RsiSettings,
    network: N,
    words: Words,
    /// It was to be told what the arm carries.
    is_loaded: bool,
    /// Once the controller has said something.
    session: Option<Session>,
}

impl Rsi {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: RsiSettings) -> Rsi {
        Rsi::over(Sockets::new(settings.listen, settings.robot), settings)
    }

    /// What was not taken of what came to this port; `None` while it is closed.
    #[must_use]
    pub fn counted(&self) -> Option<Counted> {
        self.network.counted()
    }
}

impl<N: Network> Rsi<N> {
    /// Drives that reach their controller by other means, with its clock: a model of one in the same process.
    #[must_use]
    pub fn over(network: N, settings: RsiSettings) -> Rsi<N> {
        Rsi { settings, network, words: Words::default(), is_loaded: false, session: None }
    }

    fn timeout(&self) -> Duration {
        self.settings.period * SILENCE
    }

    fn try_open(&mut self) -> Result<Session, DriveFault> {
        let listens = self.network.listen();
        listens.map_err(|_| DriveFault::Other("this machine has no such address, or its port is taken"))?;
        let mut opening = Opening::new(self.network.now());
        loop {
            let now = self.network.now();
            let heard = heard(&mut self.network).map(|heard| (heard.said, heard.from));
            let has_come = heard.is_some();
            let step = opening.poll(now, heard, &self.settings, &mut self.words);
            send(&mut self.network, step.sent)?;
            if let Some(session) = step.outcome? {
                return Ok(*session);
            }
            if !has_come {
                self.network.wait();
            }
        }
    }
}

/// A message of the controller.
struct Heard {
    said: FromController,
    from: SocketAddr,
    came: Duration,
}

/// The newest message, if one has come that can be read. What cannot be read is not answered: the controller counts that, and so does
/// its timeout.
fn heard(network: &mut impl Network) -> Option<Heard> {
    let received = network.newest()?;
    let said = FromController::read(received.bytes)?;
    Some(Heard { said, from: received.from, came: received.came })
}

fn send(network: &mut impl Network, sent: Option<Sent>) -> Result<(), DriveFault> {
    let Some(sent) = sent else { return Ok(()) };
    let sent = network.send(sent.to, sent.message.bytes());
    sent.map_err(|_| DriveFault::Other("the network takes nothing: is the cable plugged in?"))
}

const CLOSED: DriveFault = DriveFault::Other("the controller is not connected");
const NOT_TAKEN: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::CommunicationLost)
        .named("it takes no answers: they are late, or its SENTYPE differs"),
);
const LOADED: DriveFault = DriveFault::Other(
    "a KUKA arm is told no load by its Robot Sensor Interface: set the load data of its tools at the pendant, and say none here",
);
const ANEW: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::ProgramNotRunning).named("it was started anew"));

impl<R: Robot<Joints = Joints>, N: Network> Driver<R> for Rsi<N> {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: self.timeout() }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("KUKA RSI {} at {}", self.settings.robot, self.settings.listen))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.session = None;
        match self.try_open() {
            Ok(session) => {
                self.session = Some(session);
                Ok(())
            }
            Err(fault) => {
                self.network.close();
                Err(fault)
            }
        }
    }

    fn close(&mut self) {
        // Without answers the controller stops the robot, which stands, and ends its program.
        self.session = None;
        self.network.close();
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let session = self.session.as_mut().ok_or(CLOSED)?;
        let Some(Heard { said, from, came }) = heard(&mut self.network) else { return Ok(None) };
        let now = self.network.now();
        if said.ipoc < session.said.ipoc {
            session.hear(now, said, from);
            session.begin();
            self.words.begin(&said)?;
            send(&mut self.network, session.answer(self.words.word())?)?;
            return Err(ANEW);
        }
        let age = now.saturating_sub(came);
        session.is_idle |= session.is_unanswered();
        session.hear(now, said, from);
        if session.is_idle {
            send(&mut self.network, session.answer(self.words.word())?)?;
        }
        if let Err(fault) = self.words.hear(&said, session.refused == 0) {
            session.is_idle = true;
            return Err(fault);
        }
        if session.refused >= REFUSED {
            session.refused = 0;
            session.is_idle = true;
            return Err(NOT_TAKEN);
        }
        Ok(Some(Pulse { count: session.count(), age }))
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        self.session.as_ref().map(|session| session.measured).ok_or(CLOSED)
    }

    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let session = self.session.as_mut().ok_or(CLOSED)?;
        // It is brought to rest before.
        let stands = session.demanded.replace(*demanded).is_none_or(|before| before == *demanded);
        if self.is_loaded && stands {
            session.is_idle = true;
            return Err(LOADED);
        }
        session.demand(demanded);
        send(&mut self.network, session.answer(self.words.word())?)?;
        Ok(session.measured)
    }

    fn channels(&self) -> Channels {
        words::CHANNELS
    }

    fn signals(&self) -> Signals {
        self.words.signals()
    }

    fn switch_outputs(&mut self, told: &Outputs) {
        self.words.switch(told);
    }

    fn declare_outputs(&mut self, _: &Outputs, _: &Outputs) {
        self.words.name();
    }

    /// The interface has no word for it: a fault, when the arm stands.
    fn carry(&mut self, _: &Load) {
        self.is_loaded = true;
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        let timeout = self.timeout();
        self.is_loaded = false;
        let session = self.session.as_mut().ok_or(CLOSED)?;
        session.demanded = None;
        let now = self.network.now();
        let is_silent = session.silence(now) > timeout;
        if let Some(Heard { said, from, .. }) = heard(&mut self.network) {
            session.hear(now, said, from);
        } else if is_silent {
            return Err(SILENT);
        }
        // After a silence the interface was switched on anew, and counts corrections from where the robot stands.
        if is_silent {
            session.begin();
        }
        send(&mut self.network, session.answer(self.words.word())?)
    }
}
