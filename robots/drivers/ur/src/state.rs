//! What the driver is told by a controller in every period.

use core::time::Duration;

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::Load;
use nalgebra::Vector3;

use crate::inertia;
use crate::models::JOINTS;
use crate::rtde::{Offer, Type, Values};

/// The controller's period.
pub const PERIOD: Duration = Duration::from_millis(2);

/// The fields, in the order in which they come, with the types that the controller must have for them.
pub const RECIPE: [(&str, Type); 25] = [
    ("timestamp", Type::Double),
    ("target_q", Type::Vector6d),
    ("actual_q", Type::Vector6d),
    ("actual_qd", Type::Vector6d),
    ("actual_current", Type::Vector6d),
    ("actual_TCP_force", Type::Vector6d),
    ("robot_mode", Type::Int32),
    ("safety_mode", Type::Int32),
    ("safety_status_bits", Type::Uint32),
    ("robot_status_bits", Type::Uint32),
    ("runtime_state", Type::Uint32),
    ("speed_scaling", Type::Double),
    ("target_speed_fraction", Type::Double),
    ("actual_digital_input_bits", Type::Uint64),
    ("actual_digital_output_bits", Type::Uint64),
    ("analog_io_types", Type::Uint32),
    ("standard_analog_input0", Type::Double),
    ("standard_analog_input1", Type::Double),
    ("tool_analog_input0", Type::Double),
    ("tool_analog_input1", Type::Double),
    ("standard_analog_output0", Type::Double),
    ("standard_analog_output1", Type::Double),
    ("payload", Type::Double),
    ("payload_cog", Type::Vector3d),
    ("payload_inertia", Type::Vector6d),
];

/// The names of [`RECIPE`], separated by commas.
#[must_use]
pub fn recipe_names() -> String {
    RECIPE.map(|(name, _)| name).join(",")
}

/// Whether a controller has all fields of [`RECIPE`], with their types; otherwise the name of the first one that it has not.
///
/// # Errors
/// That name.
pub fn check_offers(offers: &[Offer]) -> Result<(), &'static str> {
    for (i, (name, of)) in RECIPE.iter().enumerate() {
        if offers.get(i) != Some(&Offer::Has(*of)) {
            return Err(name);
        }
    }
    Ok(())
}

/// What a controller tells at the beginning of a period. Every number is finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Its clock, since it was switched on \[s\], >= 0.
    pub timestamp: f64,
    /// Where it drives the joints to in this period \[rad\].
    pub target_q: [f64; JOINTS],
    /// Where the joints are \[rad\].
    pub actual_q: [f64; JOINTS],
    /// How fast they are [rad/s].
    pub actual_qd: [f64; JOINTS],
    /// Currents of the motors \[A\].
    pub actual_current: [f64; JOINTS],
    /// Force and torque of the surroundings on the flange [N, N m], as it measures them: about the origin of the flange, in the
    /// axes of its base. It has subtracted the weight of its payload.
    pub tool_force: [f64; JOINTS],
    /// What it does.
    pub robot_mode: RobotMode,
    /// What its safety system says.
    pub safety: Safety,
    /// Whether a program runs on it.
    pub program: Program,
    /// Whether the button on the back of the pendant is pressed, by which a person guides the arm.
    pub is_guided: bool,
    /// By how much it slows down programs now: 1 as they are, 0 to a standstill.
    pub speed_scaling: f64,
    /// The same as chosen at the pendant, by the slider.
    pub speed_fraction: f64,
    /// Its digital inputs: bits 0 to 7 standard, 8 to 15 configurable, 16 and 17 at the tool.
    pub digital_inputs: u64,
    /// Its digital outputs, in the same order.
    pub digital_outputs: u64,
    /// By bits, which of its standard analog inputs (0 and 1) and outputs (2 and 3) are voltages; the others are currents.
    pub voltages: u32,
    /// Its standard analog inputs 0 and 1, then those at the tool [V or A, as is chosen at the pendant].
    pub analog_inputs: [f64; 4],
    /// Its analog outputs [V or A].
    pub analog_outputs: [f64; 2],
    /// What it reckons with on its flange: its payload.
    pub payload: Load,
}

/// What a controller does, its `robot_mode`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "UR's names")]
#[repr(i32)]
pub enum RobotMode {
    NoController = -1,
    Disconnected = 0,
    ConfirmSafety = 1,
    Booting = 2,
    PowerOff = 3,
    PowerOn = 4,
    Idle = 5,
    Backdrive = 6,
    Running = 7,
    UpdatingFirmware = 8,
}

