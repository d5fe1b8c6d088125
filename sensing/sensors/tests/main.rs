//! Sensors over a scene whose motion is a formula: without a cell, a world or a robot.

mod bars;
mod camera;
mod gate;
mod physics;
mod scene;
mod ultrasound;
