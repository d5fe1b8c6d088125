//! The operator: start, suspend, resume, abort, stop, speed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

/// The operator's handle of a cell. It may be cloned and used from any thread.
///
/// Speed and Suspend scale the path time of every step with a bounded change of rate, so that the robots slow
/// down on their paths; Abort stops on the path too and then ends the instruction with a fault; Stop ends the cell so.
#[derive(Clone, Debug, Default)]
pub struct Operator {
    panel: Arc<Panel>,
}

#[derive(Debug, Default)]
struct Panel {
    /// Bits of the speed, counted from those of full speed, which is the default.
    speed: AtomicU64,
    suspended: AtomicBool,
    stopped: AtomicBool,
    /// One of the stages below.
    stage: AtomicU8,
}

/// No Move or Wait of the MP is at work.
const IDLE: u8 = 0;
/// One is.
const RUNNING: u8 = 1;
/// The operator aborts it.
const ABORTING: u8 = 2;

/// The bits of full speed.
const FULL: u64 = 1.0_f64.to_bits();

/// A speed that is no share of the planned one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("speed {0} is not within 0 to 1 (0 to 100 % of the plan)")]
pub struct BadSpeed(pub f64);

impl Operator {
    pub(crate) fn new() -> Operator {
        Operator::default()
    }

    /// Sets the speed as a share of the planned one, 0 to 1.
    ///
    /// # Errors
    /// [`BadSpeed`] when it is not; the speed stays as it was.
    pub fn set_speed(&self, speed: f64) -> Result<(), BadSpeed> {
        if !(0.0..=1.0).contains(&speed) {
            return Err(BadSpeed(speed));
        }
        self.panel.speed.store(speed.to_bits() ^ FULL, Ordering::Release);
        Ok(())
    }

    /// The speed that is set.
    #[must_use]
    pub fn speed(&self) -> f64 {
        f64::from_bits(self.panel.speed.load(Ordering::Acquire) ^ FULL)
    }

    /// Stops all robots on their paths; the instruction goes on at [`resume`](Operator::resume).
    pub fn suspend(&self) {
        self.panel.suspended.store(true, Ordering::Release);
    }

    /// Continues a suspended instruction.
    pub fn resume(&self) {
        self.panel.suspended.store(false, Ordering::Release);
    }

    /// Stops all robots on their paths and ends the present instruction with a fault of kind `Aborted`.
    ///
    /// Refused while nothing [runs](Operator::is_running): there is nothing to abort, and the next instruction is
    /// not aborted for it. Pressed again while it is being carried out, it changes nothing.
    pub fn abort(&self) {
        let _ = self.panel.stage.compare_exchange(RUNNING, ABORTING, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Stops all robots on their paths for good: the cell stops with a fault of kind `ProtectiveStop`, which is latched at
    /// standstill. Pressed while nothing runs, it stops the next instruction before it moves anything.
    pub fn stop(&self) {
        self.panel.stopped.store(true, Ordering::Release);
    }

    /// Whether the cell is told to stop.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.panel.stopped.load(Ordering::Acquire)
    }

    /// Whether a Move or a Wait of the MP is at work, or has handed moving robots over to the next one: what can
    /// be aborted.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.panel.stage.load(Ordering::Acquire) != IDLE
    }

    /// Whether the cell is suspended.
    #[must_use]
    pub fn is_suspended(&self) -> bool {
        self.panel.suspended.load(Ordering::Acquire)
    }

    pub(crate) fn is_aborting(&self) -> bool {
        self.panel.stage.load(Ordering::Acquire) == ABORTING
    }

    /// An instruction begins, or takes over from the one before it with its abort.
    pub(crate) fn begin(&self) {
        let _ = self.panel.stage.compare_exchange(IDLE, RUNNING, Ordering::AcqRel, Ordering::Acquire);
    }

    /// The instruction is over, at standstill; whether it was being aborted.
    pub(crate) fn end(&self) -> bool {
        self.panel.stage.swap(IDLE, Ordering::AcqRel) == ABORTING
    }

    /// The rate that the operator wants now.
    pub(crate) fn wanted_rate(&self) -> f64 {
        if self.is_suspended() || self.is_aborting() { 0.0 } else { self.speed() }
    }
}
