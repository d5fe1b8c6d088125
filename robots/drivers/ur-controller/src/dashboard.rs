//! The dashboard: a line of text in, a line out.

use mrroc_ur::RobotMode;

use crate::controller::Controller;

/// What it does in remote control alone.
const MOVING: [&str; 7] =
    ["power on", "power off", "brake release", "unlock protective stop", "play", "pause", "stop"];

/// What it says to who calls.
pub(crate) const GREETING: &str = "Connected: Universal Robots Dashboard Server";

/// The version of the software that it says it has.
pub(crate) const VERSION: [u32; 4] = [5, 19, 0, 1_210_631];

impl Controller {
    /// By how much programs are slowed down now.
    pub(crate) fn speed_scaling(&self) -> f64 {
        if self.runs() { self.speed_fraction } else { 0.0 }
    }

    /// Answers a command of the dashboard.
    pub fn dashboard(&mut self, command: &str) -> String {
        let command = command.trim();
        let local = || "Command is not allowed due to safety reasons: not in remote control".to_owned();
        match command {
            "robotmode" => format!("Robotmode: {}", self.mode.name()),
            "safetymode" => format!("Safetymode: {}", self.safety_name()),
            "safetystatus" => format!("Safetystatus: {}", self.safety_name()),
            "is in remote control" => self.is_remote.to_string(),
            "running" => format!("Program running: {}", self.runs() && !self.is_paused),
            "programState" => format!("{} {}", self.program_name(), self.loaded.name.as_deref().unwrap_or("mrroc")),
            "get loaded program" => match &self.loaded.name {
                Some(name) => format!("Loaded program: /programs/{name}"),
                None => "No program loaded".to_owned(),
            },
            "saveLog" => "Log saved to disk".to_owned(),
            "PolyscopeVersion" => {
                let [major, minor, fix, build] = VERSION;
                format!("URSoftware {major}.{minor}.{fix}.{build} (Jan 01 2025)")
            }
            "version" => "5.19.0.1210631".to_owned(),
            "get robot model" => self.model.kind().trim_end_matches('e').to_uppercase(),
            "get serial number" => "20200000000".to_owned(),
            "close popup" => "closing popup".to_owned(),
            "close safety popup" => "closing safety popup".to_owned(),
            "quit" => "Disconnected".to_owned(),
            _ if command.starts_with("popup ") => "showing popup".to_owned(),
            _ if command.starts_with("addToLog ") => "Added log message".to_owned(),
            _ if !self.is_remote && (MOVING.contains(&command) || command.starts_with("load ")) => {
                local()
            }
            "power on" => {
                self.power_on();
                "Powering on".to_owned()
            }
            "power off" => {
                self.power_off();
                "Powering off".to_owned()
            }
            "brake release" => {
                self.power_on();
                self.release_brakes();
                "Brake releasing".to_owned()
            }
            "unlock protective stop" if self.unlock() => "Protective stop releasing".to_owned(),
            "unlock protective stop" => "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking".to_owned(),
            "stop" => {
                self.press(crate::Press::StopProgram);
                "Stopped".to_owned()
            }
            "play" if (self.loaded.name.is_some() || self.runs()) && self.play() => "Starting program".to_owned(),
            "play" => "Failed to execute: play".to_owned(),
            "pause" if self.runs() => {
                self.press(crate::Press::PauseProgram);
                "Pausing program".to_owned()
            }
            "pause" => "Failed to execute: pause".to_owned(),
            _ if command.starts_with("load ") && command.ends_with(".urp") => {
                let name = command.trim_start_matches("load ").trim();
                self.press(crate::Press::StopProgram);
                self.loaded.name = Some(name.to_owned());
                format!("Loading program: {name}")
            }
            _ => format!("could not understand: '{command}'"),
        }
    }

