//! What is known of a controller whose interface is switched on, and what it is answered.
//!
//! In: its messages, and the time at which they are read. Out: an answer to each, with corrections against where the arm was when
//! the interface was switched on. Nothing here has a clock or a socket.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::{DriveFault, Measured};
use nalgebra::SVector;

use crate::corrections::{Counts, Sum};
use crate::message::{AXES, FromController, ToController};
use crate::settings::RsiSettings;

/// Joint positions [rad].
pub(crate) type Joints = SVector<f64, AXES>;

/// What is to be sent.
#[derive(Clone, Debug)]
pub(crate) struct Sent {
    /// Where to.
    pub to: SocketAddr,
    /// What.
    pub message: ToController,
}

/// A controller whose interface is switched on.
#[derive(Debug)]
pub(crate) struct Session {
    sensor: String,
    period: Duration,
    /// Where the axes were when the interface was switched on, against which demands are counted \[deg\].
    start: [f64; AXES],
    /// What the controller was told.
    pub sum: Sum,
    /// Answers in a row that it has not taken.
    pub refused: u64,
    /// The controller's last message, and when it was read.
    pub said: FromController,
    read: Duration,
    /// Who sent it, while it is to be answered.
    unanswered: Option<SocketAddr>,
    /// Whether nobody demands anything: then messages are answered as soon as they are read, so that the controller does
    /// not break off.
    pub is_idle: bool,
    pub measured: Measured<Joints>,
    /// The position that was demanded last.
    pub demanded: Option<Joints>,
}

impl Session {
    /// A controller that has said its first message, which is read now.
    pub fn new(settings: &RsiSettings, now: Duration, said: FromController, from: SocketAddr) -> Session {
        let mut session = Session {
            sensor: settings.sensor.clone(),
            period: settings.period,
            start: said.axes,
            sum: Sum::new(settings.corrections, Counts::AtOnce),
            refused: 0,
            said,
            read: now,
            unanswered: Some(from),
            is_idle: true,
            measured: Measured { position: radians(&said.axes), velocity: Joints::zeros() },
            demanded: None,
        };
        session.begin();
        session
    }

    /// The interface was switched on where the robot is now.
    pub fn begin(&mut self) {
        self.start = self.said.axes;
        self.sum.clear(self.count(), self.said.late.unwrap_or(0));
        self.refused = 0;
        self.measured.velocity = Joints::zeros();
        self.is_idle = true;
    }

    /// Takes over what the controller says, which is read now.
    pub fn hear(&mut self, now: Duration, said: FromController, from: SocketAddr) {
        let period = self.period;
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
        (self.said, self.read, self.unanswered) = (said, now, Some(from));
    }

    /// The answer to the message that is to be answered, with what was told last, and this word of outputs; `None` where there is
    /// no such message.
    ///
    /// # Errors
    /// The name of this end has no room.
    pub fn answer(&mut self, outputs: Option<u16>) -> Result<Option<Sent>, DriveFault> {
        let Some(to) = self.unanswered.take() else { return Ok(None) };
        let message = ToController::corrections(&self.sensor, self.said.ipoc, &self.sum.next(), outputs);
        let message = message.map_err(|_| DriveFault::Other("the name of the sensor is too long"))?;
        Ok(Some(Sent { to, message }))
    }

    /// Whether there is a message that is to be answered.
    pub fn is_unanswered(&self) -> bool {
        self.unanswered.is_some()
    }

    /// Demands this position of the axes [rad].
    pub fn demand(&mut self, demanded: &Joints) {
        self.sum.demand(&core::array::from_fn(|i| demanded[i].to_degrees() - self.start[i]));
        self.is_idle = false;
    }

    /// The count of the period in which the controller said its last message.
    pub fn count(&self) -> u64 {
        self.said.ipoc / millis(self.period)
    }

    /// For how long nothing was read.
    pub fn silence(&self, now: Duration) -> Duration {
        now.saturating_sub(self.read)
    }

    /// Whether this is what the controller says in the period after that of its last message.
    pub fn is_next(&self, said: &FromController) -> bool {
        said.ipoc == self.said.ipoc.wrapping_add(millis(self.period))
    }
}

/// A period, in the unit of the controller's clock.
fn millis(period: Duration) -> u64 {
    (period.as_millis() as u64).max(1)
}

/// As joint positions.
pub(crate) fn radians(degrees: &[f64; AXES]) -> Joints {
    Joints::from_fn(|i, _| degrees[i].to_radians())
}