impl RobotMode {
    /// All of them.
    pub const ALL: [RobotMode; 10] = [
        RobotMode::NoController,
        RobotMode::Disconnected,
        RobotMode::ConfirmSafety,
        RobotMode::Booting,
        RobotMode::PowerOff,
        RobotMode::PowerOn,
        RobotMode::Idle,
        RobotMode::Backdrive,
        RobotMode::Running,
        RobotMode::UpdatingFirmware,
    ];

    /// As the dashboard writes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            RobotMode::NoController => "NO_CONTROLLER",
            RobotMode::Disconnected => "DISCONNECTED",
            RobotMode::ConfirmSafety => "CONFIRM_SAFETY",
            RobotMode::Booting => "BOOTING",
            RobotMode::PowerOff => "POWER_OFF",
            RobotMode::PowerOn => "POWER_ON",
            RobotMode::Idle => "IDLE",
            RobotMode::Backdrive => "BACKDRIVE",
            RobotMode::Running => "RUNNING",
            RobotMode::UpdatingFirmware => "UPDATING_FIRMWARE",
        }
    }
}

/// What a controller's safety system says: of several things the gravest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Safety {
    /// Nothing limits the robot beyond its limits.
    Normal,
    /// It works within reduced limits.
    Reduced,
    /// Its controller has stopped it.
    ProtectiveStop,
    /// It was beyond a limit, and may be moved back by hand alone.
    Recovery,
    /// A guard has stopped it, of the cell or of a machine beside it.
    SafeguardStop,
    /// An enabling device was let go.
    EnablingStop,
    /// An emergency stop, of the robot or of the cell.
    EmergencyStop,
    /// It was beyond a limit of its safety configuration.
    Violation,
    /// The safety system has failed, or says what this driver does not know.
    Fault,
}

impl Safety {
    /// Of `safety_status_bits`, and of `safety_mode` where that says more.
    fn read(bits: u32, mode: i32) -> Safety {
        let is_set = |bit: u32| bits >> bit & 1 != 0;
        match mode {
            _ if is_set(9) => Safety::Fault,
            _ if is_set(8) => Safety::Violation,
            _ if is_set(5) || is_set(6) || is_set(7) => Safety::EmergencyStop,
            6 | 7 | 15 | 20 => Safety::EmergencyStop,
            8 => Safety::Violation,
            13 | 14 => Safety::EnablingStop,
            5 | 12 | 16 | 18 | 19 | 22 => Safety::SafeguardStop,
            _ if is_set(4) => Safety::SafeguardStop,
            4 => Safety::Recovery,
            _ if is_set(3) => Safety::Recovery,
            3 => Safety::ProtectiveStop,
            _ if is_set(2) => Safety::ProtectiveStop,
            2 => Safety::Reduced,
            // Stopped for safety, without a reason that is known here.
            1 if is_set(10) => Safety::Fault,
            1 if is_set(1) => Safety::Reduced,
            1 => Safety::Normal,
            _ => Safety::Fault,
        }
    }
}

/// Whether a program runs, its `runtime_state`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// It runs.
    Playing,
    /// It is paused, or comes to be.
    Paused,
    /// None runs.
    Stopped,
}

