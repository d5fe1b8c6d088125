//! The drives of an arm behind a controller with the Robot Sensor Interface.
//!
//! In: positions for the ends of the controller's periods. Out: an answer to each of its messages, with corrections against
//! where the arm was when the interface was switched on; what the axes read.

#![expect(
    clippy::disallowed_methods,
    reason = "before the cell runs, and after it was stopped, the controller is waited for"
)]

#[cfg(test)]
mod tests;

use core::time::Duration;
use std::net::{IpAddr, SocketAddr};
use std::time::Instant;

use mrroc::robot::{
    Channels, DriveFault, Driver, Load, Measured, Outputs, Pace, Pulse, Robot, RobotStop, Signals, StopCause,
};
use mrroc_driver_kit::{Counted, Datagram, Guest};
use nalgebra::SVector;

use crate::corrections::{Corrections, Counts, Sum};
use crate::message::{AXES, FromController, ToController};
use crate::words::{self, Words};

/// Joint positions [rad].
type Joints = SVector<f64, AXES>;

/// Periods for which the controller may say nothing: as many as its own `Timeout` usually allows to be late.
const SILENCE: u32 = 100;

/// Answers in a row that the controller may not take, as far as it counts them, before that is told: half of what its own `Timeout`
/// usually allows.
const REFUSED: u64 = 50;

/// How often it is tried to find out when the controller counts a late answer: it may be late by itself meanwhile.
const TRIALS: u32 = 10;

/// How long to wait for the first message, when the drives are opened.
const FIRST: Duration = Duration::from_secs(2);

/// A controller, and where this machine listens for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RsiSettings {
    /// This machine's address on the controller's network, and the port there: the `IP_NUMBER` and `PORT` of its
    /// configuration.
    pub listen: SocketAddr,
    /// The controller's address: messages of anybody else are not looked at.
    pub robot: IpAddr,
    /// The name that the controller's configuration gives this end, its `SENTYPE`; `ImFree` by default, as in KUKA's examples.
    pub sensor: String,
    /// The controller's period, 4 ms by default, or 12.
    pub period: Duration,
    /// What corrections count from: [`Corrections::Absolute`] by default.
    pub corrections: Corrections,
}

impl RsiSettings {
    /// With the defaults.
    #[must_use]
    pub fn new(listen: SocketAddr, robot: IpAddr) -> RsiSettings {
        RsiSettings {
            listen,
            robot,
            sensor: "ImFree".to_owned(),
            period: Duration::from_millis(4),
            corrections: Corrections::Absolute,
        }
    }
}

/// The drives. They are paced by the controller.
#[derive(Debug)]
pub struct Rsi {
    settings: RsiSettings,
    words: Words,
    /// It was to be told what the arm carries.
    is_loaded: bool,
    link: Option<Link>,
}

/// The connection, once the controller has said something.
#[derive(Debug)]
struct Link {
    guest: Guest,
    /// Where the axes were when the interface was switched on, against which demands are counted \[deg\].
    start: [f64; AXES],
    /// What the controller was told.
    sum: Sum,
    /// Answers in a row that it has not taken.
    refused: u64,
    /// The controller's last message, and when it was read.
    said: FromController,
    read: Instant,
    /// The same as a datagram while it is to be answered.
    unanswered: Option<Datagram>,
    /// Whether nobody demands anything: then messages are answered as soon as they are read, so that the controller does
    /// not break off.
    is_idle: bool,
    measured: Measured<Joints>,
    /// The position that was demanded last.
    demanded: Option<Joints>,
}

impl Rsi {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: RsiSettings) -> Rsi {
        Rsi { settings, words: Words::default(), is_loaded: false, link: None }
    }

    /// What was not taken of what came to this port; `None` while it is closed.
    #[must_use]
    pub fn counted(&self) -> Option<Counted> {
        self.link.as_ref().map(|link| link.guest.counted())
    }

    fn link(&mut self) -> Result<&mut Link, DriveFault> {
        self.link.as_mut().ok_or(CLOSED)
    }

    fn patience(&self) -> Duration {
        self.settings.period * SILENCE
    }
}

