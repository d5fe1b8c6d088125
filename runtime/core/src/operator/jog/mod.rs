//! Jogging: a person at a console moves one robot of a running cell, by its joints or by its tool, and switches
//! its outputs while it stands.
//!
//! In: orders of a console, each with the renewal of a hold. Out: for the program that moves that robot, what is asked for now.
//! A jog moves only while its hold lasts, at reduced speed, and only as long as no other robot moves by a program of its own.
//! [`order`] is what a console asks for, [`panel`] what a program is given.

pub mod order;
pub mod panel;

pub use order::{JogAxis, JogFrame, JogJoints, JogMotion, JogOrder};
pub use panel::{JogNow, JogPanel, JogSeat, JogStop};

use core::fmt;

/// Why a jog was refused, or moves nothing any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogRefusal {
    /// The cell has no such robot, or it is itself a cell.
    NoRobot,
    /// The cell names no such frame.
    NoFrame,
    /// The robot has no such joint, or other joints than the pose.
    NoJoint,
    /// No program lets the robot be jogged now.
    NoProgram,
    /// Another robot moves by its program, and would move on as long as this jog is held.
    OthersMove,
    /// The hold began with another robot.
    AnotherRobot,
    /// The robot has no such output of that type.
    NoOutput,
    /// The output drives a tool, and is asked to be other than at a stop.
    DrivesTool,
}

impl JogRefusal {
    /// All of them; one travels as its place in this list.
    pub const ALL: [JogRefusal; 8] = [
        JogRefusal::NoRobot,
        JogRefusal::NoFrame,
        JogRefusal::NoJoint,
        JogRefusal::NoProgram,
        JogRefusal::OthersMove,
        JogRefusal::AnotherRobot,
        JogRefusal::NoOutput,
        JogRefusal::DrivesTool,
    ];

    /// In words.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            JogRefusal::NoRobot => "the cell has no such robot",
            JogRefusal::NoFrame => "the cell names no such frame",
            JogRefusal::NoJoint => "the robot has not these joints",
            JogRefusal::NoProgram => {
                "no program lets this robot be jogged now: one does while it moves it by a jog panel"
            }
            JogRefusal::OthersMove => "another robot moves by its own program, and would move while you jog",
            JogRefusal::NoOutput => "the robot has no output of this name that takes this value",
            JogRefusal::DrivesTool => {
                "this output drives a tool: a person may only switch it to what it is at a stop"
            }
            JogRefusal::AnotherRobot => "this hold began with another robot: let go, and hold again",
        }
    }
}

impl fmt::Display for JogRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.reason())
    }
}
