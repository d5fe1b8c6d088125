//! The instrument as a virtual sensor: what it is told to sight as an order, what it reads as a reading.
//!
//! A thread of its own asks the instrument, which takes seconds; a step only looks at what has come.

use core::time::Duration;
use std::os::fd::AsFd;
use std::path::PathBuf;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_driver_kit::{Talk, Watch};

use crate::action::{ClientAction, GeocomError};
use crate::client::Timeouts;
use crate::connection::Connection;
use crate::handover::{Angles, Orders, Shared, Sight, Worker, fault};
use crate::line::Line;

/// The kind of sensor.
#[derive(Clone, Copy, Debug)]
pub struct Sighting;

impl Sensor for Sighting {
    const KIND: &'static str = "geocom";
    type Reading = Angles;
    type Configuration = Sight;
}

/// How often the thread looks for a new order.
const PAUSE: Duration = Duration::from_millis(2);

/// A theodolite that speaks GeoCOM on a serial port.
#[derive(Debug)]
pub struct Theodolite {
    port: PathBuf,
    baud: u32,
    timeout: Timeouts,
    talk: Option<Talk<Shared, GeocomError>>,
    orders: Orders,
}

impl Theodolite {
    /// On such a port (`/dev/ttyUSB0`), at its speed \[baud\], 9600 of most. It is opened when the cell begins.
    #[must_use]
    pub fn on(port: impl Into<PathBuf>, baud: u32, timeout: Timeouts) -> Self {
        Self { port: port.into(), baud, timeout, talk: None, orders: Orders::default() }
    }

    /// Over a line that is open already.
    ///
    /// # Errors
    /// [`GeocomError`]: the instrument does not answer; or this machine starts no more threads.
    pub fn over<F: AsFd + Send + 'static>(line: Line<F>, timeout: Timeouts) -> Result<Self, GeocomError> {
        let talk = Some(begin(line, timeout)?);
        Ok(Self { port: PathBuf::new(), baud: 0, timeout, talk, orders: Orders::default() })
    }
}

fn begin<F: AsFd + Send + 'static>(
    line: Line<F>,
    timeout: Timeouts,
) -> Result<Talk<Shared, GeocomError>, GeocomError> {
    let mut connection = Connection::new(line, timeout);
    connection.greet()?;
    let (client, mut transport) = connection.into_parts();
    let mut worker = Worker::new(client);
    let work = move |shared: &Shared, watch: &Watch| {
        while !watch.ends() {
            let (now, bytes) = transport.take();
            match worker.poll(now, bytes, shared) {
                ClientAction::Idle => std::thread::sleep(PAUSE),
                next => {
                    let done = transport.carry_out(next, worker.client());
                    done.inspect_err(|_| worker.close(shared))?;
                }
            }
        }
        Ok(())
    };
    Talk::begin("theodolite", Shared::default(), GeocomError::Closed, work).map_err(|_| GeocomError::Closed)
}

impl VirtualSensor for Theodolite {
    type Kind = Sighting;

    fn aggregate(&mut self, order: &ReadingOrder<Sight>) -> Result<Angles, Fault> {
        let Some(talk) = &self.talk else { return Err(fault(GeocomError::Closed)) };
        self.orders.aggregate(talk.handed(), order.configuration, talk.goes_on())
    }

    fn hardware(&self) -> Option<String> {
        self.talk.is_none().then(|| format!("serial port {}", self.port.display()))
    }

    fn open(&mut self) -> Result<(), Fault> {
        if self.talk.is_some() && !self.port.as_os_str().is_empty() {
            (self.talk, self.orders) = (None, Orders::default());
        }
        if self.talk.is_none() {
            let line = Line::open(&self.port, self.baud).map_err(|why| {
                let text = format!("{} cannot be opened: {why}", self.port.display());
                Fault::new(FaultKind::SensorFailed).text(&text)
            })?;
            self.talk = Some(begin(line, self.timeout).map_err(fault)?);
        }
        Ok(())
    }
}