const CLOSED: DriveFault = DriveFault::Other("the controller is not connected");
const SILENT: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::ProgramNotRunning).named("the controller sends nothing").at_pendant(),
);
const NOT_TAKEN: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::CommunicationLost)
        .named("it takes no answers: they are late, or its SENTYPE differs"),
);
const NO_DELAY: DriveFault =
    DriveFault::Other("relative corrections need its count of late answers: let it send DEF_Delay");
const NO_COUNT: DriveFault = DriveFault::Other(
    "relative corrections need its count of late answers, and it does not count one that is left out: write corrections = \"absolute\"",
);
const LOADED: DriveFault = DriveFault::Other(
    "a KUKA arm is told no load by its Robot Sensor Interface: set the load data of its tools at the pendant, and say none here",
);
const ANEW: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::ProgramNotRunning).named("it was started anew"));

/// The next message of the controller.
fn next(guest: &mut Guest, until: Instant) -> Option<(FromController, Datagram)> {
    while Instant::now() < until {
        let datagram = guest.newest();
        let said = datagram.as_ref().and_then(|datagram| FromController::read(datagram.bytes()));
        if let (Some(said), Some(datagram)) = (said, datagram) {
            return Some((said, datagram));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    None
}

impl Link {
    /// Answers the message that is to be answered, with what was told last.
    fn answer(&mut self, sensor: &str, outputs: Option<u16>) -> Result<(), DriveFault> {
        let Some(datagram) = self.unanswered.take() else { return Ok(()) };
        let answer = ToController::corrections(sensor, self.said.ipoc, &self.sum.next(), outputs);
        let answer = answer.map_err(|_| DriveFault::Other("the name of the sensor is too long"))?;
        let sent = self.guest.answer(&datagram, answer.bytes());
        sent.map_err(|_| DriveFault::Other("the network takes nothing: is the cable plugged in?"))
    }

    /// Takes over what the controller says.
    fn hear(&mut self, said: FromController, datagram: Datagram, period: Duration) {
        let passed = said.ipoc.saturating_sub(self.said.ipoc);
        let counted = said.late.unwrap_or(0).saturating_sub(self.said.late.unwrap_or(0));
        let whole = passed / millis(period);
        self.sum.settle(said.ipoc / millis(period), said.late.unwrap_or(0));
        self.refused = if whole > 0 && counted >= whole { self.refused + whole } else { 0 };
        let periods = passed as f64 / (period.as_secs_f64() * 1e3);
        let position = radians(&said.axes);
        let velocity = match periods > 0.0 {
            true => (position - self.measured.position) / (periods * period.as_secs_f64()),
            false => Joints::zeros(),
        };
        self.measured = Measured { position, velocity };
        (self.said, self.read, self.unanswered) = (said, Instant::now(), Some(datagram));
    }

    /// When the controller counts a late answer: one of its messages is left unanswered, while nothing moves.
    fn find_out(
        &mut self,
        period: Duration,
        sensor: &str,
        outputs: Option<u16>,
    ) -> Result<Counts, DriveFault> {
        let until = Instant::now() + FIRST;
        // Whether the message is the next one, and how many answers are late by it.
        let next_one = |link: &mut Link, answers: bool| -> Result<Option<u64>, DriveFault> {
            let (said, datagram) = next(&mut link.guest, until).ok_or(SILENT)?;
            let is_next = said.ipoc == link.said.ipoc + millis(period);
            link.hear(said, datagram, period);
            if answers {
                link.answer(sensor, outputs)?;
            }
            let late = said.late.ok_or(NO_DELAY)?;
            Ok(is_next.then_some(late))
        };
        for _ in 0..TRIALS {
            let before = next_one(self, true)?;
            let Some(left_out) = next_one(self, false)? else { continue };
            let at_once = next_one(self, true)?;
            let later = next_one(self, true)?;
            // Whatever else was late meanwhile says nothing.
            if before != Some(left_out) {
                continue;
            }
            match (at_once, later) {
                (Some(once), Some(twice)) if once == left_out + 1 && twice <= once => {
                    return Ok(Counts::AtOnce);
                }
                (Some(once), Some(twice)) if once == left_out && twice == once + 1 => {
                    return Ok(Counts::Later);
                }
                _ => {}
            }
        }
        Err(NO_COUNT)
    }

    /// The interface was switched on where the robot is now.
    fn begin(&mut self, period: Duration) {
        self.start = self.said.axes;
        self.sum.clear(self.said.ipoc / millis(period), self.said.late.unwrap_or(0));
        self.refused = 0;
        self.measured.velocity = Joints::zeros();
        self.is_idle = true;
    }
}

/// A period, in the unit of the controller's clock.
fn millis(period: Duration) -> u64 {
    (period.as_millis() as u64).max(1)
}

fn radians(degrees: &[f64; AXES]) -> Joints {
    Joints::from_fn(|i, _| degrees[i].to_radians())
}

impl<R: Robot<Joints = Joints>> Driver<R> for Rsi {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn pace(&self) -> Pace {
        Pace::Robot { patience: self.patience() }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("KUKA RSI {} at {}", self.settings.robot, self.settings.listen))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // The port is let go before.
        self.link = None;
        let guest = Guest::expect(self.settings.listen, self.settings.robot);
        let mut guest =
            guest.map_err(|_| DriveFault::Other("this machine has no such address, or its port is taken"))?;
        let until = Instant::now() + FIRST;
        let (said, datagram) = next(&mut guest, until).ok_or(SILENT)?;
        let measured = Measured { position: radians(&said.axes), velocity: Joints::zeros() };
        let mut link = Link {
            guest,
            start: said.axes,
            sum: Sum::new(self.settings.corrections, Counts::AtOnce),
            refused: 0,
            said,
            read: Instant::now(),
            unanswered: Some(datagram),
            is_idle: true,
            measured,
            demanded: None,
        };
        self.words.begin(&said)?;
        let outputs = self.words.word();
        let (period, sensor) = (self.settings.period, self.settings.sensor.clone());
        link.begin(period);
        link.answer(&sensor, outputs)?;
        if self.settings.corrections == Corrections::Relative {
            let counts = link.find_out(period, &sensor, outputs)?;
            link.sum = Sum::new(self.settings.corrections, counts);
            link.begin(period);
        }
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        // Without answers the controller stops the robot, which stands, and ends its program.
        self.link = None;
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let period = self.settings.period;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let Some(datagram) = link.guest.newest() else { return Ok(None) };
        // What cannot be read is not answered: the controller counts that, and so does its patience.
        let Some(said) = FromController::read(datagram.bytes()) else { return Ok(None) };
        if said.ipoc < link.said.ipoc {
            link.hear(said, datagram, period);
            link.begin(period);
            self.words.begin(&said)?;
            link.answer(&self.settings.sensor, self.words.word())?;
            return Err(ANEW);
        }
        let age = datagram.age();
        link.is_idle |= link.unanswered.is_some();
        link.hear(said, datagram, period);
        if link.is_idle {
            link.answer(&self.settings.sensor, self.words.word())?;
        }
        if let Err(fault) = self.words.hear(&said, link.refused == 0) {
            link.is_idle = true;
            return Err(fault);
        }
        if link.refused >= REFUSED {
            link.refused = 0;
            link.is_idle = true;
            return Err(NOT_TAKEN);
        }
        let count = said.ipoc / millis(period);
        Ok(Some(Pulse { count, age }))
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        self.link.as_ref().map(|link| link.measured).ok_or(CLOSED)
    }

    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let sensor = &self.settings.sensor;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        // It is brought to rest before.
        let stands = link.demanded.replace(*demanded).is_none_or(|before| before == *demanded);
        if self.is_loaded && stands {
            link.is_idle = true;
            return Err(LOADED);
        }
        link.sum.demand(&core::array::from_fn(|i| demanded[i].to_degrees() - link.start[i]));
        link.is_idle = false;
        link.answer(sensor, self.words.word())?;
        Ok(link.measured)
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
        let (period, patience) = (self.settings.period, self.patience());
        let sensor = self.settings.sensor.clone();
        self.is_loaded = false;
        let outputs = self.words.word();
        let link = self.link()?;
        link.demanded = None;
        let silent = link.read.elapsed() > patience;
        let newest = link.guest.newest();
        let said = newest.as_ref().and_then(|datagram| FromController::read(datagram.bytes()));
        if let (Some(said), Some(datagram)) = (said, newest) {
            link.hear(said, datagram, period);
        } else if silent {
            return Err(SILENT);
        }
        // After a silence the interface was switched on anew, and counts corrections from where the robot stands.
        if silent {
            link.begin(period);
        }
        link.answer(&sensor, outputs)
    }
}
