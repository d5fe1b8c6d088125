//! A robot's inputs and outputs, and what it carries, as its EDP tells the drives.
//!
//! In: what demands switch, steps, stops. Out: the outputs that the drives are told, at the servo period in which they come to
//! the position of the demand; what a stop makes of them, at once; the values of all signals for the robot's image.

use core::time::Duration;
use std::collections::VecDeque;

use crate::control::guarded::guarded;
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::load::Load;
use crate::model::robot::Robot;
use crate::model::signals::{Outputs, Signals};
use crate::model::time::Nanos;

use super::servo::Servo;

/// What a cell declares of a robot's signals.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Declared {
    /// Whether the robot has any signal with a name.
    pub any: bool,
    /// The outputs that have names.
    pub outputs: Outputs,
    /// What those take at a stop that do not hold.
    pub on_stop: Outputs,
    /// What the robot carries at the start.
    pub load: Option<Load>,
}

/// What is told with a demand of a step.
struct Told {
    /// When the drives have come to the demand \[ns\].
    due: Nanos,
    outputs: Outputs,
}

/// The signals of a robot.
pub(super) struct SignalPort {
    declared: Declared,
    /// The last value that each output was told.
    told: Outputs,
    /// What accepted demands switch, in the order of their steps, until the drives have come there.
    coming: VecDeque<Told>,
    /// What is accepted for the step that is about to begin.
    next: Outputs,
    /// What the drives are to be told that the robot carries, and what they were told last.
    load: Option<Load>,
    carried: Option<Load>,
    /// For how many steps the robot must still stand until it reckons with that.
    untaken: u64,
    /// Whether the drives may not know what they were told.
    forgot: bool,
    /// What the drives said last.
    signals: Signals,
    period: Nanos,
    delay: Nanos,
}

impl SignalPort {
    /// Of drives that are `delay` behind their demands, in steps of `period`.
    pub fn new(declared: Declared, period: Duration, delay: Option<Duration>) -> Self {
        let period = (period.as_nanos() as Nanos).max(1);
        let delay = delay.map_or(0, |delay| delay.as_nanos() as Nanos);
        let room = if declared.any { 2 + delay.div_ceil(period) as usize } else { 0 };
        SignalPort {
            declared,
            told: Outputs::NONE,
            coming: VecDeque::with_capacity(room),
            next: Outputs::NONE,
            load: declared.load,
            carried: None,
            untaken: 0,
            forgot: false,
            signals: Signals::OFF,
            period,
            delay,
        }
    }

    /// What the robot's inputs read, and what its outputs are.
    pub const fn signals(&self) -> &Signals {
        &self.signals
    }

    /// What the drives were told last that the robot carries.
    pub const fn carried(&self) -> Option<&Load> {
        self.carried.as_ref()
    }

    /// Whether all that was demanded of the outputs has been told, and the robot has had its time to take the load.
    pub fn has_switched(&self) -> bool {
        self.next.is_none() && self.coming.is_empty() && self.untaken == 0
    }

    /// Whether the robot has any.
    pub const fn has_any(&self) -> bool {
        self.declared.any
    }

    /// Whether the robot can be told what a demand tells its outputs, and to carry what it says.
    ///
    /// # Errors
    /// `NoOutput` for an output without a name, or a number that is none; a load of no body.
    pub fn check<R: Robot>(&self, demand: &Demand<R>) -> Result<(), Fault> {
        if demand.outputs.is_none() && demand.load().is_none() {
            return Ok(());
        }
        let outputs = &demand.outputs;
        if !outputs.are_among(&self.declared.outputs) {
            let known = |channel| self.declared.outputs.value(channel).is_some();
            let strange = outputs.iter().find(|&(channel, _)| !known(channel));
            let text =
                strange.map_or_else(String::new, |(channel, _)| format!("no output is named for {channel}"));
            return Err(Fault::new(FaultKind::NoOutput).text(&text));
        }
        if !outputs.are_finite() {
            return Err(Fault::new(FaultKind::NoOutput).text("an analog output is told what is no number"));
        }
        match demand.load().and_then(|load| load.fault()) {
            Some(wrong) => Err(Fault::thrown(&format!("the load of a demand is that of no body: {wrong}"))),
            None => Ok(()),
        }
    }

