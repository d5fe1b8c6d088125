//! The controller: what it does in each period of 2 ms.
//!
//! In: scripts, set-points, commands of the dashboard, what persons press. Out: the fields of RTDE. There is no clock in it but the
//! count of its steps.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::net::SocketAddr;

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::{Channel, Driver, Load, Measured, Value as Level};
use mrroc_robots::{Serial, Simulated, Six, UrdfError};
use mrroc_ur::rtde::Value;
use mrroc_ur::{Calibration, Ended, JOINTS, PERIOD, RobotMode, SET_POINT_BYTES, Script, SetPoint, UrModel};

use crate::external::External;
use crate::program::{Act, Call, Running};
use crate::target::{T, Target};

/// Its clock when it is made \[s\]: clients take a robot as booted when it has been on for a while.
const BOOTED: f64 = 100.0;

/// Steps after a protective stop before which it is not released: 5 s.
const INSPECTION: u64 = 2500;

/// What persons do at a robot, and what happens to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// The button of the emergency stop, on the pendant.
    EmergencyStop,
    /// It is pulled out again: the arm has no power then.
    ReleaseEmergencyStop,
    /// The door of a guarded cell is opened.
    OpenDoor,
    /// It is closed.
    CloseDoor,
    /// Something is hit: a protective stop.
    Collide,
    /// A limit of the safety configuration was exceeded.
    Violate,
    /// The freedrive button on the back of the pendant.
    Freedrive,
    /// It is let go.
    ReleaseFreedrive,
    /// The program is stopped at the pendant.
    StopProgram,
    /// The program is paused at the pendant.
    PauseProgram,
    /// The pendant takes over: no remote control.
    TakeOver,
    /// It gives the robot back.
    GiveBack,
    /// The program that is loaded is started at the pendant, or goes on after a pause.
    Play,
}

/// What keeps the arm from moving.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stops {
    pub emergency: bool,
    pub door_open: bool,
    /// The step of a protective stop.
    pub protective: Option<u64>,
    pub violation: bool,
    pub guided: bool,
}

impl Stops {
    pub fn any(&self) -> bool {
        self.emergency || self.door_open || self.protective.is_some() || self.violation || self.guided
    }
}

/// Its terminals.
#[derive(Debug, Default)]
pub(crate) struct Terminals {
    pub digital_inputs: u64,
    pub digital_outputs: u64,
    /// The standard analog inputs and those at the tool [V or A].
    pub analog_inputs: [f64; 4],
    /// The analog outputs, as fractions of their ranges.
    pub analog_outputs: [f64; 2],
    /// By bits, which of the standard analog inputs (0 and 1) and outputs (2 and 3) are voltages.
    pub voltages: u32,
}

/// The program that is loaded at the pendant.
#[derive(Debug, Default)]
pub(crate) struct Loaded {
    pub name: Option<String>,
    /// Whether it runs without a script of its own.
    pub is_plain: bool,
    /// Where its node asks for a script, and that it is to do so now.
    pub external: Option<SocketAddr>,
    pub is_asking: bool,
}

/// Inputs of RTDE as they were written, and by which client.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    pub values: BTreeMap<String, Value>,
    pub writers: BTreeMap<String, u64>,
    pub clients: u64,
}

/// A controller with its arm.
#[derive(Debug)]
pub struct Controller {
    pub(crate) model: UrModel,
    pub(crate) arm: Serial<JOINTS>,
    pub(crate) calibration: Calibration,
    drives: Simulated<Serial<JOINTS>, JOINTS>,
    pub(crate) steps: u64,
    pub(crate) mode: RobotMode,
    pub(crate) stops: Stops,
    pub(crate) is_remote: bool,
    pub(crate) is_paused: bool,
    pub(crate) speed_fraction: f64,
    pub(crate) terminals: Terminals,
    /// What the surroundings do to the flange, about its origin and in the axes of the base.
    pub(crate) pushed: Wrench,
    /// Where the tool centre point is in the flange.
    pub(crate) tool: Pose,
    pub(crate) target: Target,
    pub(crate) measured: Measured<Six>,
    pub(crate) program: Option<Running>,
    /// The payload of its installation.
    installed: Load,
    pub(crate) loaded: Loaded,
    pub(crate) inputs: Inputs,
    unknown_scripts: u64,
    /// The longest run of steps without a set-point while a script followed them.
    longest_gap: u32,
}

