//! The fields of RTDE: what each output is now, and of which type each input is.
//!
//! Names and types are those of UR's guide to RTDE and of its client library. What this controller has no physics for
//! (temperatures, voltages) is a constant.

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use mrroc_robots::Kinematics;
use mrroc_ur::outputs::FRACTION;
use mrroc_ur::payload;
use mrroc_ur::rtde::{Type, Value};
use nalgebra::Vector3;

use crate::controller::Controller;

/// The number at the end of a register's name, if it is one of so many.
fn register(name: &str, prefix: &str, numbers: core::ops::Range<u8>) -> bool {
    name.strip_prefix(prefix)
        .and_then(|number| number.parse().ok())
        .is_some_and(|number| numbers.contains(&number))
}

/// The type of an input; `None` if there is none of this name.
pub(crate) fn input(name: &str) -> Option<Type> {
    Some(match name {
        "speed_slider_mask" | "input_bit_registers0_to_31" | "input_bit_registers32_to_63" => Type::Uint32,
        "speed_slider_fraction" | "standard_analog_output_0" | "standard_analog_output_1" => Type::Double,
        "standard_digital_output_mask"
        | "standard_digital_output"
        | "configurable_digital_output_mask"
        | "configurable_digital_output"
        | "tool_digital_output_mask"
        | "tool_digital_output"
        | "standard_analog_output_mask"
        | "standard_analog_output_type" => Type::Uint8,
        "external_force_torque" => Type::Vector6d,
        _ if register(name, "input_bit_register_", 64..128) => Type::Bool,
        _ if register(name, "input_int_register_", 0..48) => Type::Int32,
        _ if register(name, "input_double_register_", 0..48) => Type::Double,
        _ => return None,
    })
}

/// A pose as UR writes it: position \[m\] and rotation vector \[rad\].
fn six_of(pose: &Pose) -> Value {
    let (p, turn) = (pose.translation.vector, pose.rotation.scaled_axis());
    Value::Vector6d([p.x, p.y, p.z, turn.x, turn.y, turn.z])
}

/// A value of this type that is nothing.
fn nothing(of: Type) -> Value {
    match of {
        Type::Bool => Value::Bool(false),
        Type::Uint8 => Value::Uint8(0),
        Type::Uint32 => Value::Uint32(0),
        Type::Uint64 => Value::Uint64(0),
        Type::Int32 => Value::Int32(0),
        Type::Double => Value::Double(0.0),
        Type::Vector3d => Value::Vector3d([0.0; 3]),
        Type::Vector6d => Value::Vector6d([0.0; 6]),
        Type::Vector6Int32 => Value::Vector6Int32([0; 6]),
        Type::Vector6Uint32 => Value::Vector6Uint32([0; 6]),
    }
}

impl Controller {
    /// The pose of the tool centre point at joint positions \[rad\], in the base.
    fn tool_pose(&self, q: &mrroc_robots::Six) -> Value {
        six_of(&(self.arm.forward(q) * self.tool))
    }

    /// The velocity of the tool centre point and how fast the tool turns, in the axes of the base.
    fn tool_speed(&self, q: &mrroc_robots::Six, qd: &mrroc_robots::Six) -> Value {
        let [vx, vy, vz, wx, wy, wz] = (self.arm.jacobian(q) * qd).into();
        let arm = self.arm.forward(q).rotation * self.tool.translation.vector;
        let turn = Vector3::new(wx, wy, wz);
        let v = Vector3::new(vx, vy, vz) + turn.cross(&arm);
        Value::Vector6d([v.x, v.y, v.z, wx, wy, wz])
    }

