//! The coordinator's program: the walls from one image, the shortest path between them, and along it.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_map::{Inflated, Taut, Walls};
use mrroc_robots::Irp6;
use nalgebra::Point3;

use super::orders::Errand;
use super::sensor::{From, MazeCamera};
use super::trace::Trace;
use crate::mp::MazeSettings;

/// How far the planned path keeps from walls that were seen, beyond the ball's radius \[m\].
pub const CLEARANCE: f64 = 3e-4;
/// Polygons inflated by so much more hold the arcs about corners: a corner is inflated by chords of 45 degrees.
const AROUND: f64 = 1.0824;

/// What the coordinator planned, to be drawn and measured.
#[derive(Clone, Debug, Default)]
pub struct Planned {
    /// The path.
    pub path: Option<Taut>,
    /// How long planning took.
    pub took: Duration,
}

/// The camera's walls from this one on are there.
struct Seen(From);

#[condition(mp)]
fn seen(c: &mut Seen, v: &Reading<(MazeCamera,)>) -> bool {
    v.0.reading().is_some_and(|page| page.count > 0 && page.first == c.0.first)
}

/// The shortest path between these walls that keeps clear of them.
fn shortest(walls: &Walls, told: &MazeSettings) -> Option<Taut> {
    let radius = told.sizes.radius + CLEARANCE;
    let (_, path) = Inflated::by(walls, AROUND * radius).shortest(&told.start, &told.goal)?;
    Taut::along(walls, radius, &path)
}

/// Looks at the maze, plans the shortest path to the exit, and has the arm go it.
///
/// # Errors
/// The first fault of the cell; no path is seen; a wall is touched.
pub fn coordinate(mp: &mut Mp, told: &MazeSettings, planned: &Rc<RefCell<Planned>>) -> Result<(), Fault> {
    let (mut arm, mut camera) = (mp.robot::<Irp6>("arm")?, mp.sensor::<MazeCamera>("camera")?);
    let mut boxes = Vec::new();
    let maze = loop {
        let from = From { first: boxes.len() as u32 };
        camera.configure(from);
        mp.wait_until((&mut arm,), (&mut camera,), Seen(from))?;
        let page = camera.reading().ok_or_else(|| Fault::thrown("the camera has no reading"))?;
        boxes.extend(page.walls());
        if boxes.len() >= page.count as usize {
            break page.maze();
        }
    };
    let began = Instant::now();
    let walls = Walls::of_boxes(boxes, told.sizes.pitch, told.known.size);
    let path = shortest(&walls, told).ok_or_else(|| {
        Fault::thrown("the camera sees no path to the exit: look at the maze, or tell another exit")
    })?;
    let trace = Trace::along(&path, &maze).map_err(|error| Fault::thrown(&error.to_string()))?;
    *planned.borrow_mut() = Planned { path: Some(path), took: began.elapsed() };
    let start = maze.transform_point(&Point3::new(told.start.x, told.start.y, 0.0));
    let hop = Errand::Hop { x: start.x, y: start.y };
    mp.move_robots((&mut arm,), (), ConstantOrder::<(Irp6,), Errand>::to_all(hop))?;
    mp.move_robots((&mut arm,), (), trace).map(drop)
}
