//! The matrix in the cell; and a run with whichever sensor is over the belt.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::{CellFile, CellFileError};
use mrroc::prelude::*;
use mrroc_robots::grasp::World;
use mrroc_sensors::aggregation::{
    HeardObject, Hearing, Network, NetworkError, RELIEF_FEATURES, Relief, Reliefs,
};
use mrroc_sensors::physics::Sounders;
use mrroc_sensors::ultrasound::{Air, Echo};
use mrroc_sensors::view::View as _;
use mrroc_sensors::virtual_sensors::{Encoder, Listener, MatrixSensor};

use super::layout::{LIMITS, array};
use crate::camera::acquire::Acquire;
use crate::camera::arrivals::Coming;
use crate::camera::kinds::{KINDS, classes, kinds};
use crate::camera::layout::BEAM;
use crate::camera::looks::{Looks, Trace, nearest};
use crate::camera::run::{Outcome, Ready, with_arms, wrong};
use crate::camera::settings::{Overhead, Settings};
use crate::camera::sight::Sight;
use crate::plant::Plant;

/// The cell of the task with the matrix, `cell-matrix.toml`, and with so many arms.
///
/// # Errors
/// None: the files are right.
pub fn file(arms: usize) -> Result<CellFile, CellFileError> {
    with_arms("cell-matrix.toml", include_str!("../../cell-matrix.toml"), arms)
}

/// The network that tells the kinds by their reliefs, `assets/reliefs.onnx`.
///
/// # Errors
/// None: the file is right.
pub fn network() -> Result<Network, NetworkError> {
    Network::read(include_bytes!("../../assets/reliefs.onnx").to_vec(), RELIEF_FEATURES, KINDS)
}

/// Puts the sensors of the task into a cell.
///
/// # Errors
/// What is wrong with their tables.
pub fn sensors(
    file: &CellFile,
    cell: Cell,
    matrix: MatrixSensor<Sight>,
    plant: &Plant,
) -> Result<Cell, CellError> {
    let step = file.step().as_secs_f64();
    let cell = cell.sensor(file.sensor("matrix", matrix)?).sensor(file.sensor("encoder", Encoder)?);
    Ok(cell.sensor(file.sensor("fingers", plant.fingers_before(BEAM, step))?))
}

impl Settings {
    /// The cell, with what is to be over the belt.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn ready(&self) -> Result<Ready, CellError> {
        match self.overhead {
            Overhead::Camera => self.sensed_by(
                |camera| camera,
                |file, cell, camera, plant| {
                    let step = file.step().as_secs_f64();
                    let cell =
                        cell.sensor(file.sensor("camera", camera)?).sensor(file.sensor("encoder", Encoder)?);
                    Ok(cell.sensor(file.sensor("fingers", plant.fingers_before(BEAM, step))?))
                },
            ),
            Overhead::Matrix => self.heard_by(|matrix| matrix, sensors),
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure; a fault of the run is part of its outcome.
    pub fn run(&self) -> Result<Outcome, CellError> {
        Ok(self.ready()?.run())
    }

    /// The cell with another matrix, and sensors that `sense` puts into it.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn heard_by(
        &self,
        change: impl FnOnce(MatrixSensor<Sight>) -> MatrixSensor<Sight>,
        sense: impl FnOnce(&CellFile, Cell, MatrixSensor<Sight>, &Plant) -> Result<Cell, CellError>,
    ) -> Result<Ready, CellError> {
        self.heard_in(file(self.arms)?, change, sense)
    }

    /// The same with the cell of another file.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn heard_in(
        &self,
        file: CellFile,
        change: impl FnOnce(MatrixSensor<Sight>) -> MatrixSensor<Sight>,
        sense: impl FnOnce(&CellFile, Cell, MatrixSensor<Sight>, &Plant) -> Result<Cell, CellError>,
    ) -> Result<Ready, CellError> {
        self.prepare("matrix", file, |file, cell, plant, parts, looks| {
            sense(file, cell, change(self.matrix(plant, parts, looks)?), plant)
        })
    }

    /// The matrix, and who compares what it finds with what there is.
    fn matrix(
        &self,
        plant: &Plant,
        parts: &Rc<[Coming]>,
        looks: &Rc<RefCell<Looks>>,
    ) -> Result<MatrixSensor<Sight>, CellError> {
        let array = array();
        let sight = Sight::of(plant.world.clone(), parts, plant.shaft());
        let sounders = Sounders::over(&array, Air { celsius: 20.0 }, self.seed.wrapping_add(5));
        let network = network().map_err(|error| wrong(&error))?;
        let hearing = Hearing::new(&array, classes(), Box::new(network)).with_limits(&LIMITS);
        let monitor = MatrixMonitor {
            sight: sight.clone(),
            world: plant.world.clone(),
            parts: parts.clone(),
            looks: looks.clone(),
            turns: kinds().iter().map(|kind| kind.class.turns).collect(),
        };
        let matrix = MatrixSensor::new(sight, sounders, Reliefs::by(array), hearing, Acquire::LATCH);
        Ok(matrix.watched(Box::new(monitor)))
    }
}

/// Compares what is heard of a part with where it truly is in the frame of the true belt.
struct MatrixMonitor {
    sight: Sight,
    world: World,
    parts: Rc<[Coming]>,
    looks: Rc<RefCell<Looks>>,
    turns: Vec<u32>,
}

impl MatrixMonitor {
    /// Whose traces are kept: one in the middle.
    const TRACED: usize = 12;
}

impl Listener for MatrixMonitor {
    fn pinged(&mut self, number: usize, time: f64, echo: Option<Echo>, sounders: &Sounders) {
        let looks = &mut *self.looks.borrow_mut();
        if number == Self::TRACED && looks.keep > 0 && looks.reliefs.is_empty() {
            looks.traces.push(Trace { time, heard: sounders.wave().heard().to_vec(), echo });
        }
    }

    fn evaluated(&mut self, relief: &Relief, heard: &HeardObject) {
        let looks = &mut *self.looks.borrow_mut();
        if looks.reliefs.len() < looks.keep {
            looks.reliefs.push((relief.clone(), heard.clone()));
        }
        let (run, place) = (self.sight.surface(0.0), [heard.place.x, heard.place.y]);
        looks.all.extend(nearest(
            &self.world,
            &self.parts,
            &self.turns,
            run,
            heard.class,
            place,
            heard.angle,
        ));
    }
}