    /// The value of an output now; `None` if there is none of this name.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<Value> {
        let six = |value: mrroc_robots::Six| Value::Vector6d(value.into());
        Some(match name {
            "timestamp" => Value::Double(self.timestamp()),
            "control_step" => Value::Uint64(self.steps),
            "target_q" => six(self.target.position),
            "target_qd" => six(self.target.speed),
            "target_qdd" => six(self.target.acceleration),
            "actual_q" => six(self.measured.position),
            "actual_qd" => six(self.measured.velocity),
            "actual_current" | "target_current" | "joint_control_output" => six(self.currents()),
            "actual_TCP_pose" => self.tool_pose(&self.measured.position),
            "target_TCP_pose" => self.tool_pose(&self.target.position),
            "actual_TCP_speed" => self.tool_speed(&self.measured.position, &self.measured.velocity),
            "target_TCP_speed" => self.tool_speed(&self.target.position, &self.target.speed),
            // About the origin of the flange, whatever the tool centre point is: UR's manual of URScript, `get_tcp_force`.
            "actual_TCP_force" => {
                let (f, t) = (self.pushed.force, self.pushed.torque);
                Value::Vector6d([f.x, f.y, f.z, t.x, t.y, t.z])
            }
            "tcp_force_scalar" => Value::Double(self.pushed.force.norm()),
            "payload" => Value::Double(self.payload().mass),
            "payload_cog" => Value::Vector3d(self.payload().centre.into()),
            "payload_inertia" => Value::Vector6d(payload::elements(&self.payload().inertia)),
            "tcp_offset" => six_of(&self.tool),
            "robot_mode" => Value::Int32(self.mode as i32),
            // Each joint runs, or has no power.
            "joint_mode" => Value::Vector6Int32([if self.mode as i32 == 7 { 253 } else { 239 }; 6]),
            "safety_mode" => Value::Int32(self.safety_mode()),
            "safety_status" => Value::Int32(self.safety_mode()),
            "safety_status_bits" => Value::Uint32(self.safety_bits()),
            "robot_status_bits" => Value::Uint32(self.status_bits()),
            "runtime_state" => Value::Uint32(self.runtime_state()),
            "speed_scaling" => Value::Double(self.speed_scaling()),
            "target_speed_fraction" => Value::Double(self.speed_fraction),
            "actual_digital_input_bits" => Value::Uint64(self.terminals.digital_inputs),
            "actual_digital_output_bits" => Value::Uint64(self.terminals.digital_outputs),
            "analog_io_types" => Value::Uint32(self.terminals.voltages),
            "standard_analog_input0" => Value::Double(self.terminals.analog_inputs[0]),
            "standard_analog_input1" => Value::Double(self.terminals.analog_inputs[1]),
            "tool_analog_input0" => Value::Double(self.terminals.analog_inputs[2]),
            "tool_analog_input1" => Value::Double(self.terminals.analog_inputs[3]),
            "standard_analog_output0" => Value::Double(self.analog_output(0)),
            "standard_analog_output1" => Value::Double(self.analog_output(1)),
            "actual_main_voltage" | "actual_robot_voltage" => Value::Double(48.0),
            "actual_joint_voltage" => Value::Vector6d([48.0; 6]),
            "joint_temperatures" => Value::Vector6d([30.0; 6]),
            "tool_temperature" => Value::Double(30.0),
            "actual_execution_time" | "target_execution_time" => Value::Double(0.0),
            _ => return self.register(name).or_else(|| constant(name).map(nothing)),
        })
    }

    /// What an analog output gives [V or A]: 0 to 10 V, or 4 to 20 mA.
    pub(crate) fn analog_output(&self, i: usize) -> f64 {
        let fraction = self.terminals.analog_outputs[i];
        if self.terminals.voltages >> (2 + i) & 1 != 0 { 10.0 * fraction } else { 0.004 + 0.016 * fraction }
    }

    /// An input as an output: what was written last.
    fn register(&self, name: &str) -> Option<Value> {
        let of = input(name).filter(|_| name.starts_with("input_"))?;
        Some(self.inputs.values.get(name).copied().unwrap_or(nothing(of)))
    }

    /// Carries out what inputs ask for.
    pub(crate) fn write(&mut self, written: &[(String, Value)]) {
        self.inputs.values.extend(written.iter().cloned());
        let value_of = |name: &str| written.iter().find(|(which, _)| which == name).map(|(_, value)| *value);
        let byte = |name: &str| match value_of(name) {
            Some(Value::Uint8(value)) => Some(u64::from(value)),
            _ => None,
        };
        let double = |name: &str| match value_of(name) {
            Some(Value::Double(value)) => Some(value).filter(|value| value.is_finite()),
            _ => None,
        };
        for (what, first) in [("standard", 0), ("configurable", 8), ("tool", 16)] {
            let mask = byte(&format!("{what}_digital_output_mask"));
            if let (Some(mask), Some(bits)) = (mask, byte(&format!("{what}_digital_output"))) {
                let (mask, outputs) = (mask << first, &mut self.terminals.digital_outputs);
                *outputs = *outputs & !mask | bits << first & mask;
            }
        }
        if value_of("speed_slider_mask") == Some(Value::Uint32(1))
            && let Some(fraction) = double("speed_slider_fraction")
        {
            self.set_speed_fraction(fraction);
        }
        if let Some(mask) = byte("standard_analog_output_mask") {
            for (i, place) in ["standard_analog_output_0", "standard_analog_output_1"].iter().enumerate() {
                if mask >> i & 1 == 0 {
                    continue;
                }
                if let Some(value) = double(place).filter(|value| FRACTION.contains(value)) {
                    self.terminals.analog_outputs[i] = value;
                }
                if let Some(voltages) = byte("standard_analog_output_type") {
                    let (bit, is_voltage) = (1 << (2 + i), voltages >> i & 1 != 0);
                    let others = self.terminals.voltages & !bit;
                    self.terminals.voltages = if is_voltage { others | bit } else { others };
                }
            }
        }
    }
}

/// The type of an output that is always nothing here.
fn constant(name: &str) -> Option<Type> {
    Some(match name {
        "target_moment"
        | "actual_current_window"
        | "actual_current_as_torque"
        | "actual_TCP_acceleration"
        | "target_TCP_acceleration"
        | "ft_raw_wrench"
        | "wrench_calc_from_currents"
        | "target_base_acceleration"
        | "target_base_wrench" => Type::Vector6d,
        "actual_tool_accelerometer" | "elbow_position" | "elbow_velocity" | "target_gravity" => {
            Type::Vector3d
        }
        "actual_momentum"
        | "actual_robot_current"
        | "io_current"
        | "euromap67_24V_voltage"
        | "euromap67_24V_current"
        | "tool_output_current"
        | "joint_position_deviation_ratio"
        | "collision_detection_ratio"
        | "actual_robot_energy_consumed"
        | "actual_robot_braking_energy_dissipated" => Type::Double,
        "actual_configurable_digital_input_bits" | "actual_configurable_digital_output_bits" => Type::Uint64,
        "tool_mode"
        | "tool_analog_input_types"
        | "euromap67_input_bits"
        | "euromap67_output_bits"
        | "script_control_line"
        | "output_bit_registers0_to_31"
        | "output_bit_registers32_to_63" => Type::Uint32,
        "encoder0_raw" | "encoder1_raw" | "tool_output_voltage" | "time_scale_source" => Type::Int32,
        "tool_output_mode" | "tool_digital_output0_mode" | "tool_digital_output1_mode" => Type::Uint8,
        _ if register(name, "output_bit_register_", 64..128) => Type::Bool,
        _ if register(name, "output_int_register_", 0..48) => Type::Int32,
        _ if register(name, "output_double_register_", 0..48) => Type::Double,
        _ => return None,
    })
}
