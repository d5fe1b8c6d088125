//! The same belt with a camera over it: eight kinds of parts, a queue, a bin for each kind.
//!
//! The task itself is small: [`mp`] coordinates by the [`queue`], [`ecp`] is what each robot does, [`acquire`] how the arm takes a part
//! from the belt, [`carry`] how it brings it to its bin, [`orders`] what the coordinator tells. The rest surrounds it: [`kinds`] and [`arrivals`] say what comes, [`layout`] where
//! things are, [`sight`] what the camera sees of the simulated world; [`studio`] makes images to learn from; [`run`] is one run as [`settings`] say.

pub mod acquire;
pub mod arrivals;
pub mod assignment;
pub mod bound;
pub mod carry;
pub mod charts;
pub mod clear;
pub mod command;
pub mod count;
pub mod ecp;
pub mod gap;
pub mod kinds;
pub mod layout;
pub mod looks;
pub mod misses;
pub mod mp;
pub mod orders;
pub mod picture;
pub mod queue;
pub mod run;
pub mod settings;
pub mod share;
pub mod sight;
pub mod studio;
pub mod summary;
