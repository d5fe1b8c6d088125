//! The drives of one robot in the plant: every servo period happens once, whether its command has come or not.
//!
//! ```text
//! command of this period    its position
//! a newer one               between it and the one before: simulated time was late, and makes up for it
//! an older one              on at the speed of the commands, as drives bridge what is missing
//! too old                   no power, brakes applied, for good
//! ```
//!
//! A motion that is bridged is not quite the commanded one. What they differ by fades over as many periods as were bridged: drives
//! that came back in a single period would be told a speed that no command has.
//!
//! The EDP's period `p` begins at `(p + 1/2)` periods; here it happens with its command, or at `p + 1` periods.

use std::rc::Rc;

use super::{Part, Rest, stands};
use crate::control::command::{Command, DriveSettings, Reading, Switch};
use crate::control::guarded::guarded;
use crate::link::message::Message;
use crate::link::{Board, Server};
use crate::model::driver::{Driver, Measured};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::servo::{Observer, ServoRecord};

/// Where commands come from and readings go to.
pub(super) enum Commands {
    /// Each command is answered.
    Asked(Box<dyn Server>),
    /// The newest command, and the latest reading.
    Free(Rc<dyn Board>, Rc<dyn Board>),
}

/// The drives.
pub(super) struct Drives<R: Robot> {
    edp: ProcessId,
    driver: Box<dyn Driver<R>>,
    commands: Commands,
    /// Length of a servo period \[ns\].
    servo_period: Nanos,
    /// Length of a step \[ns\].
    step_period: Nanos,
    /// For how long commands may stay away \[ns\].
    timeout: Nanos,
    /// The newest command; `None`: the robot stands where it was switched on, powered.
    newest: Option<Command<R::Joints>>,
    /// The period that happens next.
    next: u64,
    /// The position of the period before.
    at: R::Joints,
    /// By how much the newest commands change the position in a period.
    rate: R::Joints,
    /// Periods until the drives are where they are commanded to be.
    bridged: u64,
    choice: u64,
    told: DriveSettings,
    /// How often their power was switched.
    switched: u64,
    measured: Measured<R::Joints>,
    /// Who looks at each period, while the cell's time passes.
    observers: Vec<Observer<R>>,
    /// Why they have no power.
    off: Option<Off>,
    message: Message,
}

/// Drives without power.
struct Off {
    fault: Fault,
    /// Periods since the newest command, and since the brakes were applied until the robot stood.
    silent: u64,
    braking: u64,
}

impl<R: Robot> Drives<R> {
    pub fn new(
        edp: ProcessId,
        driver: Box<dyn Driver<R>>,
        measured: Measured<R::Joints>,
        commands: Commands,
        step_period: Nanos,
        timeout: Nanos,
        observers: Vec<Observer<R>>,
    ) -> Self {
        let servo_period = driver.period().as_nanos() as Nanos;
        Drives {
            edp,
            driver,
            commands,
            servo_period: servo_period.max(1),
            step_period: step_period.max(1),
            timeout,
            newest: None,
            next: 0,
            at: measured.position,
            rate: R::Joints::zeros(),
            bridged: 0,
            choice: 0,
            told: DriveSettings::default(),
            switched: 0,
            measured,
            observers,
            off: None,
            message: Message::empty(),
        }
    }

    /// Takes the command in the message, if there is one and it is new.
    fn take(&mut self) {
        if let Ok(order) = Switch::get(&self.message) {
            if order.ordinal > self.switched {
                self.switched = order.ordinal;
                self.switch(order.on);
            }
            return;
        }
        let Ok(command) = Command::get(&self.message) else { return };
        if command.switched > self.switched {
            // The EDP has given power before this demand.
            self.switched = command.switched;
            self.switch(true);
        }
        match &self.newest {
            // The first command says which period it is.
            None => self.next = command.period,
            Some(newest) if newest.period >= command.period => return,
            Some(newest) => {
                let periods = (command.period - newest.period) as f64;
                self.rate = (command.demanded - newest.demanded) * (1.0 / periods);
            }
        }
        self.newest = Some(command);
    }

    /// Switches the power. The drives are as they were before their first command: standing, and no trip is remembered.
    fn switch(&mut self, on: bool) {
        self.newest = None;
        self.off = None;
        self.rate = R::Joints::zeros();
        self.bridged = 0;
        let switched = guarded(|| match on {
            true => self.driver.switch_on().map_err(|trip| Fault::of_drive(&trip)),
            false => {
                self.driver.switch_off();
                Ok(())
            }
        });
        let read = self.read();
        self.at = self.measured.position;
        if let Err(fault) = switched.and_then(|result| result).and(read) {
            self.trip(fault);
        }
        self.tell();
        if let Commands::Free(_, readings) = &self.commands {
            readings.write(&self.message);
        }
    }

    /// Lets all servo periods up to this one happen.
    fn happen(&mut self, last: u64) {
        while self.next <= last {
            self.period();
            self.observe();
            self.next += 1;
        }
    }

    /// Shows the period to the observers, as an EDP with drives of its own does. One that panics ends them all.
    fn observe(&mut self) {
        let Some(Command { tool, .. }) = self.newest.filter(|_| !self.observers.is_empty()) else { return };
        // An EDP's period begins half a period after a multiple of it.
        let end = (self.next + 1) * self.servo_period + self.servo_period / 2;
        let record =
            ServoRecord { time: end as f64 * 1e-9, demanded: self.at, measured: self.measured, tool };
        let observers = &mut self.observers;
        if let Err(panic) = guarded(|| observers.iter_mut().for_each(|observer| observer(&record))) {
            self.observers.clear();
            self.trip(panic);
        }
    }

