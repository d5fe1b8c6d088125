//! One run with a sensor over the belt: a belt, a seed, some parts.

use std::cell::{Cell as Shown, RefCell};
use std::rc::Rc;
use std::time::{Duration, Instant};

use mrroc::cell::RunReport;
use mrroc::cell_file::{CellFile, CellFileError};
use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc::robot::RobotView;
use mrroc_robots::clearance::{Closest, DryRun};
use mrroc_robots::grasp::{Hand, Sink, Touch, Whereabouts, World};
use mrroc_sensors::aggregation::{DetectedObject, FEATURES, Network, NetworkError, Vision};
use mrroc_sensors::physics::{Imager, LightBarrier};
use mrroc_sensors::view::View as _;
use mrroc_sensors::virtual_sensors::{CameraSensor, Encoder, Sampled, Trigger};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::acquire::Acquire;
use super::arrivals::{Coming, coming};
use super::clear::{Seen, clearance, guard};
use super::kinds::{KINDS, classes, kinds};
use super::layout::{BEAM, BINS, FEED, LAST, STATIONS, TRIGGER, bin, camera};
use super::looks::{Look, Looks, nearest};
use super::queue::Queue;
use super::settings::Settings;
use super::share::{self, Shared};
use super::sight::Sight;
use super::studio::misplaced;
use super::{ecp, mp};
use crate::generators::Uneven;
use crate::monitor::Fate;
use crate::mp::Failed;
use crate::places::{BELT, SURFACE, TRAY, TRAYS};
use crate::plant::Plant;
use crate::progress::Progress;
use crate::reach::Reach;
use crate::scene::Belt;

/// The sink at the end of the belt; the bins are those before it.
pub const END_BIN: usize = BINS;

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    /// The parts that come.
    pub parts: Rc<[Coming]>,
    /// What the camera saw.
    pub looks: Rc<RefCell<Looks>>,
    /// How far it has come.
    pub progress: Progress,
    /// How many arms there are.
    pub arms: usize,
    grips: Rc<RefCell<Vec<Grip>>>,
    late: Rc<RefCell<Vec<u32>>>,
    stranded: Rc<RefCell<Vec<u32>>>,
    failed: Rc<[Shown<Failed>; STATIONS.len()]>,
    vain: Rc<RefCell<Vec<(u32, usize)>>>,
    gap: Option<Rc<RefCell<DryRun>>>,
    nearness: Rc<Shown<Seen>>,
}

/// A grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Which part.
    pub part: usize,
    /// Which arm, counted from 0.
    pub arm: usize,
    /// When \[s\].
    pub time: f64,
    /// How far the part's frame was off the middle of the pads, along them \[m\]; across them the fingers bring it there.
    pub off: f64,
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// What became of each part.
    pub fates: Vec<Fate>,
    /// When each came \[s\], and its kind.
    pub came: Vec<(f64, usize)>,
    /// What was found in images.
    pub looks: Vec<Look>,
    /// The grasps.
    pub grips: Vec<Grip>,
    /// Numbers of parts that went by while the arm was busy, as the camera counts them.
    pub late: Vec<u32>,
    /// Numbers of parts that were put back, because the arm could not bring them to their bins.
    pub stranded: Vec<u32>,
    /// Of two arms: parts that an arm did not find between its fingers, as the camera counts them, and which arm.
    pub vain: Vec<(u32, usize)>,
    /// The least distance of two arms, and when that was.
    pub closest: Option<Closest>,
    /// What their guard saw.
    pub nearness: Seen,
    /// How often a finger came down on a part.
    pub crashes: u32,
    /// How often a hand closed on nothing, and was opened again.
    pub failed: u32,
}

/// The cell of the task with the camera, `cell-camera.toml`, and with so many arms.
///
/// # Errors
/// None: the files are right.
pub fn file(arms: usize) -> Result<CellFile, CellFileError> {
    with_arms("cell-camera.toml", include_str!("../../cell-camera.toml"), arms)
}

/// A cell of the task with so many arms: `cell-second-arm.toml` says what the second one adds.
///
/// # Errors
/// What is wrong with the file.
pub fn with_arms(name: &str, text: &str, arms: usize) -> Result<CellFile, CellFileError> {
    let second = if arms > 1 { include_str!("../../cell-second-arm.toml") } else { "" };
    CellFile::parse(name, &format!("{text}\n{second}"))
}

