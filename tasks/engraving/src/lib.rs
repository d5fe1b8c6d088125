//! The engraving task: a drawing becomes strokes on a plate, the arm follows them, and pictures show the result.
//!
//! This library is everything around the motion: [`drawing`] reads, [`placement`] fits the drawing onto the plate,
//! [`ordering`] shortens travel, [`sampling`] gives the motion its points, [`deviation`] measures what was executed,
//! [`plate`] carves, [`picture`] and [`paths_svg`] show, [`summary`] reports.
//!
//! Lengths are in millimetres throughout, as in the files that are read; the motion program converts to metres.

pub mod bench;
pub mod deviation;
pub mod drawing;
pub mod ecp;
pub mod error;
pub mod execution;
pub mod mp;
pub mod ordering;
pub mod picture;
pub mod placement;
pub mod plate;
pub mod probe;
pub mod run;
pub mod sampling;
pub mod summary;
pub mod trace;