impl Controller {
    /// A controller whose arm stands at `start` \[rad\] with power, in remote control.
    ///
    /// # Errors
    /// None for these models: what the URDF of an arm may be refused for.
    pub fn new(model: UrModel, start: &Six) -> Result<Controller, UrdfError> {
        let arm = model.arm(Pose::identity())?;
        let drives = Simulated::new(arm.clone(), start);
        let measured = Measured { position: *start, velocity: Six::zeros() };
        let mut controller = Controller {
            model,
            arm,
            calibration: Calibration::nominal(model),
            drives,
            steps: 0,
            mode: RobotMode::Running,
            stops: Stops::default(),
            is_remote: true,
            is_paused: false,
            speed_fraction: 1.0,
            terminals: Terminals::default(),
            pushed: Wrench::default(),
            tool: Pose::identity(),
            target: Target { position: *start, ..Target::default() },
            measured,
            program: None,
            installed: Load::NONE,
            loaded: Loaded::default(),
            inputs: Inputs::default(),
            unknown_scripts: 0,
            longest_gap: 0,
        };
        controller.look();
        Ok(controller)
    }

    /// Gives the arm a calibration of its own: poses that are told are those of these dimensions.
    ///
    /// # Errors
    /// It is the calibration of another model.
    pub fn calibrate(&mut self, calibration: &Calibration) -> Result<(), UrdfError> {
        self.arm = self.model.calibrated(Pose::identity(), calibration)?;
        self.calibration = *calibration;
        Ok(())
    }

    /// Its arm's calibration.
    #[must_use]
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// One period of 2 ms.
    pub fn step(&mut self) {
        self.steps += 1;
        let before = self.target.speed;
        if self.mode != RobotMode::Running {
            self.end_program();
            self.target.rest(self.measured.position);
            self.drives.brake();
        } else if self.stops.any() {
            self.stop_step();
        } else {
            self.program_step();
        }
        self.target.acceleration = (self.target.speed - before) / T;
        self.look();
    }

    /// Its clock \[s\].
    #[must_use]
    pub fn timestamp(&self) -> f64 {
        BOOTED + self.steps as f64 * T
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> UrModel {
        self.model
    }

    /// Where the encoders say that the joints are [rad, rad/s].
    #[must_use]
    pub fn measured(&self) -> Measured<Six> {
        self.measured
    }

    /// Where the joints are driven to \[rad\].
    #[must_use]
    pub fn target(&self) -> Six {
        self.target.position
    }

    /// How fast they are driven [rad/s].
    #[must_use]
    pub fn target_speed(&self) -> Six {
        self.target.speed
    }

    /// Whether a script runs, paused or not.
    #[must_use]
    pub fn runs(&self) -> bool {
        self.program.is_some() || self.loaded.is_plain
    }

    /// Scripts that came and were neither of `mrroc-ur` nor UR's own.
    #[must_use]
    pub fn unknown_scripts(&self) -> u64 {
        self.unknown_scripts
    }

    /// The most steps in a row, so far, for which a running script had no set-point.
    #[must_use]
    pub fn longest_gap(&self) -> u32 {
        self.longest_gap
    }

    /// The digital outputs, as bits: 0 to 7 standard, 8 to 15 configurable, 16 and 17 at the tool.
    #[must_use]
    pub fn digital_outputs(&self) -> u64 {
        self.terminals.digital_outputs
    }

    /// Switches the digital outputs, in the same order, as a person does at the pendant.
    pub fn switch_digital_outputs(&mut self, bits: u64) {
        self.terminals.digital_outputs = bits;
    }

    /// Sets the digital inputs, in the same order.
    pub fn set_digital_inputs(&mut self, bits: u64) {
        self.terminals.digital_inputs = bits;
    }

    /// The value of an input of RTDE that a client has written.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<Value> {
        self.inputs.values.get(name).copied()
    }