/// The network that tells the kinds, `assets/parts.onnx`.
///
/// # Errors
/// None: the file is right.
pub fn network() -> Result<Network, NetworkError> {
    Network::read(include_bytes!("../../assets/parts.onnx").to_vec(), FEATURES, KINDS)
}

/// A fault that says what is wrong with a figure.
pub(crate) fn wrong(error: &impl core::fmt::Display) -> Fault {
    Fault::thrown(&error.to_string())
}

impl Settings {
    /// The cell with another camera, and sensors that `sense` puts into it.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn sensed_by(
        &self,
        look: impl FnOnce(CameraSensor<Sight>) -> CameraSensor<Sight>,
        sense: impl FnOnce(&CellFile, Cell, CameraSensor<Sight>, &Plant) -> Result<Cell, CellError>,
    ) -> Result<Ready, CellError> {
        self.prepare("camera", file(self.arms)?, |file, cell, plant, parts, looks| {
            sense(file, cell, look(self.camera(plant, parts, looks)?), plant)
        })
    }

    /// The cell of a file with sensors that `sense` puts into it, among them one of this name that tells of parts.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn prepare(
        &self,
        eye: &'static str,
        file: CellFile,
        sense: impl FnOnce(&CellFile, Cell, &Plant, &Rc<[Coming]>, &Rc<RefCell<Looks>>) -> Result<Cell, CellError>,
    ) -> Result<Ready, CellError> {
        let slowest = (1.0 - 1.1 * Uneven::OFF) * self.speed;
        let gap = self.spacing() / slowest;
        let apart = gap.max(self.regular * self.every);
        let parts: Rc<[Coming]> = coming(self, apart).into();
        let world = bins(self.arms).map_err(|error| wrong(&error))?;
        for part in parts.iter() {
            world.put_at(&part.body, part.time).map_err(|error| wrong(&error))?;
        }
        let scene = Belt::of(world.clone(), parts.iter().map(|part| (&part.body, part.reflectance)));
        let stations = &STATIONS[..self.arms.clamp(1, STATIONS.len())];
        let longer = stations[stations.len() - 1].along;
        let plant = Plant::of(world, scene, self.seed.wrapping_mul(1000)).with_belt_longer_by(longer);
        let cell = file.cell(&plant.kinds())?;
        let looks = Rc::<RefCell<Looks>>::default();
        let mut cell = sense(&file, cell, &plant, &parts, &looks)?;
        let stranded = Rc::<RefCell<Vec<u32>>>::default();
        for (number, station) in stations.iter().enumerate() {
            if number > 0 {
                let fingers = plant.fingers_of(number, BEAM, file.step().as_secs_f64());
                cell = cell.sensor(file.sensor(station.encoder, Encoder)?);
                cell = cell.sensor(file.sensor(station.fingers, fingers)?);
            }
            let [arm, hand] = station.robots;
            let (reach, put_back) = (Reach::at(station.along, file.step()), stranded.clone());
            let reach = self.noticing.map_or(reach.clone(), |noticing| reach.noticing(noticing));
            cell = cell.ecp(arm, move |ecp| ecp::arm(ecp, station, &reach, &put_back));
            cell = cell.ecp(hand, |ecp| ecp::hand(ecp, station));
        }
        let timeout = 8.0 * self.every.max(gap) + (LAST + longer - FEED) / slowest + self.first();
        let Self { speed, seed, profile, parts: count, .. } = *self;
        let late = Rc::<RefCell<Vec<u32>>>::default();
        let missed = late.clone();
        let vain = Rc::<RefCell<Vec<(u32, usize)>>>::default();
        let tried = vain.clone();
        let arms = stations.len();
        let failed = Rc::<[Shown<Failed>; STATIONS.len()]>::default();
        let fails = failed.clone();
        let cell = cell.program(move |mp| {
            let belt = Uneven::about(speed, seed.wrapping_add(77)).changing(profile);
            let fastest = Uneven::fastest(speed, profile);
            if arms > 1 {
                let shared = Shared::of(count as u32, timeout).on_belt(fastest);
                let shared = share::coordinate(mp, eye, belt, shared, &fails)?;
                missed.replace(shared.late());
                tried.replace(shared.vain);
            } else {
                let queue = Queue::of(count as u32, timeout).on_belt(fastest);
                let queue = mp::coordinate(mp, eye, belt, queue, &fails[0])?;
                missed.replace(queue.late);
            }
            Ok(())
        });
        let hands: Vec<_> = (0..arms).filter_map(|arm| plant.world.hand(arm)).collect();
        let grips = Rc::<RefCell<Vec<Grip>>>::default();
        let progress = Progress::of(plant.world.clone(), parts.len());
        let mut look = watch(hands, parts.clone(), grips.clone(), progress.look());
        let nearness = Rc::new(Shown::new(Seen { least: f64::INFINITY, closing: 0.0 }));
        let (cell, gap) = if arms > 1 {
            let gap = Rc::new(RefCell::new(DryRun::new(clearance(&file)?)));
            let (seen, mut clear) = (gap.clone(), guard(&file, self.margin, nearness.clone())?);
            let cell = cell.watch(move |observation| seen.borrow_mut().observe(observation));
            let both = move |robots: &[RobotView]| look(robots).and_then(|()| clear(robots));
            (cell.guard(1, both), Some(gap))
        } else {
            (cell.guard(1, look), None)
        };
        Ok(Ready {
            cell,
            plant,
            parts,
            looks,
            progress,
            arms,
            grips,
            late,
            stranded,
            failed,
            vain,
            gap,
            nearness,
        })
    }

    /// The camera, and who compares what it finds with what there is.
    fn camera(
        &self,
        plant: &Plant,
        parts: &Rc<[Coming]>,
        looks: &Rc<RefCell<Looks>>,
    ) -> Result<CameraSensor<Sight>, CellError> {
        let mut random = Noise::seeded(self.seed.wrapping_add(99));
        let believed = camera();
        let truly = misplaced(&believed, &mut random);
        let sight = Sight::of(plant.world.clone(), parts, plant.shaft());
        let imager = Imager::over(truly, self.seed.wrapping_add(5));
        let network = network().map_err(|error| wrong(&error))?;
        let vision = Vision::new(believed, classes(), Box::new(network));
        let look = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), core::f64::consts::FRAC_PI_2);
        let [s, over] = TRIGGER;
        let beam = Translation3::new(BELT[0] - 0.5 * SURFACE[2], BELT[1] + s, over) * look;
        let barrier = Sampled::new(LightBarrier::new(0.004, self.seed.wrapping_add(6)));
        let trigger = Trigger::Barrier(beam, barrier);
        let observer = compare(sight.clone(), plant.world.clone(), parts.clone(), looks.clone());
        Ok(CameraSensor::new(sight, imager, vision, trigger, Acquire::LATCH).watched(Box::new(observer)))
    }
}

