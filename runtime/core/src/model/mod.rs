//! The formal model: robots and their states, demands, orders, readings, generators and conditions, faults.
//!
//! In: what a programmer writes. Out: types that the layers above check, send and execute. Nothing here knows a process.

pub(crate) mod any_kind;
pub(crate) mod beside;
pub(crate) mod class;
pub(crate) mod demand;
pub(crate) mod drive_fault;
pub(crate) mod driver;
pub(crate) mod each;
pub(crate) mod excess;
pub(crate) mod fault;
pub(crate) mod frames;
pub(crate) mod generator;
pub(crate) mod image;
pub(crate) mod instruction;
pub(crate) mod joints;
pub(crate) mod list;
pub(crate) mod load;
pub(crate) mod lower_cell;
pub(crate) mod moved;
pub(crate) mod name;
pub(crate) mod named;
pub(crate) mod pace;
pub(crate) mod payload;
pub(crate) mod plausible;
pub(crate) mod pose;
pub(crate) mod robot;
pub(crate) mod robot_stop;
pub(crate) mod sensor;
pub(crate) mod shape;
pub(crate) mod signals;
pub(crate) mod step;
pub(crate) mod step_fn;
pub(crate) mod stepped;
pub(crate) mod time;
pub(crate) mod type_name;
pub(crate) mod wire;
pub(crate) mod wrench;
