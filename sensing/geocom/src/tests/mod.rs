//! The driver against the simulated instrument, over lines that fail in every manner: under a virtual clock, and a little of it over real lines.

mod client;
mod instrument;
mod real_time;
mod sensor;

use core::time::Duration;

use mrroc::prelude::*;

use super::*;
use instrument::{Instrument, line_to};

const AXES: [f64; 3] = [4e-5, -7e-5, 6e-5];
const DIRECTION: [f64; 2] = [0.7, -0.3];

/// What the instrument does.
fn simulated() -> Simulated<Targets> {
    Simulated::new(Targets { directions: vec![DIRECTION, [-2.0, 0.1]], axes: AXES })
}

const MS: fn(u64) -> Duration = Duration::from_millis;
