//! Known layout: a camera looks down at the maze once, and the arm goes the shortest path that the image shows; contact is failure.
//!
//! ```text
//! world -> image -> walls (VSP) -> readings, page by page -> walls, shortest path, motion (MP) -> places, step by step (ECP) -> arm
//! ```
//!
//! [`eye`] says where the camera is, [`scene`] what it sees, [`sensor`] is its virtual sensor, [`mp`], [`ecp`], [`orders`] and [`trace`]
//! are the task, [`run`] is one run, [`summary`] many, [`picture`] draws what was seen, [`shown`] is what a user is shown.

pub mod ecp;
pub mod eye;
pub mod mp;
pub mod orders;
pub mod picture;
pub mod run;
pub mod scene;
pub mod sensor;
pub mod shown;
pub mod summary;
pub mod trace;
