//! What is simulated until there is a real one: the belt, what comes on it, the tray, and the camera.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::rc::Rc;

use mrroc::cell_file::Kinds;
use mrroc::prelude::*;
use mrroc_robots::grasp::{Belt, Sink, World, WorldError};
use mrroc_robots::simulated_in;
use mrroc_sensors::aggregation::{PartClass, Sole, Vision};
use mrroc_sensors::camera::{Camera, Plane};
use mrroc_sensors::physics::Imager;
use mrroc_sensors::simulated::{OverBelt, Workpiece};
use mrroc_sensors::virtual_sensors::{CameraSensor, Trigger};
use nalgebra::Vector3;

/// FILL IN: the edges of a part [m]. The hand grasps it across the second one, 50 mm.
pub const PART: [f64; 3] = [0.07, 0.05, 0.04];
/// The middle of the tray, on its bottom [m, world].
pub const TRAY: [f64; 3] = [0.53, 0.5, -0.08];
/// How old the belt's state is that goes with a camera's order [s].
const LATCH: f64 = 2.2e-3;

/// What is simulated, once there is a cell.
pub type Shown = Rc<RefCell<Option<OverBelt>>>;

/// Where the part is, for the picture.
pub fn place(shown: &Shown) -> Pose {
    let line = shown.borrow();
    let body = line.as_ref().and_then(|line| line.world().body_of(0));
    body.map_or_else(|| Pose::translation(TRAY[0], TRAY[1], TRAY[2]), |body| body.pose)
}

/// The world: a tray, and a part that comes onto the belt after a second.
fn world(frame: Pose) -> Result<OverBelt, WorldError> {
    let [x, y, z] = TRAY;
    let tray = Sink { lower: [x - 0.08, y - 0.1, z], upper: [x + 0.08, y + 0.1, z + 0.12] };
    let floor = Sink { lower: [-2.0, -2.0, -1.0], upper: [2.0, 2.0, -0.1] };
    let line = OverBelt::of(World::empty().with_rest().with_sink(tray)?.with_sink(floor)?, frame);
    // FILL IN: where parts come, 0.68 m before the belt's frame here, 10 mm aside and turned by 0.3 rad.
    let askew = Pose::translation(-0.68, 0.01, 0.0) * Pose::rotation(Vector3::z() * 0.3);
    line.put(Workpiece::block(PART, 0.2), askew, 1.0)?;
    Ok(line)
}

/// The same, for a cell; its belt has this frame F in the world.
pub fn line(frame: Pose) -> Result<OverBelt, CellError> {
    world(frame).map_err(|error| Fault::thrown(&error.to_string()).into())
}

/// The kinds of robots, with drives in that world.
/// FILL IN: `mrroc_robots::simulated()` with a kind of your own, to drive real ones.
pub fn kinds(world: &World) -> Kinds {
    simulated_in(world, Belt::new(-0.75, 1.15, 0.24)) // from, to, width [m]
}

/// The camera, which looks down on the belt, and an image of which is taken every 5 cm of belt.
pub fn camera(line: OverBelt) -> CameraSensor<OverBelt> {
    // FILL IN: where your camera is in the belt's frame; here 0.42 m before its origin and 0.85 m above.
    let down = Pose::translation(-0.42, 0.0, 0.85) * Pose::rotation(Vector3::x() * PI);
    let plane = Plane::new(Camera::MRROCPP, down);
    // FILL IN: your parts. With more than one class `Sole` is replaced by a network: see README.md.
    let block = PartClass { name: "block", form: Workpiece::block(PART, 0.2).form, turns: 2 };
    let vision = Vision::new(plane.clone(), vec![block], Box::new(Sole));
    CameraSensor::new(line, Imager::over(plane, 1), vision, Trigger::Travel(0.05), LATCH)
}
