//! Inputs and outputs for simulated drives that have none of their own.
//!
//! In: what outputs are told; wires from outputs to inputs, each with a delay. Out: what the inputs read. Everything else is
//! what the drives do without them.

use core::time::Duration;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Channels, Driver, Measured, Recovery, Regulators, SimulatedDrives, Stepped};
use crate::model::joints::JointVector;
use crate::model::load::Load;
use crate::model::pace::{Pace, Pulse};
use crate::model::robot::Robot;
use crate::model::signals::{Channel, Outputs, Signals, Value, Values};
use crate::model::wrench::Wrench;

/// An input that follows an output: it reads what the output has been for so long.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimulatedWire {
    pub input: Channel,
    pub output: Channel,
    pub after: Duration,
}

/// A wire at work.
struct Following {
    wire: SimulatedWire,
    /// What the output is, and for how many servo periods it has been that.
    value: Value,
    periods: u128,
}

/// Drives with all channels.
pub(crate) struct SimulatedSignals<R: Robot> {
    drives: Box<dyn Driver<R>>,
    signals: Signals,
    when_lost: Outputs,
    wires: Vec<Following>,
}

impl<R: Robot> SimulatedSignals<R> {
    /// These drives with these wires.
    pub fn new(drives: Box<dyn Driver<R>>, wires: &[SimulatedWire]) -> Self {
        let following =
            |&wire: &SimulatedWire| Following { wire, value: of(&Values::OFF, wire.output), periods: 0 };
        SimulatedSignals {
            drives,
            signals: Signals::OFF,
            when_lost: Outputs::NONE,
            wires: wires.iter().map(following).collect(),
        }
    }

    /// A servo period is over.
    fn follow(&mut self) {
        let period = self.drives.period().as_nanos();
        for following in &mut self.wires {
            let SimulatedWire { input, output, after } = following.wire;
            let value = of(&self.signals.outputs, output);
            following.periods = if value == following.value { following.periods + 1 } else { 0 };
            following.value = value;
            if following.periods * period >= after.as_nanos() {
                self.signals.inputs.set(input, value);
            }
        }
    }
}

/// What a channel is.
const fn of(values: &Values, channel: Channel) -> Value {
    match channel {
        Channel::Digital(number) => Value::Digital(values.is_on(number)),
        Channel::Analog(number) => Value::Analog(values.analog(number)),
    }
}

// What drives do not say here would be the default of the trait, and not what they do.
#[deny(clippy::missing_trait_methods)]
impl<R: Robot> Driver<R> for SimulatedSignals<R> {
    fn period(&self) -> Duration {
        self.drives.period()
    }

    fn pace(&self) -> Pace {
        self.drives.pace()
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.drives.pulse(now)
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.drives.open()
    }

    fn close(&mut self) {
        self.drives.close();
    }

    fn held(&self) -> Option<R::Joints> {
        self.drives.held()
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        self.drives.measured()
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        let measured = self.drives.tick(demanded);
        self.follow();
        measured
    }

    fn channels(&self) -> Channels {
        Channels::ALL
    }

    fn signals(&self) -> Signals {
        self.signals
    }

    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.signals.outputs = outputs.onto(&self.signals.outputs);
    }

    fn declare_outputs(&mut self, _: &Outputs, when_lost: &Outputs) {
        self.when_lost = *when_lost;
    }

    fn carry(&mut self, load: &Load) {
        self.drives.carry(load);
    }

    fn load_time(&self) -> Duration {
        self.drives.load_time()
    }

    fn motor_currents(&self) -> Option<R::Joints> {
        self.drives.motor_currents()
    }

    fn wrench(&self) -> Option<Wrench> {
        self.drives.wrench()
    }

    fn speed_scaling(&self) -> f64 {
        self.drives.speed_scaling()
    }

    fn hardware(&self) -> Option<String> {
        self.drives.hardware()
    }

    fn has_brakes(&self) -> bool {
        self.drives.has_brakes()
    }

    fn switch_off(&mut self) {
        self.drives.switch_off();
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.drives.recover()
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.drives.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.drives.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.drives.choose_regulators(sets);
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        self.drives.simulation()?;
        Some(self)
    }

    // A simulator of others has signals of its own: its drives name hardware, and get none from here.
    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        None
    }

    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        self.drives.calibration()
    }

    fn python(&self) -> Option<String> {
        self.drives.python()
    }
}

