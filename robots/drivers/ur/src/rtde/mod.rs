//! The Real-Time Data Exchange (RTDE) of Universal Robots, protocol version 2: what a controller tells in every period, and
//! what it takes.
//!
//! In: bytes of a connection. Out: requests, answers and values; and back into bytes. Both ends use it, the driver and a
//! controller in tests. Facts: UR's guide to RTDE, and its client library 2.14.
//!
//! ```text
//! package:  u16 length with this header, u8 kind, payload; all numbers big-endian
//! client:   Version, ControllerVersion, Outputs (names), Inputs (names), Start, Pause, Data (inputs)
//! answers:  the same kinds; recipes with types for names; Data (outputs) in every period once started; Text
//! ```

mod message;
mod value;

pub use message::{Answer, MAX_NAMES, MAX_PACKAGE, Package, Request, TooLong, VERSION};
pub use value::{Offer, Type, Value, Values};