    /// Moves the slider of the pendant: which part of its speed a joint may use, 0 to 1.
    pub fn set_speed_fraction(&mut self, fraction: f64) {
        if (0.0..=1.0).contains(&fraction) {
            self.speed_fraction = fraction;
        }
    }

    /// What a person does, or what happens to the arm.
    pub fn press(&mut self, what: Press) {
        match what {
            Press::EmergencyStop => self.stops.emergency = true,
            Press::ReleaseEmergencyStop => self.stops.emergency = false,
            Press::OpenDoor => self.stops.door_open = true,
            Press::CloseDoor => self.stops.door_open = false,
            Press::Collide => self.protective_stop(),
            Press::Violate => self.stops.violation = true,
            Press::Freedrive => self.stops.guided = true,
            Press::ReleaseFreedrive => self.stops.guided = false,
            Press::StopProgram => self.end_program(),
            Press::PauseProgram => self.is_paused = self.runs(),
            Press::TakeOver => self.is_remote = false,
            Press::GiveBack => self.is_remote = true,
            Press::Play => drop(self.play()),
        }
    }

    /// Takes a script, in place of the one that runs. Whether it is one that is done here.
    pub fn take_script(&mut self, text: &str) -> bool {
        self.is_remote && self.run(text)
    }

    /// Runs a script if it is one that is done here.
    pub(crate) fn run(&mut self, text: &str) -> bool {
        let own = Script::read(text).map(|script| (script, None));
        let read = own.or_else(|| External::read(text).map(|of_ur| (of_ur.script, Some(of_ur.others))));
        let Some((script, others)) = read else {
            self.unknown_scripts += 1;
            return false;
        };
        if self.mode != RobotMode::Running || self.stops.any() {
            return false;
        }
        self.end_program();
        self.program = Some(Running::new(script, others, self.target.position));
        true
    }

    /// Where a script that has just been started calls, until it is [connected](Self::connected).
    #[must_use]
    pub fn calls(&self) -> Option<SocketAddr> {
        let program = self.program.as_ref()?;
        (program.call == Call::Calls).then_some(program.script.reverse)
    }

    /// What it connects to before it calls.
    #[must_use]
    pub fn others(&self) -> &[SocketAddr] {
        self.program.as_ref().and_then(|program| program.others.as_ref()).map_or(&[], |others| &others[..])
    }

    /// Its payload: what the program that runs has set, or what its installation says.
    #[must_use]
    pub fn payload(&self) -> Load {
        self.program.as_ref().and_then(|program| program.payload).unwrap_or(self.installed)
    }

    /// Writes a payload into its installation, as a person does at the pendant; nothing is there at first. Programs begin with it.
    pub fn install_payload(&mut self, load: &Load) {
        self.installed = *load;
    }

    /// The script's call was answered, or not: then it ends.
    pub fn connected(&mut self, answered: bool) {
        match &mut self.program {
            Some(program) if answered => program.call = Call::Connected,
            Some(_) | None => self.program = None,
        }
    }

    /// A set-point has come for the script.
    pub fn take_set_point(&mut self, bytes: &[u8; SET_POINT_BYTES]) {
        if let (Some(program), Some(message)) = (&mut self.program, SetPoint::read(bytes)) {
            program.take(message);
        }
    }

    /// The other end has closed the script's connection.
    pub fn hung_up(&mut self) {
        if let Some(program) = &mut self.program {
            program.call = Call::HungUp;
        }
    }

