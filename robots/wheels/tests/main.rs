//! Tests of the base: its drives, and how well it follows a course.

mod drives;
mod following;
