//! The engraving task: a drawing becomes strokes on a plate, the arm follows them, and pictures show the result.
//!
//! The task itself is small: [`mp`] coordinates, [`ecp`] is the arm's program, [`probe`] the virtual sensor that finds
//! the plate, [`run`] the cell. The rest is what surrounds it: [`drawing`] reads, [`placement`] fits the drawing onto
//! the plate, [`ordering`] shortens travel, [`sampling`] gives the motion its points, [`layout`] says where things stand,
//! [`execution`] and [`deviation`] measure, [`plate`] carves, [`picture`] and [`paths_svg`] show, [`summary`] reports.
//!
//! Lengths are in millimetres, as in the files that are read, but for the motion program, which is in metres.

pub mod chosen;
pub mod deviation;
pub mod drawing;
pub mod ecp;
pub mod error;
pub mod execution;
pub mod feeds;
pub mod layout;
pub mod mp;
pub mod options;
pub mod ordering;
pub mod paths_svg;
pub mod picture;
pub mod placement;
pub mod plate;
pub mod probe;
pub mod progress;
pub mod run;
pub mod sampling;
pub mod summary;
pub mod trace;

/// The SVG of the job without arguments: the nameplate.
pub const NAMEPLATE: &str = include_str!("../assets/drawings/nameplate.svg");