    /// Whether the script has a connection.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.program.as_ref().is_some_and(|program| program.call == Call::Connected)
    }

    /// Why the script ends, to be told to the other end: once. It ends when that has been asked for and the arm stands.
    pub fn says(&mut self) -> Option<Ended> {
        let program = self.program.as_mut()?;
        let says = program.says.filter(|_| !program.is_told);
        program.is_told |= says.is_some();
        says.filter(|_| program.others.is_none())
    }

    pub(crate) fn protective_stop(&mut self) {
        if self.stops.protective.is_none() {
            self.stops.protective = Some(self.steps);
        }
    }

    /// Releases a protective stop; whether that is allowed by now.
    pub(crate) fn unlock(&mut self) -> bool {
        let Some(since) = self.stops.protective else { return true };
        if self.steps - since < INSPECTION || self.stops.violation {
            return false;
        }
        self.stops.protective = None;
        self.drives.reset();
        self.target.position = self.measured.position;
        true
    }

    /// Gives power to the arm, with its brakes still applied.
    pub(crate) fn power_on(&mut self) {
        if self.mode == RobotMode::PowerOff && !self.stops.emergency && !self.stops.violation {
            self.mode = RobotMode::Idle;
        }
    }

    pub(crate) fn power_off(&mut self) {
        self.mode = RobotMode::PowerOff;
    }

    pub(crate) fn release_brakes(&mut self) {
        if self.mode == RobotMode::Idle {
            self.mode = RobotMode::Running;
            self.drives.reset();
            self.target.rest(self.measured.position);
        }
    }

    /// How hard stops brake [rad/s²].
    fn deceleration(&self) -> f64 {
        self.model.accelerations().min()
    }

    fn look(&mut self) {
        if let Ok(measured) = self.drives.measured() {
            self.measured = measured;
        }
    }

    pub(crate) fn currents(&self) -> Six {
        self.drives.currents()
    }

    fn end_program(&mut self) {
        (self.program, self.is_paused, self.loaded.is_plain) = (None, false, false);
    }

    /// One step of a stop by the safety system.
    fn stop_step(&mut self) {
        // A door lets the program go on when it is closed; after an emergency stop it is gone.
        if self.stops.emergency || self.stops.violation {
            self.end_program();
        } else if self.stops.protective.is_some() {
            self.is_paused = self.runs();
        }
        self.brake(self.deceleration());
        if self.target.speed == Six::zeros() && (self.stops.emergency || self.stops.violation) {
            self.mode = RobotMode::PowerOff;
        }
    }

    /// One step with nothing that stops the arm.
    fn program_step(&mut self) {
        let act = match &mut self.program {
            Some(program) if !self.is_paused => program.step(&self.target.speed, self.model.payload()),
            Some(_) | None => Act::Brake,
        };
        if let Some(program) = &self.program
            && program.says.is_none()
            && program.follows()
        {
            self.longest_gap = self.longest_gap.max(program.missing());
        }
        if let Some(program) = &self.program
            && program.says == Some(Ended::Timeout)
        {
            let when_lost = program.script.when_lost;
            let mask = u64::from(when_lost.digital());
            self.terminals.digital_outputs =
                self.terminals.digital_outputs & !mask | u64::from(when_lost.values().digital());
            for (i, output) in self.terminals.analog_outputs.iter_mut().enumerate() {
                if let Some(Level::Analog(value)) = when_lost.value(Channel::Analog(i as u8)) {
                    *output = value;
                }
            }
        }
        match act {
            Act::Servo(goal) => {
                let lookahead = self.program.as_ref().map_or(0.0, |run| run.script.lookahead.as_secs_f64());
                if !self.target.servo(&goal, self.model, self.speed_fraction, lookahead) {
                    self.protective_stop();
                    return self.stop_step();
                }
                self.drive();
            }
            Act::Fail => {
                self.end_program();
                self.brake(self.deceleration());
            }
            Act::Brake => {
                let stopj = self.program.as_ref().map(|program| program.script.deceleration);
                self.brake(stopj.unwrap_or(self.deceleration()));
                let has_told = self.program.as_ref().is_some_and(|program| program.is_told);
                if has_told && self.target.speed == Six::zeros() {
                    self.end_program();
                }
            }
        }
    }

    /// One step of braking so hard [rad/s²].
    fn brake(&mut self, deceleration: f64) {
        self.target.brake(deceleration);
        self.drive();
    }

    fn drive(&mut self) {
        if self.drives.tick(&self.target.position).is_err() {
            // A joint does not follow: the drives have braked by themselves.
            self.protective_stop();
            self.look();
            self.target.rest(self.measured.position);
        }
    }

    /// Its period.
    #[must_use]
    pub const fn period() -> core::time::Duration {
        PERIOD
    }
}