/// A world with the bins, and one below everything.
fn bins(arms: usize) -> Result<World, mrroc_robots::grasp::WorldError> {
    let mut world = World::empty().with_rest();
    for (number, station) in STATIONS.iter().take(arms).enumerate() {
        for bin in bin_sinks(station.along) {
            world = world.with_sink(bin)?;
        }
        if number == 0 {
            let far = 2.0 + STATIONS[arms.clamp(1, STATIONS.len()) - 1].along;
            world = world.with_sink(Sink { lower: [-2.0, -2.0, -1.0], upper: [2.0, far, -0.1] })?;
        }
    }
    Ok(world)
}

/// The bins of an arm that stands so far along the belt \[m\].
fn bin_sinks(along: f64) -> impl Iterator<Item = Sink> {
    (0..BINS).map(move |number| {
        let ([x, y], [dx, dy]) = bin(number);
        let (y, z, dz) = (y + along, TRAYS[number / 4][2], 0.5 * TRAY[2]);
        Sink { lower: [x - dx, y - dy, z - dz], upper: [x + dx, y + dy, z + dz] }
    })
}

/// Whose bin a sink is: that of this kind, of either arm.
const fn kind_of(sink: usize) -> usize {
    if sink > END_BIN { sink - END_BIN - 1 } else { sink }
}

