//! The primary interface: what a client is told there, and which lines it may write beside scripts.
//!
//! In: the controller. Out: messages. When a client calls, the version and the configuration; from then on the state, ten times a second.
//! Layouts are those of UR's guide to its client interfaces and of its client library; all numbers are big-endian.

use mrroc_robots::Six;
use mrroc_ur::primary::{KINEMATICS, kinematics, message, put};
use mrroc_ur::{Calibration, RobotMode, UrModel};

use crate::controller::Controller;
use crate::dashboard::VERSION;

/// Periods from one state to the next: 100 ms.
pub(crate) const EVERY: u64 = 50;

/// The number of a model.
const fn number(model: UrModel) -> i32 {
    match model {
        UrModel::Ur5e => 1,
        UrModel::Ur10e => 2,
        UrModel::Ur3e => 3,
        UrModel::Ur16e => 4,
        UrModel::Ur20 => 7,
        UrModel::Ur30 => 8,
    }
}

impl Controller {
    /// What a client is told when it calls: the version of the software, the configuration with the state, and the kinematics.
    pub(crate) fn greets(&self) -> Vec<u8> {
        let mut bytes = self.version_message();
        bytes.extend(message(&[
            (0, self.mode_data()),
            (3, self.masterboard_data()),
            (KINEMATICS, kinematics(&self.calibration)),
            (6, self.configuration_data()),
        ]));
        bytes
    }

    /// The state.
    pub(crate) fn primary_state(&self) -> Vec<u8> {
        let kinematics = kinematics(&self.calibration);
        message(&[(0, self.mode_data()), (3, self.masterboard_data()), (KINEMATICS, kinematics)])
    }

    /// A line that is no script: what the dashboard does by other words. Whether it is one.
    pub(crate) fn primary_line(&mut self, line: &str) -> bool {
        let command = match line.trim() {
            "" => return true,
            "power on" => "power on",
            "power off" => "power off",
            "set robotmode run" => "brake release",
            "set unlock protective stop" => "unlock protective stop",
            "stop program" => "stop",
            _ => return false,
        };
        self.dashboard(command);
        true
    }

    fn version_message(&self) -> Vec<u8> {
        let [major, minor, fix, build] = VERSION;
        let name = b"URControl";
        let mut content = self.microseconds().to_be_bytes().to_vec();
        // Of the controller itself, the version.
        content.extend([254, 3, name.len() as u8]);
        content.extend(name);
        content.extend([major as u8, minor as u8]);
        content.extend(fix.to_be_bytes());
        content.extend(build.to_be_bytes());
        content.extend(b"01-01-2025, 00:00:00");
        let mut bytes = Vec::new();
        put(&mut bytes, 20, &content);
        bytes
    }

    fn microseconds(&self) -> u64 {
        (self.timestamp() * 1e6) as u64
    }

    fn mode_data(&self) -> Vec<u8> {
        let has_power = !matches!(self.mode, RobotMode::PowerOff);
        let mut content = self.microseconds().to_be_bytes().to_vec();
        content.extend(
            [
                true,
                true,
                has_power,
                self.stops.emergency,
                self.stops.protective.is_some(),
                self.runs() && !self.is_paused,
                self.runs() && self.is_paused,
            ]
            .map(u8::from),
        );
        // Controlled by position.
        content.extend([self.mode as i32 as u8, 0]);
        for value in [self.speed_fraction, self.speed_scaling(), 1.0] {
            content.extend(value.to_be_bytes());
        }
        content.push(0);
        content
    }

    fn masterboard_data(&self) -> Vec<u8> {
        let mut content = (self.terminals.digital_inputs as u32).to_be_bytes().to_vec();
        content.extend((self.terminals.digital_outputs as u32).to_be_bytes());
        let domain = |bit: u32| (self.terminals.voltages >> bit & 1) as u8;
        content.extend([domain(0), domain(1)]);
        content.extend(self.terminals.analog_inputs[..2].iter().flat_map(|value| value.to_be_bytes()));
        content.extend([domain(2), domain(3)]);
        content.extend([0, 1].iter().flat_map(|i| self.analog_output(*i).to_be_bytes()));
        // Temperature, voltage, currents.
        content.extend([30.0_f32, 48.0, 0.5, 0.1].iter().flat_map(|value| value.to_be_bytes()));
        // Not reduced; no interface of an injection moulding machine; what UR uses itself, and its two inputs.
        content.extend([self.safety_mode() as u8, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        content
    }

    fn configuration_data(&self) -> Vec<u8> {
        let (velocities, accelerations): (Six, Six) = (self.model.velocities(), self.model.accelerations());
        let Calibration { theta, a, d, alpha, .. } = self.calibration;
        let turn = core::f64::consts::TAU;
        let mut numbers = Vec::new();
        (0..6).for_each(|_| numbers.extend([-turn, turn]));
        (0..6).for_each(|i| numbers.extend([velocities[i], accelerations[i]]));
        // What motions have that say nothing else, of joints and of the tool, and the equivalent radius.
        numbers.extend([1.05, 1.4, 0.25, 1.2, 1.0]);
        numbers.extend([a, d, alpha, theta].into_iter().flatten());
        let mut content: Vec<u8> = numbers.iter().flat_map(|number: &f64| number.to_be_bytes()).collect();
        for number in [0, 0, number(self.model), 0] {
            content.extend(number.to_be_bytes());
        }
        content
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths of UR's guide, with the head of five bytes: 47 of the mode, 75 of the masterboard, 225 of the kinematics, 445 of the configuration.
    #[test]
    fn parts_have_the_lengths_of_the_guide_and_the_calibration_is_found_among_them() {
        let controller = Controller::new(UrModel::Ur10e, &Six::zeros()).expect("an arm");
        let lengths =
            [controller.mode_data(), controller.masterboard_data(), controller.configuration_data()]
                .map(|content| content.len() + 5);
        assert_eq!(lengths, [47, 75, 445]);
        let state = controller.primary_state();
        assert_eq!(state.len(), 5 + 47 + 75 + 225);
        assert_eq!(mrroc_ur::primary::calibration(&state), Some(Calibration::nominal(UrModel::Ur10e)));
    }

    #[test]
    fn lines_do_what_the_dashboard_does_and_others_are_none() {
        let mut controller = Controller::new(UrModel::Ur5e, &Six::zeros()).expect("an arm");
        assert!(controller.primary_line("power off"));
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: POWER_OFF");
        assert!(controller.primary_line("set robotmode run\r"));
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: RUNNING");
        assert!(!controller.primary_line("movej([0,0,0,0,0,0])"));
    }
}
