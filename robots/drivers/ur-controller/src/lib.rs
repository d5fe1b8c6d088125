//! A controller of Universal Robots for tests, with a simulated arm behind it.
//!
//! It is no simulation of PolyScope: it tells and takes what a driver needs, and refuses the rest.
//!
//! | part | what it does |
//! |---|---|
//! | [`Controller`] | the controller itself: a state machine that goes on by 2 ms in every [`step`](Controller::step) |
//! | [`Session`] | one client of RTDE: recipes of any outputs and inputs of UR's lists, unknown ones refused, one writer of each input |
//! | [`Inside`] | a `mrroc_ur::Wire` to a controller in the same process, under a virtual clock |
//! | [`VirtualNetwork`] | a `mrroc_ur::Network` with all interfaces of a controller in the same process, under a virtual clock |
//! | [`Server`] | the same controller on sockets, in real time: dashboard, primary and secondary interface, RTDE |
//!
//! **The arm** is [`mrroc_robots::Simulated`]: a motor with its regulator and encoder for each joint, without the masses of the
//! links. A step without power is one with the brakes applied.
//!
//! **Scripts** are not interpreted. The script of `mrroc-ur` is recognised by its first lines ([`mrroc_ur::Script::read`]), and
//! done as it would be: it calls back, follows set-points, goes on without them until its read timeout, brakes and ends. UR's own
//! script for control from outside is recognised, too, and of what it can do the set-points of joint positions are followed. Other
//! scripts are counted and do nothing, and a program that is loaded and played does nothing until it is stopped; with
//! [`set_external_control`](Controller::set_external_control) it asks for its script as the node of UR's URCap does.
//!
//! **Where a controller may do otherwise** (assumed): `servoj` reaches its position at the end of its step unless the joints
//! cannot, and then makes up for it within their limits of velocity and three times those of acceleration; a position that is
//! farther away than a joint comes within the lookahead time is a protective stop; the slider lowers the speed that joints may
//! use; safety stops brake along the path at the smallest acceleration limit of the model, and an emergency stop takes the power
//! away when the arm stands.
//!
//! ```
//! use mrroc_robots::Six;
//! use mrroc_ur::UrModel;
//! use mrroc_ur_controller::Controller;
//!
//! let mut controller = Controller::new(UrModel::Ur5e, &Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0))?;
//! controller.step();
//! assert_eq!(controller.timestamp(), 100.002);
//! assert_eq!(controller.dashboard("robotmode"), "Robotmode: RUNNING");
//! # Ok::<(), mrroc_robots::UrdfError>(())
//! ```

mod controller;
mod dashboard;
mod external;
mod fields;
mod inside;
mod pipe;
mod primary;
mod program;
mod server;
mod service;
mod session;
mod surroundings;
mod target;
mod virtual_network;

pub use controller::{Controller, Press};
pub use inside::Inside;
pub use pipe::Pipe;
pub use server::{Listening, Server};
pub use service::Interface;
pub use session::Session;
pub use virtual_network::{OnCall, VirtualConnection, VirtualNetwork, VirtualPort};
