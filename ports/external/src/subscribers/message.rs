//! What subscribers are shown: a message of each robot and one of the coordinator, in each step, and one of each reading.
//!
//! In: what a process shows. Out: plain numbers in C's layout, the same in every language.

use iceoryx2::prelude::ZeroCopySend;
use mrroc::fault::{Fault, Name};
use mrroc::observe::step_observer::{IMAGE_WORDS, Mode, StepRecord};
use mrroc::payload::{WORDS, Wire};

/// The version of this interface.
pub(crate) const VERSION: u32 = 1;

/// Bytes of a fault's text.
pub(crate) const TEXT: usize = 240;

/// Bits of [`CellMessage::flags`].
pub(crate) const SUSPENDED: u32 = 1;
pub(crate) const REDUCED: u32 = 2;
pub(crate) const ABORTING: u32 = 4;
pub(crate) const STOPPING: u32 = 8;
pub(crate) const OVER: u32 = 16;

/// What a robot does when a step begins.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct RobotMessage {
    /// [`VERSION`].
    pub version: u32,
    /// How many joints it has.
    pub joints: u32,
    /// The step.
    pub step: u64,
    /// Its time on the cell's clock \[ns\].
    pub time: u64,
    /// When this was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: u64,
    /// 0 it holds, 1 moves, 2 bridges a demand that is missing, 3 brakes, 4 has no power.
    pub mode: u64,
    /// The demanded state, the measured one, the tool: see the crate's page.
    pub words: [u64; IMAGE_WORDS],
}

/// What the coordinator does when a step begins.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct CellMessage {
    /// [`VERSION`].
    pub version: u32,
    /// [`SUSPENDED`] and the others.
    pub flags: u32,
    /// The step.
    pub step: u64,
    /// Its time on the cell's clock \[ns\].
    pub time: u64,
    /// When this was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: u64,
    /// Path time of the step \[s\].
    pub path_time: f64,
    /// Time of the step \[s\].
    pub duration: f64,
    /// The speed that the operator wants, 0 to 1.
    pub speed: f64,
    /// The fault that stopped the cell, as text, and zeros; all zeros if there is none.
    pub fault: [u8; TEXT],
}

/// A reading of a virtual sensor that a process has collected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct ReadingMessage {
    /// [`VERSION`].
    pub version: u32,
    /// How many of its words say something.
    pub len: u32,
    /// The layout of what they say: a hash of its type.
    pub layout: u64,
    /// The step in which it was collected.
    pub step: u64,
    /// When that was, on the cell's clock \[ns\].
    pub time: u64,
    /// When this was sent, `CLOCK_MONOTONIC` \[ns\].
    pub sent: u64,
    /// The step in which it was taken.
    pub taken: u64,
    /// The sensor's name.
    pub sensor: [u64; Name::LEN],
    pub words: [u64; WORDS],
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: a message consists of plain numbers in C's layout without gaps: it has no pointer and nothing to drop, and every bit
// pattern is valid.
unsafe impl ZeroCopySend for RobotMessage {
    unsafe fn type_name() -> &'static str {
        "mrroc_image_1"
    }
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: as above.
unsafe impl ZeroCopySend for CellMessage {
    unsafe fn type_name() -> &'static str {
        "mrroc_step_1"
    }
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: as above.
unsafe impl ZeroCopySend for ReadingMessage {
    unsafe fn type_name() -> &'static str {
        "mrroc_reading_1"
    }
}

impl RobotMessage {
    /// Of a robot with so many joints, in a step at a time of the cell \[ns\].
    pub fn of(step: u64, time: u64, mode: Mode, joints: usize, image: &[u64]) -> RobotMessage {
        let mode = match mode {
            Mode::Holding => 0,
            Mode::Moving => 1,
            Mode::Bridging => 2,
            Mode::Braking => 3,
            Mode::Off => 4,
        };
        let mut words = [0; IMAGE_WORDS];
        let len = image.len().min(IMAGE_WORDS);
        words[..len].copy_from_slice(&image[..len]);
        RobotMessage { version: VERSION, joints: joints as u32, step, time, sent: 0, mode, words }
    }
}

impl ReadingMessage {
    /// Of a sensor whose readings have this layout, collected in a step at a time of the cell \[ns\].
    pub fn of(sensor: Name, layout: u64, [step, taken]: [u64; 2], time: u64, reading: &[u64]) -> Self {
        let (mut name, mut words) = ([0; Name::LEN], [0; WORDS]);
        sensor.put(&mut name);
        let len = reading.len().min(WORDS);
        words[..len].copy_from_slice(&reading[..len]);
        let (version, len) = (VERSION, len as u32);
        ReadingMessage { version, len, layout, step, time, sent: 0, taken, sensor: name, words }
    }
}

impl CellMessage {
    pub const BLANK: CellMessage = CellMessage {
        version: VERSION,
        flags: 0,
        step: 0,
        time: 0,
        sent: 0,
        path_time: 0.0,
        duration: 0.0,
        speed: 1.0,
        fault: [0; TEXT],
    };

    /// A step begins at a time of the cell \[ns\].
    pub fn begin(&mut self, at: u64, step: &StepRecord) {
        let bits = [
            (step.suspended, SUSPENDED),
            (step.reduced, REDUCED),
            (step.aborting, ABORTING),
            (step.stopping, STOPPING),
        ];
        self.flags = bits.iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum();
        (self.step, self.time, self.path_time) = (step.step, at, step.dt);
        (self.duration, self.speed) = (step.duration, step.speed);
        if step.resetting {
            self.fault = [0; TEXT];
        }
    }

    /// A fault has stopped it in this step, or its program is over. The first one since the last reset is kept.
    pub fn stopped(&mut self, step: u64, fault: Option<&Fault>, is_over: bool) {
        self.step = step;
        if is_over {
            self.flags |= OVER;
        }
        if let Some(fault) = fault.filter(|_| self.fault[0] == 0) {
            let text = fault.to_string();
            // A letter of several bytes is not cut.
            let end = (0..=TEXT.min(text.len())).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
            self.fault[..end].copy_from_slice(&text.as_bytes()[..end]);
        }
    }
}
