//! Theodolites and total stations that speak GeoCOM (Leica's interface: lines of ASCII over a serial port).
//!
//! | part | in | out |
//! |---|---|---|
//! | [`Request`], [`Answer`] | a line | what is asked and answered, and back |
//! | [`Client`] | where to sight, in which face; the time, and bytes | angles as this workspace counts them, or [`GeocomError`]; bytes, and until when to wait |
//! | [`Lines`] | bytes in pieces | lines |
//! | [`Line`] | a serial port, or anything else with a descriptor | bytes, within a time |
//! | [`Connection`] | a line, and where to sight | what a client says, by the machine's clock |
//! | [`Theodolite`] | a sight as an order | the virtual sensor of a cell |
//! | [`Simulated`] | requests of any client | what an instrument would answer |
//!
//! GeoCOM counts the horizontal angle clockwise, and the vertical one from the zenith on, through to 2 pi in the second face. Everything else here counts the
//! horizontal angle from x to y of a frame with z up, and the elevation, both as of the first face, so that the mean of both faces is a plain mean.

mod action;
mod angles;
mod client;
mod connection;
mod exchange;
mod framing;
mod handover;
mod line;
mod protocol;
mod sensor;
mod simulated;
#[cfg(test)]
mod tests;

pub use action::{ClientAction, GeocomError, Measured};
pub use angles::{Face, from_circles, to_circles};
pub use client::{Client, Timeouts};
pub use connection::Connection;
pub use framing::Lines;
pub use handover::{Angles, Sight};
pub use line::Line;
pub use protocol::{Answer, Code, Request};
pub use sensor::{Sighting, Theodolite};
pub use simulated::{Scope, Simulated, Targets};