/// Looks at the hand after each step: what a guard of a cell does.
fn watch(
    hands: Vec<Hand>,
    parts: Rc<[Coming]>,
    grips: Rc<RefCell<Vec<Grip>>>,
    mut progress: impl FnMut() + 'static,
) -> impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static {
    let mut last = [None; STATIONS.len()];
    move |_| {
        progress();
        for (arm, (hand, last)) in hands.iter().zip(&mut last).enumerate() {
            if let Some(Touch { body, time, X_EB, .. }) = hand.gripped()
                && *last != Some(time)
            {
                *last = Some(time);
                let place = X_EB * parts[body].X_BP;
                grips.borrow_mut().push(Grip { part: body, arm, time, off: place.translation.y });
            }
        }
        Ok(())
    }
}

/// Compares what is found in an image with where parts truly are in the frame of the true belt, when it was exposed.
fn compare(
    sight: Sight,
    world: World,
    parts: Rc<[Coming]>,
    looks: Rc<RefCell<Looks>>,
) -> impl FnMut(&[u8], &[DetectedObject], f64, f64) {
    let turns: Vec<u32> = kinds().iter().map(|kind| kind.class.turns).collect();
    move |image, found, _, travel| {
        let looks = &mut *looks.borrow_mut();
        if looks.images.len() < looks.keep {
            looks.images.push((image.to_vec(), found.to_vec()));
        }
        let run = sight.surface(0.0);
        for thing in found {
            let place = [thing.place.x - travel, thing.place.y];
            looks.all.extend(nearest(&world, &parts, &turns, run, thing.class, place, thing.angle));
        }
    }
}

/// What became of a part of a kind that is there at the end, and that a hand has had or not.
fn fate(at: Option<Whereabouts>, kind: usize, gripped: bool) -> Fate {
    match at {
        Some(Whereabouts::Gone { sink, .. }) if sink != END_BIN => {
            if kind_of(sink) == kind {
                Fate::Sorted
            } else {
                Fate::Wrong
            }
        }
        Some(Whereabouts::Gone { .. } | Whereabouts::Awaited | Whereabouts::Here) | None => {
            match (kind == KINDS, gripped) {
                (false, _) => Fate::Missed,
                (true, true) => Fate::Gripped,
                (true, false) => Fate::Passed,
            }
        }
    }
}

impl Ready {
    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let world = &self.plant.world;
        let grips = self.grips.borrow();
        let fate = |(number, part): (usize, &Coming)| {
            let gripped = grips.iter().any(|grip| grip.part == number);
            fate(world.whereabouts(number), part.kind, gripped)
        };
        Outcome {
            report,
            wall,
            fates: self.parts.iter().enumerate().map(fate).collect(),
            came: self.parts.iter().map(|part| (part.time, part.kind)).collect(),
            looks: self.looks.borrow().all.clone(),
            grips: grips.clone(),
            late: self.late.borrow().clone(),
            stranded: self.stranded.borrow().clone(),
            failed: self.failed.iter().map(|failed| failed.get().all).sum(),
            vain: self.vain.borrow().clone(),
            nearness: self.nearness.get(),
            closest: self.gap.and_then(|gap| gap.borrow_mut().closest().ok().flatten().cloned()),
            crashes: (0..STATIONS.len()).filter_map(|arm| world.hand(arm)).map(|hand| hand.crashes()).sum(),
        }
    }
}

impl Outcome {
    /// How many parts had this fate.
    #[must_use]
    pub fn count(&self, fate: Fate) -> usize {
        self.fates.iter().filter(|of| **of == fate).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stranger_that_a_hand_had_did_not_pass_and_one_in_a_bin_is_in_a_wrong_one() {
        let gone = |sink: usize| Some(Whereabouts::Gone { sink, time: 9.0 });
        for (at, kind, gripped, wanted) in [
            (gone(END_BIN), KINDS, false, Fate::Passed),
            (gone(END_BIN), KINDS, true, Fate::Gripped),
            (Some(Whereabouts::Here), KINDS, true, Fate::Gripped),
            (gone(3), KINDS, true, Fate::Wrong),
            (gone(END_BIN), 3, true, Fate::Missed),
            (gone(3), 3, true, Fate::Sorted),
            (gone(END_BIN + 1 + 3), 3, true, Fate::Sorted),
            (gone(4), 3, true, Fate::Wrong),
            (None, 3, false, Fate::Missed),
        ] {
            assert_eq!(fate(at, kind, gripped), wanted, "{at:?}, kind {kind}, gripped {gripped}");
        }
    }
}
