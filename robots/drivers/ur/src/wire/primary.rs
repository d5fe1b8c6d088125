//! The calibration, from the primary interface: the controller tells it to whoever calls.

#![expect(clippy::disallowed_methods, reason = "a controller is waited for before the cell runs")]

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use mrroc_driver_kit::{Cutting, Line};

use super::Lost;
use crate::calibration::Calibration;
use crate::primary::{calibration, message_length};

/// How long a controller may take to answer the call, and then to tell it.
const PATIENCE: Duration = Duration::from_secs(2);

/// Calls the controller, and waits for the message that has it.
pub(super) fn read(address: SocketAddr) -> Result<Calibration, Lost> {
    let line = Line::call(address, PATIENCE, |bytes| match message_length(bytes) {
        Ok(Some(length)) => Cutting::Frame(length),
        Ok(None) => Cutting::More,
        Err(_) => Cutting::Bad,
    });
    let mut line = line.map_err(|_| Lost("nobody answers at its primary interface: is it switched on?"))?;
    let until = Instant::now() + PATIENCE;
    loop {
        // What came before the end of the line is read, too.
        let is_open = line.is_open();
        while let Some(frame) = line.oldest() {
            if let Some(calibration) = calibration(frame.bytes()) {
                return Ok(calibration);
            }
        }
        if !is_open || Instant::now() > until {
            return Err(Lost("the controller does not tell its calibration at its primary interface"));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
}
