//! Pictures of what moved: a [`Film`] watches the robots of a cell and draws one SVG that any browser shows.
//!
//! In: an [`Observation`](mrroc::observe::Observation) of every servo period of every robot, and what the processes of the
//! cell show a [`StepObserver`](mrroc::observe::step_observer::StepObserver). Out: a picture, in SI units:
//!
//! ```text
//! Observation -> History (bounded memory) -> scene:  stick figures in space, moving; tool paths coloured by speed
//!                                         -> curves: positions, velocities, tool speed, following error over time
//!                                         -> bands: Moves and Waits of the MP and of the robot's own program; suspensions
//!                                         -> bands: digital inputs and outputs by name
//!                                         -> figures: where each joint went, its largest following error
//! what processes show -> Seen (bounded memory) -> instruments: rate of path time, readings of sensors over time
//! ```
//!
//! A [`Plot`] shows other quantities over time in the same look. What either draws is written by [`svg`], which also
//! serves pictures of any other kind.
//!
//! The picture needs no script and no network. Its animation is declared (SMIL); where it is ignored, the first and the
//! last pose, poses between them and the whole path remain.

#![forbid(unsafe_code)]

mod bands;
mod block;
mod body;
mod chart;
mod closeup;
mod curves;
mod figures;
mod film;
mod floor;
mod ghosts;
mod history;
mod instructions;
mod instruments;
mod labels;
mod marks;
mod page;
mod panel;
mod playback;
mod plot;
mod projection;
mod quantities;
mod sample;
mod scene;
mod seen;
mod speed;
mod standing;
mod states;
mod stick;
pub mod svg;
mod tool_path;
mod track;
mod wording;

pub use film::Film;
pub use plot::{Line, Plot};

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_pictures;
#[cfg(test)]
#[path = "../tests/pictures/main.rs"]
mod usage;
