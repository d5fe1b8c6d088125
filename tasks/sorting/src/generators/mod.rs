//! How the robots move: three behaviours of the arm on one motion, and the others.
//!
//! | generator | class | what it does |
//! |---|---|---|
//! | [`Wait`] | f\*1(c, v) | goes where parts come and stays there |
//! | [`Follow`] | f\*1(c, v) | goes with the part that the gate has told, ahead of it, down, and lets it come between the fingers |
//! | [`Close`] | f\*1(c, v) | goes with the part, at its middle, while the hand closes |
//! | [`Grasp`] | f\*1(c, v), its first step f\*3(c, e, v) | the hand: closes as long as something is between the fingers |
//! | [`Rise`] | f\*0(c) | takes the tool up, from whatever motion |
//! | [`Uneven`] | f\*0(c) | runs the belt as a worn drive does |

mod chase;
mod close;
mod follow;
mod grasp;
mod rise;
mod uneven;
mod wait;

pub use chase::{Chase, Missed, Open, Part, Pursuit};
pub use close::Close;
pub use follow::Follow;
pub use grasp::Grasp;
pub use rise::Rise;
pub use uneven::Uneven;
pub use wait::Wait;

use mrroc_sensors::virtual_sensors::{Across, Between, Gate};

/// What the arm senses: parts that pass the gate, where they lie across, and what is between the fingers.
pub type Senses = (Gate, Across, Between);
