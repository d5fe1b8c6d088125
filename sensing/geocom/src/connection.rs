//! An instrument at the other end of a serial line: who asks, the line, and the clock.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use crate::action::{ClientAction, GeocomError, Measured};
use crate::angles::Face;
use crate::client::{Client, Timeouts};
use crate::line::Line;

/// How long the line is waited for at most, until whoever runs a client looks at something else, such as the end of the cell.
const SLICE: Duration = Duration::from_millis(100);

/// Runs a client over a line.
#[derive(Debug)]
pub struct Transport<F> {
    line: Line<F>,
    since: Instant,
    bytes: [u8; 256],
    /// How many of them have come since the last poll.
    came: usize,
}

impl<F: AsFd> Transport<F> {
    pub fn over(line: Line<F>) -> Self {
        Self { line, since: Instant::now(), bytes: [0; 256], came: 0 }
    }

    /// The time, and what has come since this was asked last.
    pub fn take(&mut self) -> (Duration, &[u8]) {
        (self.since.elapsed(), &self.bytes[..core::mem::take(&mut self.came)])
    }

    /// Does what a client needs before it goes on, or begins to.
    ///
    /// # Errors
    /// [`GeocomError::Closed`].
    pub fn carry_out(&mut self, next: ClientAction, client: &mut Client) -> Result<(), GeocomError> {
        let left = |until: Duration| until.saturating_sub(self.since.elapsed()).min(SLICE);
        match next {
            ClientAction::Send { until } => {
                let count = self.line.send(client.outgoing(), left(until))?;
                client.sent(count);
            }
            ClientAction::Receive { until } => self.came = self.line.receive(&mut self.bytes, left(until))?,
            ClientAction::Done(_) | ClientAction::Idle => {}
        }
        Ok(())
    }
}

/// An instrument that is asked, and waited for.
#[derive(Debug)]
pub struct Connection<F> {
    client: Client,
    transport: Transport<F>,
}

impl<F: AsFd> Connection<F> {
    /// Over such a line.
    #[must_use]
    pub fn new(line: Line<F>, timeout: Timeouts) -> Self {
        Self { client: Client::new(timeout), transport: Transport::over(line) }
    }

    /// Whether the instrument answers (`COM_NullProc`).
    ///
    /// # Errors
    /// [`GeocomError`].
    pub fn greet(&mut self) -> Result<(), GeocomError> {
        self.client.greet();
        self.run().map(drop)
    }

    /// Turns the telescope over if need be, then about to these angles, lets the instrument find the target there, and measures.
    ///
    /// # Errors
    /// [`GeocomError`].
    pub fn sight(&mut self, about: [f64; 2], face: Face) -> Result<Measured, GeocomError> {
        self.client.sight(about, face);
        self.run()?.ok_or(GeocomError::Garbled)
    }

    /// Measures where the telescope points, with the compensator (`TMC_GetAngle1`).
    ///
    /// # Errors
    /// [`GeocomError`].
    pub fn measure(&mut self) -> Result<Measured, GeocomError> {
        self.client.measure();
        self.run()?.ok_or(GeocomError::Garbled)
    }

    /// Both parts, of an instrument that goes on in a thread of its own.
    pub(crate) fn into_parts(self) -> (Client, Transport<F>) {
        (self.client, self.transport)
    }

    fn run(&mut self) -> Result<Option<Measured>, GeocomError> {
        loop {
            let (now, bytes) = self.transport.take();
            match self.client.poll(now, bytes) {
                ClientAction::Done(outcome) => return outcome,
                // Something was asked for.
                ClientAction::Idle => return Ok(None),
                next => self.transport.carry_out(next, &mut self.client)?,
            }
        }
    }
}