    /// A demand has been accepted for the step that is about to begin.
    pub fn accept<R: Robot>(&mut self, demand: &Demand<R>) {
        if !demand.outputs.is_none() {
            self.next = self.next.and(&demand.outputs);
        }
        if let Some(load) = demand.load() {
            self.load = Some(load);
        }
    }

    /// The step begins: its drives come to its demand after the cell's delay. What the robot carries it is told now, but not
    /// that it carries nothing before it was told anything else: a tool without a mass leaves what is set at a pendant as it is.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn begin_step<R: Robot>(&mut self, step: u64, servo: &mut Servo<R>) -> Result<(), Fault> {
        if !self.next.is_none() {
            let outputs = core::mem::replace(&mut self.next, Outputs::NONE);
            self.coming.push_back(Told { due: step * self.period + self.delay, outputs });
        }
        if servo.has_settled() {
            self.untaken = self.untaken.saturating_sub(1);
        }
        let Some(load) = self.load.take() else { return Ok(()) };
        if self.carried.is_none() && load == Load::NONE {
            return Ok(());
        }
        self.carried = Some(load);
        let mut time = Duration::ZERO;
        let carried = told(servo, |servo| {
            servo.drive.carry(&load);
            time = servo.drive.load_time();
        });
        self.untaken = (time.as_nanos() as Nanos).div_ceil(self.period);
        carried
    }

    /// A servo period that ends at this time: switches what is due, and looks at all signals.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn tick<R: Robot>(&mut self, ends: Nanos, servo: &mut Servo<R>) -> Result<(), Fault> {
        if !self.declared.any {
            return Ok(());
        }
        let mut is_due = core::mem::take(&mut self.forgot) && !self.told.is_none();
        while let Some(first) = self.coming.front().filter(|first| first.due <= ends) {
            self.told = self.told.and(&first.outputs);
            self.coming.pop_front();
            is_due = true;
        }
        if is_due {
            self.switch(servo)?;
        }
        Ok(())
    }

    /// Looks at all signals, after a servo period.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn look<R: Robot>(&mut self, servo: &mut Servo<R>) -> Result<(), Fault> {
        if !self.declared.any {
            return Ok(());
        }
        let mut signals = self.signals;
        let looked = told(servo, |servo| signals = servo.drive.signals());
        self.signals = signals;
        looked
    }

    /// Drives that had no power, or were opened anew, are told again what they were told before.
    pub fn tell_again(&mut self) {
        self.forgot = true;
        self.load = self.load.or(self.carried);
    }

    /// A stop: outputs take the values that the cell declares for it, and hold otherwise. What was to come does not, and no stop waits
    /// for a robot to take a load.
    ///
    /// # Errors
    /// The driver's panic.
    pub fn stop<R: Robot>(&mut self, servo: &mut Servo<R>) -> Result<(), Fault> {
        self.coming.clear();
        self.next = Outputs::NONE;
        self.untaken = 0;
        let stopped = self.told.and(&self.declared.on_stop);
        if stopped == self.told {
            return Ok(());
        }
        self.told = stopped;
        self.switch(servo)
    }

    fn switch<R: Robot>(&self, servo: &mut Servo<R>) -> Result<(), Fault> {
        told(servo, |servo| servo.drive.switch_outputs(&self.told))
    }
}

/// Tells the drives something, unless they panicked: what those still do is unknown.
fn told<R: Robot>(servo: &mut Servo<R>, tell: impl FnOnce(&mut Servo<R>)) -> Result<(), Fault> {
    if servo.lost {
        return Ok(());
    }
    let result = guarded(|| tell(servo));
    servo.lost |= result.is_err();
    result
}