    fn period(&mut self) {
        let Some(newest) = self.newest else { return };
        let silent = self.next.saturating_sub(newest.period);
        if self.off.is_none() && silent * self.servo_period >= self.timeout {
            let steps = |time: Nanos| (time / self.step_period) as f64;
            let fault =
                Fault::new(FaultKind::Overrun).text("its drives got no demand and applied their brakes");
            let fault = fault.exceeds(steps(silent * self.servo_period), steps(self.timeout) - 1.0, "step");
            self.off = Some(Off { fault, silent, braking: 0 });
        }
        if let Some(off) = &mut self.off {
            if !stands(&self.measured) {
                off.braking += 1;
            }
            self.measured = guarded(|| brake(&mut *self.driver)).ok().flatten().unwrap_or(self.measured);
            return;
        }
        if newest.choice != self.choice {
            self.choice = newest.choice;
            if let Err(panic) = guarded(|| self.driver.choose_regulators(&newest.regulators)) {
                return self.trip(panic);
            }
        }
        if newest.told != self.told
            && let Err(panic) = guarded(|| self.hear(&newest.told))
        {
            return self.trip(panic);
        }
        let demanded = self.place(&newest);
        self.at = demanded;
        match guarded(|| self.driver.tick(&demanded)) {
            Ok(Ok(measured)) => self.measured = measured,
            Ok(Err(trip)) => self.trip(Fault::of_drive(&trip)),
            Err(panic) => self.trip(panic),
        }
    }

    /// Where the drives are to be at the end of the next period.
    fn place(&mut self, newest: &Command<R::Joints>) -> R::Joints {
        self.bridged = if newest.period < self.next {
            (self.bridged + 1).min(self.timeout / self.servo_period)
        } else {
            self.bridged.saturating_sub(1)
        };
        if self.bridged == 0 && newest.period == self.next {
            return newest.demanded;
        }
        let commanded = newest.demanded + self.rate * (self.next as f64 - newest.period as f64);
        let apart = self.at - (commanded - self.rate);
        commanded + apart * (self.bridged as f64 / (self.bridged + 1) as f64)
    }

    /// Tells the drives what is new beside where to be.
    fn hear(&mut self, told: &DriveSettings) {
        if told.outputs != self.told.outputs {
            self.driver.switch_outputs(&told.outputs);
        }
        if told.loads != self.told.loads {
            self.driver.carry(&told.load);
        }
        self.told = *told;
    }

    /// Reads the encoders; what was read last stays where they cannot be.
    fn read(&mut self) -> Result<(), Fault> {
        self.measured = self.driver.measured().map_err(|trip| Fault::of_drive(&trip))?;
        Ok(())
    }

    fn trip(&mut self, fault: Fault) {
        // The first cause counts.
        drop(self.read());
        self.off = Some(Off { fault, silent: 0, braking: 0 });
    }

    /// What the encoders read, or why the drives have no power.
    fn tell(&mut self) {
        let period = self.next.saturating_sub(1);
        match &self.off {
            None => {
                // What simulated drives tell of themselves ends no run: a panic tells nothing.
                let currents = guarded(|| self.driver.motor_currents()).unwrap_or_default();
                let signals = guarded(|| self.driver.signals()).unwrap_or_default();
                Reading { period, measured: self.measured, demanded: self.at, currents, signals }
                    .put(&mut self.message);
            }
            Some(off) => {
                self.message.set_fault(&off.fault);
                self.message.header.step = period;
            }
        }
        // A reading of the time before a switch is recognised by this number.
        self.message.header.instruction = self.switched as u32;
    }
}

/// One servo period without power; drives that are not simulated brake by themselves. `None`: they cannot be read.
fn brake<R: Robot>(driver: &mut dyn Driver<R>) -> Option<Measured<R::Joints>> {
    match driver.simulation() {
        Some(simulated) => Some(simulated.brake()),
        None => driver.measured().ok(),
    }
}

impl<R: Robot> Part for Drives<R> {
    fn serve(&mut self) {
        loop {
            match &self.commands {
                Commands::Asked(port) if port.receive(&mut self.message) => {}
                Commands::Asked(_) => return,
                Commands::Free(commands, _) => {
                    if commands.read(&mut self.message) {
                        self.take();
                    }
                    return;
                }
            }
            self.take();
            if let Some(newest) = self.newest {
                self.happen(newest.period);
            }
            self.tell();
            if let Commands::Asked(port) = &self.commands {
                port.reply(&self.message);
            }
        }
    }

    fn advance(&mut self, now: Nanos) {
        let over = now / self.servo_period;
        if self.newest.is_none() {
            self.next = over;
            return;
        }
        if over > self.next {
            self.happen(over - 1);
            self.tell();
            if let Commands::Free(_, readings) = &self.commands {
                readings.write(&self.message);
            }
        }
    }

    fn due(&self) -> Option<Nanos> {
        let waits = match (&self.commands, &self.newest) {
            // Nobody wakes it for what is shown to it, such as power after a reset.
            (Commands::Free(..), _) => true,
            (Commands::Asked(_), None) => false,
            (Commands::Asked(_), Some(_)) => self.off.is_none() || !self.rests(),
        };
        waits.then(|| (self.next + 1) * self.servo_period)
    }

    fn blindfold(&mut self) {
        self.observers.clear();
    }

    fn rests(&self) -> bool {
        match &self.off {
            None => self.newest.is_none(),
            Some(_) => stands(&self.measured),
        }
    }

    fn rest(&self) -> Option<Rest> {
        // One that stood already has nothing to tell.
        let off = self.off.as_ref().filter(|off| off.silent > 0 && off.braking > 0)?;
        let steps = |periods: u64| (periods * self.servo_period).div_ceil(self.step_period);
        Some(Rest { edp: self.edp, braked_after: steps(off.silent), stood_after: steps(off.braking) })
    }
}
