//! The processes of a cell: MP, ECP, EDP, VSP and the plant, and the instructions Move and Wait.
//!
//! In: programs, generators, drives and sensors. Out: demands within the limits, step by step. Processes reach each other by
//! a [`link`](crate::link) alone.

pub(crate) mod command;
pub(crate) mod connecting;
pub(crate) mod drive;
pub(crate) mod ecp;
pub(crate) mod edp;
pub(crate) mod guard;
pub(crate) mod guarded;
pub(crate) mod homing;
pub(crate) mod ideal;
pub(crate) mod interpolation;
pub(crate) mod mp;
pub(crate) mod opening;
pub(crate) mod overruns;
pub(crate) mod plant;
pub(crate) mod plant_sensor;
pub(crate) mod recorded;
pub(crate) mod replay;
pub(crate) mod sensing;
pub(crate) mod simulated_signals;
pub(crate) mod state_words;
pub(crate) mod task_space;
pub(crate) mod transparent;
pub(crate) mod vsp;
