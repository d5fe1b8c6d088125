//! Arms of Universal Robots for mrroc: the controller tells its state 500 times a second by RTDE, and a script that it is sent
//! takes a position in each of these periods.
//!
//! **Never run on a real robot.** It was run against the controller of `mrroc-ur-controller`, which SDU's `ur-rtde` reads and
//! writes as it does a robot (`tests/peers/drives`), and which UR's own client library 2.14 drives as one.
//!
//! | module or type | what it holds |
//! |---|---|
//! | [`rtde`] | the protocol: packages, types, values, for both ends |
//! | [`State`], [`SetPoint`], [`Script`] | what the controller tells, what its script is told, the script |
//! | [`Wire`], [`Sockets`] | how a controller is reached |
//! | [`Network`], [`Connections`] | the same over any network with a clock |
//! | [`Ur`] | the drives |
//! | [`UrModel`] | the arms |
//! | [`payload`] | what the arm carries |
//! | [`Calibration`], [`primary`] | the dimensions of one arm, from a file or its controller |
//!
//! The controller is in *remote control* (PolyScope 5). Then the script is sent to its secondary interface when the cell
//! starts; nothing is installed on it. Or a program node of UR's External Control URCap asks for it, and a person starts its program at the
//! pendant ([`UrSettings::external_control`]). With PolyScope X there is no dashboard, so a protective stop is released at the pendant.
//!
//! What the robot does by itself: a step without a set-point goes on at the speed of the one before, until none has come for
//! [`UrSettings::read_timeout`]. Then the script brakes, says so and ends. Only an operator's reset sends it again, or a person at the pendant starts it.
//!
//! ```no_run
//! use mrroc_ur::with_ur;
//!
//! // kind = "ur5e" in cell.toml, with the controller's `address` and this machine's `listen`.
//! let kinds = with_ur(mrroc_robots::simulated());
//! ```

mod calibration;
mod drives;
mod inertia;
mod kinds;
mod models;
pub mod outputs;
pub mod payload;
pub mod primary;
pub mod rtde;
mod script;
mod set_point;
mod state;
mod stop;
mod wire;

pub use calibration::{Calibration, NoCalibration};
pub use drives::{Ur, UrSettings};
pub use kinds::{with_ur, with_ur_as};
pub use models::{JOINTS, UrModel};
pub use script::{Ended, Script};
pub use set_point::{Ask, SET_POINT_BYTES, SetPoint};
pub use state::{PERIOD, Program, RECIPE, RobotMode, Safety, State, check_offers, recipe_names};
pub use stop::Connected;
pub use wire::{
    Connection, ConnectionLost, Connections, Job, JobState, Listener, Network, Ports, Received, Sockets, Tcp,
    TcpCall, TcpConnection, TcpPort, TimedState, Wire,
};
