//! The camera as a virtual sensor: an image, and the walls that are in it, a page at a time.
//!
//! The image stays in this process, as the frames of all sensors do. A reading has room for twelve walls; the requester's configuration
//! says from which on.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::Frames;
use mrroc_map::{Place, Wall};
use mrroc_robots::Six;
use mrroc_sensors::aggregation::{Bars, BarsKnown};
use mrroc_sensors::camera::Plane;
use mrroc_sensors::physics::{Dark, Imager};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::eye::{believed, floor, truly};
use super::scene::Overlooked;
use crate::places::{HEIGHT, LOOSE, MIDDLE, Sizes, TURNED, said};
use crate::plant::Plant;

/// Walls in a reading.
pub const PAGE: usize = 12;
/// From the exposure until an image is in readings \[s\].
const PROCESSING: f64 = 0.2;

/// The kind of sensor: a camera over a maze.
#[derive(Clone, Copy, Debug)]
pub struct MazeCamera;

impl Sensor for MazeCamera {
    const KIND: &'static str = "camera over a maze";
    type Reading = Page;
    type Configuration = From;
}

/// Which walls are asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Payload)]
pub struct From {
    /// The first of them, counted from 0.
    pub first: u32,
}

/// Some of the walls of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Page {
    /// How many walls there are in all; 0 as long as no image has been processed.
    pub count: u32,
    /// The number of the first one here.
    pub first: u32,
    /// Where the maze stands: the middle of its lower left post [m, W] ..
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// .. and how it is turned \[rad\].
    pub turn: f64,
    /// Lower left and upper right corners [m, M]; those beyond `count` are 0.
    pub boxes: [[f64; 4]; PAGE],
}

impl Page {
    /// `X_WM`.
    #[must_use]
    pub fn maze(&self) -> Pose {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn);
        Pose::from_parts(Translation3::new(self.x, self.y, MIDDLE[2]), turn)
    }

    /// The walls on it.
    pub fn walls(&self) -> impl Iterator<Item = Wall> {
        let left = (self.count.saturating_sub(self.first) as usize).min(PAGE);
        self.boxes
            .into_iter()
            .take(left)
            .map(|[x0, y0, x1, y1]| Wall { lower: Place::new(x0, y0), upper: Place::new(x1, y1) })
    }
}

/// What is shown of an image, to be drawn and measured.
#[derive(Clone, Debug, Default)]
pub struct Taken {
    /// Grey values.
    pub image: Vec<u8>,
    /// The walls that were found.
    pub bars: Option<Bars>,
    /// How long finding them took.
    pub took: Duration,
}

/// Takes an image when it is asked for the first wall, and finds walls in it.
pub struct OverMaze {
    plant: Plant,
    imager: Imager,
    believed: Plane,
    known: BarsKnown,
    said: Pose,
    taken: Rc<RefCell<Taken>>,
    /// When the image is processed, on the drives' clock \[s\].
    ready: Option<f64>,
    frames: Frames,
}

impl OverMaze {
    /// The camera over the maze of this plant, which has these sides \[m\]. The seed is that of its noise, and of how its calibration is off.
    #[must_use]
    pub fn new(plant: Plant, sizes: &Sizes, sides: [f64; 2], seed: u64) -> Self {
        let plane = truly();
        let known = BarsKnown {
            sides,
            thickness: sizes.thickness,
            height: HEIGHT,
            loose: LOOSE + 0.5 * TURNED * sides[0].max(sides[1]),
            cell: 4e-4,
        };
        Self {
            plant,
            imager: Imager::over(plane.clone(), seed),
            believed: believed(seed),
            known,
            said: floor().inv_mul(&said(sides)),
            taken: Rc::default(),
            ready: None,
            frames: Frames::new(1, plane.width() * plane.height()),
        }
    }

    /// What it takes, to be looked at after a run.
    #[must_use]
    pub fn taken(&self) -> Rc<RefCell<Taken>> {
        Rc::clone(&self.taken)
    }

    /// The same with its lens covered, or the lamp off.
    #[must_use]
    pub const fn darkened(mut self, dark: Dark) -> Self {
        self.imager.darken(f64::NEG_INFINITY, dark);
        self
    }

    /// The same with a camera that has been moved by so much since its calibration \[m, F\].
    #[must_use]
    pub fn moved(mut self, by: Vector3<f64>) -> Self {
        // What is believed stays where it was, so it is off by the opposite.
        self.believed = self.believed.at(Translation3::from(-by) * self.believed.X_FC);
        self
    }

    fn look(&mut self, step: u64, joints: &Six) -> Result<(), Fault> {
        let world = self.plant.world();
        let world = world.borrow();
        let scene = Overlooked::new(&world.walls, &world.X_WM, joints);
        let mut taken = self.taken.borrow_mut();
        self.imager.expose(&scene, 0.0, &mut taken.image);
        let [width, height] = self.believed.camera.size;
        self.frames.image(step, (width as u32, height as u32), 1, &taken.image);
        let began = Instant::now();
        let bars = Bars::find(&self.believed, &taken.image, &self.said, &self.known);
        taken.took = began.elapsed();
        let failed = |text: &str| Fault::new(FaultKind::SensorFailed).text(text);
        taken.bars = Some(bars.map_err(|error| failed(&format!("the camera over the maze: {error}")))?);
        self.ready = Some(world.time + PROCESSING);
        Ok(())
    }
}

impl VirtualSensor for OverMaze {
    type Kind = MazeCamera;

    fn aggregate(&mut self, order: &ReadingOrder<From>) -> Result<Page, Fault> {
        let arm =
            order.robot.ok_or_else(|| Fault::thrown("the camera got no state of the arm: write `of`"))?;
        let first = order.configuration.first;
        if self.ready.is_none() {
            self.look(order.step, &Six::from_fn(|i, _| arm.joints[i]))?;
        }
        let now = self.plant.world().borrow().time;
        let taken = self.taken.borrow();
        let Some(bars) = taken.bars.as_ref().filter(|_| self.ready.is_some_and(|ready| now >= ready)) else {
            return Ok(Page::default());
        };
        let maze = floor() * bars.X_FM;
        let turn = maze.rotation * Vector3::x();
        let mut page = Page {
            count: bars.boxes.len() as u32,
            first,
            x: maze.translation.x,
            y: maze.translation.y,
            turn: turn.y.atan2(turn.x),
            boxes: Default::default(),
        };
        for (to, [lower, upper]) in page.boxes.iter_mut().zip(bars.boxes.iter().skip(first as usize)) {
            *to = [lower.x, lower.y, upper.x, upper.y];
        }
        Ok(page)
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn frames(&mut self) -> Option<&mut Frames> {
        Some(&mut self.frames)
    }
}