impl State {
    /// The wrench of the surroundings on the flange, at its origin and in its axes, where its pose in the base of the arm is
    /// `X_BF`: what the controller tells is about the same point, so it is only turned.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn flange_wrench(&self, X_BF: &Pose) -> Wrench {
        let [fx, fy, fz, tx, ty, tz] = self.tool_force;
        let turned = |vector: Vector3<f64>| X_BF.rotation.inverse() * vector;
        Wrench::new(turned(Vector3::new(fx, fy, fz)), turned(Vector3::new(tx, ty, tz)))
    }

    /// Reads the values of [`RECIPE`]; `None` if they have another length, or a number is none.
    #[must_use]
    pub fn read(values: &[u8]) -> Option<State> {
        let mut values = Values(values);
        let timestamp = values.f64().filter(|time| (0.0..1e9).contains(time))?;
        let mut vector = || values.doubles().filter(|all| all.iter().all(|one: &f64| one.is_finite()));
        let [target_q, actual_q, actual_qd] = [vector()?, vector()?, vector()?];
        let [actual_current, tool_force] = [vector()?, vector()?];
        let mode = values.i32()?;
        let robot_mode = RobotMode::ALL.into_iter().find(|one| *one as i32 == mode)?;
        let safety_mode = values.i32()?;
        let safety = Safety::read(values.u32()?, safety_mode);
        let status = values.u32()?;
        let program = match values.u32()? {
            2 | 5 => Program::Playing,
            3 | 4 => Program::Paused,
            _ => Program::Stopped,
        };
        let mut fraction = || values.f64().filter(|fraction| fraction.is_finite());
        let [speed_scaling, speed_fraction] = [fraction()?, fraction()?];
        let [digital_inputs, digital_outputs] = [values.u64()?, values.u64()?];
        let voltages = values.u32()?;
        let mut analog = || values.f64().filter(|value| value.is_finite());
        let analog_inputs = [analog()?, analog()?, analog()?, analog()?];
        let analog_outputs = [analog()?, analog()?];
        let mass = analog()?;
        let all_finite = |all: &[f64]| all.iter().all(|one| one.is_finite());
        let centre: [f64; 3] = values.doubles().filter(|all| all_finite(all))?;
        let inertia: [f64; 6] = values.doubles().filter(|all| all_finite(all))?;
        let payload = Load { mass, centre: centre.into(), inertia: inertia::inertia(inertia) };
        let is_guided = status >> 2 & 1 != 0;
        values.is_over().then_some(State {
            timestamp,
            target_q,
            actual_q,
            actual_qd,
            actual_current,
            tool_force,
            robot_mode,
            safety,
            program,
            is_guided,
            speed_scaling,
            speed_fraction,
            digital_inputs,
            digital_outputs,
            voltages,
            analog_inputs,
            analog_outputs,
            payload,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rtde::Value;

    /// The values of a robot that runs, with some of them replaced.
    fn values(replaced: &[(&str, Value)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (name, of) in RECIPE {
            let usual = match (name, of) {
                ("robot_mode", _) => Value::Int32(7),
                ("safety_mode", _) => Value::Int32(1),
                ("safety_status_bits", _) => Value::Uint32(1),
                (_, Type::Int32) => Value::Int32(0),
                (_, Type::Uint32) => Value::Uint32(2),
                (_, Type::Uint64) => Value::Uint64(5),
                (_, Type::Vector3d) => Value::Vector3d([0.7, 0.8, 0.9]),
                (_, Type::Vector6d) => Value::Vector6d([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
                _ => Value::Double(1.0),
            };
            let value = replaced.iter().find(|(which, _)| *which == name).map_or(usual, |(_, value)| *value);
            value.write(&mut bytes);
        }
        bytes
    }

    #[test]
    fn a_state_is_read_whole_or_not_at_all() {
        let state = State::read(&values(&[])).expect("a state");
        assert_eq!((state.timestamp, state.actual_q[5], state.robot_mode), (1.0, 0.6, RobotMode::Running));
        assert_eq!(
            (state.safety, state.program, state.digital_inputs),
            (Safety::Normal, Program::Playing, 5)
        );
        // UR's order is xx, yy, zz, xy, xz, yz.
        let inertia = nalgebra::Matrix3::new(0.1, 0.4, 0.5, 0.4, 0.2, 0.6, 0.5, 0.6, 0.3);
        assert_eq!(state.payload, Load { mass: 1.0, centre: [0.7, 0.8, 0.9].into(), inertia });
        let bytes = values(&[]);
        assert_eq!(State::read(&bytes[1..]), None);
        assert_eq!(State::read(&[&bytes[..], &[0]].concat()), None);
        for (name, value) in [
            ("timestamp", Value::Double(f64::NAN)),
            ("timestamp", Value::Double(-1.0)),
            ("actual_q", Value::Vector6d([0.0, 0.0, f64::INFINITY, 0.0, 0.0, 0.0])),
            ("robot_mode", Value::Int32(99)),
            ("speed_scaling", Value::Double(f64::NAN)),
            ("payload_cog", Value::Vector3d([0.0, f64::NAN, 0.0])),
            ("payload_inertia", Value::Vector6d([0.0, 0.0, 0.0, 0.0, 0.0, f64::INFINITY])),
        ] {
            assert_eq!(State::read(&values(&[(name, value)])), None, "{name}");
        }
    }

    #[test]
    fn of_several_stops_the_gravest_is_told() {
        let read = |bits, mode| Safety::read(bits, mode);
        assert_eq!(read(1, 1), Safety::Normal);
        assert_eq!(read(0b10, 2), Safety::Reduced);
        assert_eq!(read(0b100, 3), Safety::ProtectiveStop);
        assert_eq!(read(0b1_0100, 3), Safety::SafeguardStop, "a protective stop behind an open door");
        assert_eq!(read(1 << 6 | 1 << 7, 7), Safety::EmergencyStop);
        assert_eq!(read(1 << 8 | 1 << 7, 8), Safety::Violation);
        assert_eq!(read(1 << 9, 9), Safety::Fault);
        assert_eq!(read(0, 12), Safety::SafeguardStop);
        assert_eq!(read(0, 13), Safety::EnablingStop);
        assert_eq!(read(0, 77), Safety::Fault, "unknown");
        assert_eq!(read(1 << 10, 1), Safety::Fault, "stopped for a reason that is not told");
    }
}
