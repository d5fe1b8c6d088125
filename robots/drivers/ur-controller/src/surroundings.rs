//! What is around a controller: its analog signals, its tool and what pushes at it, and the program of the pendant.
//!
//! In: what a test, or a person at the pendant, sets. Out: what the fields of RTDE and the program node are made of.

use std::net::SocketAddr;

use mrroc::pose::{Pose, Wrench};
use mrroc_ur::RobotMode;

use crate::controller::Controller;

impl Controller {
    /// The analog outputs, as fractions of their ranges.
    #[must_use]
    pub fn analog_outputs(&self) -> [f64; 2] {
        self.terminals.analog_outputs
    }

    /// Sets the standard analog inputs 0 and 1, and those at the tool [V or A].
    pub fn set_analog_inputs(&mut self, values: [f64; 4]) {
        self.terminals.analog_inputs = values;
    }

    /// Chooses, as a person does at the pendant, which of the standard analog inputs (bits 0 and 1) and outputs (2 and 3) are voltages;
    /// the others are currents, as all are at first.
    pub fn choose_voltages(&mut self, bits: u32) {
        self.terminals.voltages = bits & 0b1111;
    }

    /// Pushes at the flange from now on: what the surroundings do to it, about its origin and in the axes of the base, which are
    /// those of the world here. The arm does not yield to it.
    pub fn push(&mut self, wrench: Wrench) {
        self.pushed = wrench;
    }

    /// Sets where the tool centre point is in the flange, as a person does at the pendant. Poses and speeds that are told are those
    /// of this point; the wrench that is told is not.
    pub fn set_tool(&mut self, tool: Pose) {
        self.tool = tool;
    }

    /// Lets the program that is loaded ask here for a script when it is started, as the node of UR's External Control URCap does.
    pub fn set_external_control(&mut self, at: SocketAddr) {
        self.loaded.external = Some(at);
    }

    /// Starts the program that is loaded, or lets one that is paused go on; whether it may.
    pub(crate) fn play(&mut self) -> bool {
        let may = self.mode == RobotMode::Running && !self.stops.any();
        if may && self.runs() {
            self.is_paused = false;
        } else if may {
            self.loaded.is_asking = self.loaded.external.is_some();
            self.loaded.is_plain = !self.loaded.is_asking;
        }
        may
    }

    /// Where a program that has just been started asks for a script: once.
    pub fn asks(&mut self) -> Option<SocketAddr> {
        core::mem::take(&mut self.loaded.is_asking).then_some(self.loaded.external)?
    }

    /// Takes the script that its program has asked for, in remote control or not. Whether it is one that is done here.
    pub fn take_answer(&mut self, text: &str) -> bool {
        self.run(text)
    }
}