impl<R: Robot> SimulatedDrives<R::Joints> for SimulatedSignals<R> {
    fn brake(&mut self) -> Measured<R::Joints> {
        // The controller of a robot that is told nothing any more.
        self.signals.outputs = self.when_lost.onto(&self.signals.outputs);
        self.follow();
        let unread = Measured { position: R::Joints::zeros(), velocity: R::Joints::zeros() };
        match self.drives.simulation() {
            Some(simulated) => simulated.brake(),
            None => self.drives.measured().unwrap_or(unread),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::slide::{Exact, One, Slide};

    /// Drives that brake at once.
    struct Braking(Exact);

    impl Driver<Slide> for Braking {
        fn period(&self) -> Duration {
            self.0.period()
        }
        fn measured(&self) -> Result<Measured<One>, DriveFault> {
            self.0.measured()
        }
        fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
            self.0.tick(demanded)
        }
        fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<One>> {
            Some(self)
        }
    }

    impl SimulatedDrives<One> for Braking {
        fn brake(&mut self) -> Measured<One> {
            self.0.measured
        }
    }

    const MS: Duration = Duration::from_millis(1);
    const VACUUM: Channel = Channel::Digital(0);
    const SUCKED: Channel = Channel::Digital(7);

    #[test]
    fn fault_107_outputs_of_a_robot_that_is_told_nothing_any_more_do_as_the_cell_declares() {
        let mut drives = SimulatedSignals::<Slide>::new(Box::new(Braking(Exact::new(MS))), &[]);
        let spindle = Channel::Digital(1);
        let off = Outputs::NONE.with(spindle, Value::Digital(false));
        drives.declare_outputs(&off.with(VACUUM, Value::Digital(false)), &off);
        let both = Outputs::NONE.with(VACUUM, Value::Digital(true)).with(spindle, Value::Digital(true));
        drives.switch_outputs(&both);
        drives.simulation().expect("simulated").brake();
        let outputs = drives.signals().outputs;
        assert!(outputs.is_on(0) && !outputs.is_on(1));
    }

    #[test]
    fn an_input_reads_what_its_output_has_been_for_the_time_of_the_wire() {
        let wires = [
            SimulatedWire { input: SUCKED, output: VACUUM, after: 5 * MS },
            SimulatedWire { input: Channel::Analog(1), output: Channel::Analog(0), after: Duration::ZERO },
        ];
        let mut drives = SimulatedSignals::<Slide>::new(Box::new(Exact::new(MS)), &wires);
        let reads = |drives: &mut SimulatedSignals<Slide>, periods: u32| {
            (0..periods).for_each(|_| _ = drives.tick(&One::zeros()));
            (drives.signals().inputs.is_on(7), drives.signals().inputs.analog(1))
        };
        assert_eq!(reads(&mut drives, 20), (false, 0.0));
        let told =
            |on| Outputs::NONE.with(VACUUM, Value::Digital(on)).with(Channel::Analog(0), Value::Analog(2.5));
        drives.switch_outputs(&told(true));
        // The period in which it changes is not one for which it has been on.
        assert_eq!(reads(&mut drives, 5), (false, 2.5));
        assert_eq!(reads(&mut drives, 1), (true, 2.5));
        // Shorter than the time of the wire, a change is not seen.
        drives.switch_outputs(&told(false));
        assert_eq!(reads(&mut drives, 3), (true, 2.5));
        drives.switch_outputs(&told(true));
        assert_eq!(reads(&mut drives, 20), (true, 2.5));
        assert!(drives.simulation().is_none(), "these drives cannot brake");
    }
}