    fn program_name(&self) -> &'static str {
        match self.runs() {
            true if self.is_paused => "PAUSED",
            true => "PLAYING",
            false => "STOPPED",
        }
    }

    fn safety_name(&self) -> &'static str {
        match self.safety_mode() {
            3 => "PROTECTIVE_STOP",
            5 => "SAFEGUARD_STOP",
            7 => "ROBOT_EMERGENCY_STOP",
            8 => "VIOLATION",
            _ => "NORMAL",
        }
    }

    /// `safety_mode` of RTDE: the gravest of what stops the arm.
    pub(crate) fn safety_mode(&self) -> i32 {
        let stops = &self.stops;
        match () {
            () if stops.violation => 8,
            () if stops.emergency => 7,
            () if stops.door_open => 5,
            () if stops.protective.is_some() => 3,
            () => 1,
        }
    }

    /// `safety_status_bits` of RTDE.
    pub(crate) fn safety_bits(&self) -> u32 {
        let stops = &self.stops;
        let normal = self.safety_mode() == 1;
        let bit = |is_set: bool, bit: u32| u32::from(is_set) << bit;
        bit(normal, 0)
            | bit(stops.protective.is_some(), 2)
            | bit(stops.door_open, 4)
            | bit(stops.emergency, 6)
            | bit(stops.emergency, 7)
            | bit(stops.violation, 8)
            | bit(!normal, 10)
    }

    /// `robot_status_bits` of RTDE: power, a program runs, the freedrive button.
    pub(crate) fn status_bits(&self) -> u32 {
        let has_power = matches!(self.mode, RobotMode::Idle | RobotMode::Running | RobotMode::Backdrive);
        u32::from(has_power)
            | u32::from(self.runs() && !self.is_paused) << 1
            | u32::from(self.stops.guided) << 2
    }

    /// `runtime_state` of RTDE.
    pub(crate) fn runtime_state(&self) -> u32 {
        match self.runs() {
            true if self.is_paused || self.stops.any() => 4,
            true => 2,
            false => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Press;
    use mrroc_robots::Six;
    use mrroc_ur::UrModel;

    #[test]
    fn power_comes_back_only_when_the_emergency_stop_is_released_and_the_brakes_are_asked_to() {
        let start = Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0);
        let mut controller = Controller::new(UrModel::Ur5e, &start).expect("an arm");
        controller.press(Press::EmergencyStop);
        controller.step();
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: POWER_OFF");
        assert_eq!(controller.dashboard("safetystatus"), "Safetystatus: ROBOT_EMERGENCY_STOP");
        controller.dashboard("power on");
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: POWER_OFF");
        controller.press(Press::ReleaseEmergencyStop);
        controller.dashboard("power on");
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: IDLE");
        assert_eq!(controller.dashboard("brake release"), "Brake releasing");
        assert_eq!(controller.dashboard("robotmode"), "Robotmode: RUNNING");
        assert!(controller.dashboard("load x").starts_with("could not understand"));
    }

    #[test]
    fn a_program_is_loaded_played_paused_and_stopped() {
        let mut controller = Controller::new(UrModel::Ur5e, &Six::zeros()).expect("an arm");
        assert_eq!(controller.dashboard("play"), "Failed to execute: play");
        for (command, answer, state) in [
            ("load wait.urp", "Loading program: wait.urp", "STOPPED wait.urp"),
            ("play", "Starting program", "PLAYING wait.urp"),
            ("pause", "Pausing program", "PAUSED wait.urp"),
            ("play", "Starting program", "PLAYING wait.urp"),
            ("stop", "Stopped", "STOPPED wait.urp"),
        ] {
            assert_eq!(controller.dashboard(command), answer);
            controller.step();
            assert_eq!(controller.dashboard("programState"), state);
        }
        controller.press(Press::TakeOver);
        assert!(controller.dashboard("load x.urp").contains("not allowed"));
    }

    #[test]
    fn a_protective_stop_is_released_after_five_seconds_in_remote_control_alone() {
        let mut controller = Controller::new(UrModel::Ur5e, &Six::zeros()).expect("an arm");
        controller.press(Press::Collide);
        (0..2499).for_each(|_| controller.step());
        assert!(controller.dashboard("unlock protective stop").starts_with("Cannot"));
        controller.step();
        controller.press(Press::TakeOver);
        assert!(controller.dashboard("unlock protective stop").contains("not allowed"));
        controller.press(Press::GiveBack);
        assert_eq!(controller.dashboard("unlock protective stop"), "Protective stop releasing");
        assert_eq!(controller.dashboard("safetymode"), "Safetymode: NORMAL");
    }
}
