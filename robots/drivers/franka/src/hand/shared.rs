//! What the exchange with the hand and its drives hand to each other.

use core::sync::atomic::AtomicBool;

use mrroc::fault::Excess;
use mrroc::robot::DriveFault;
use mrroc_driver_kit::{Number, Times};

/// What is demanded of the hand, and its newest state.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub times: Times,
    /// Where the fingers stood when they were heard first, or were told to go last \[m\].
    pub demanded: Number,
    /// Whether fingers that close grasp, from the next motion on.
    pub presses: AtomicBool,
    /// The newest state: openings \[m\] and speed [m/s].
    pub width: Number,
    pub max_width: Number,
    pub speed: Number,
    pub is_grasped: AtomicBool,
}

impl AsRef<Times> for Shared {
    fn as_ref(&self) -> &Times {
        &self.times
    }
}

impl Shared {
    /// Where the fingers are to go \[m\].
    ///
    /// # Errors
    /// They do not open or close as far as that.
    pub fn go_to(&self, width: f64) -> Result<(), DriveFault> {
        let limit = if width < 0.0 { 0.0 } else { self.max_width.get() };
        // Where they stand they may stay, by whatever a bit that is beyond.
        if width != self.demanded.get() && !(0.0..=limit).contains(&width) {
            return Err(DriveFault::exceeded(0, "demanded opening", Excess::new(width, limit, "m")));
        }
        self.demanded.set(width);
        Ok(())
    }
}
