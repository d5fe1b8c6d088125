//! The kinds of robots that a cell file may name.

use core::any::Any;
use core::time::Duration;
use std::rc::Rc;

use mrroc_core::cell::{AnyRobot, CellError, RobotSetup};
use mrroc_core::observe::solid::Solid;
#[cfg(doc)]
use mrroc_core::robot::Driver;
use mrroc_core::robot::{IdealDrives, Robot, Simulator};

use super::entry::RobotEntry;
use super::obstacle::{ObstacleEntry, ObstacleMesh};
use super::plant::PlantEntry;

type Make = Rc<dyn Fn(&RobotEntry, Option<&MakeSimulator>) -> Result<Box<dyn AnyRobot>, CellError>>;

/// Makes the connection to the simulator of others in which a robot moves.
type MakeSimulator = Box<dyn Fn(&PlantEntry) -> Box<dyn Simulator>>;

/// Makes what is drawn of an obstacle that is a mesh.
type DrawMesh = Box<dyn Fn(&ObstacleEntry, &ObstacleMesh) -> Result<Solid, CellError>>;

/// The kinds of robots that a program knows, each with the function that makes a set-up: the model and the drives.
#[derive(Default)]
pub struct Kinds {
    makes: Vec<(String, Make)>,
    simulator: Option<MakeSimulator>,
    mesh: Option<DrawMesh>,
}

impl Kinds {
    /// No kinds.
    #[must_use]
    pub fn new() -> Kinds {
        Kinds::default()
    }

    /// Adds the kind that the file calls `name`. If the kind exists already, its set-up is replaced, for example to use
    /// the drives of a real robot in place of simulated ones.
    ///
    /// Where nothing real may move, drives stand in for those that name their [hardware](Driver::hardware): those that
    /// the set-up [gives](RobotSetup::stand_in); else those of the kind that it replaced, if that is the same robot in Rust;
    /// else [ideal ones](IdealDrives). The latter two begin at the `start` of the file.
    #[must_use]
    pub fn with<R: Robot>(
        self,
        name: &str,
        set_up: impl Fn(&RobotEntry) -> Result<RobotSetup<R>, CellError> + 'static,
    ) -> Kinds {
        self.with_any(name, move |entry| set_up(entry).map(AnySetup::from))
    }

    /// As [`Kinds::with`], for a kind whose robots have different types in Rust: which one an entry makes, it says itself,
    /// such as by a file that describes an arm of any number of joints.
    #[must_use]
    pub fn with_any(
        mut self,
        name: &str,
        set_up: impl Fn(&RobotEntry) -> Result<AnySetup, CellError> + 'static,
    ) -> Kinds {
        let replaced = self.makes.extract_if(.., |(known, _)| known == name).next().map(|(_, make)| make);
        let make: Make = Rc::new(move |entry, simulator| {
            let AnySetup(setup) = set_up(entry)?;
            entry.all_read()?;
            setup(entry, replaced.clone(), simulator)
        });
        self.makes.push((name.to_owned(), make));
        self
    }

    /// Lets robots whose entries say `plant` move in simulators that others wrote: `simulator` makes the connection to that of an entry,
    /// such as `mrroc_external::plant`. Their own simulated drives stand in for it in a dry run and with `--simulated`.
    #[must_use]
    pub fn plants(mut self, simulator: impl Fn(&PlantEntry) -> Box<dyn Simulator> + 'static) -> Kinds {
        self.simulator = Some(Box::new(simulator));
        self
    }

    /// Lets obstacles be meshes: `draw` reads the file of one, and makes what is drawn of it in the frame of the obstacle. The
    /// kinds of `mrroc_robots::simulated` do so already.
    #[must_use]
    pub fn meshes(
        mut self,
        draw: impl Fn(&ObstacleEntry, &ObstacleMesh) -> Result<Solid, CellError> + 'static,
    ) -> Kinds {
        self.mesh = Some(Box::new(draw));
        self
    }

    /// What is drawn of an obstacle that is a mesh.
    pub(super) fn mesh(&self, entry: &ObstacleEntry, mesh: &ObstacleMesh) -> Result<Solid, CellError> {
        match &self.mesh {
            Some(draw) => draw(entry, mesh),
            None => Err(entry.refuse(
                "the kinds of robots of this program read no meshes",
                "begin with the kinds of `mrroc_robots::simulated()`, or add `.meshes(mrroc_robots::clearance::drawn_mesh)`",
            )),
        }
    }

    pub(super) fn set_up(&self, entry: &RobotEntry) -> Result<Box<dyn AnyRobot>, CellError> {
        match self.makes.iter().find(|(name, _)| name == entry.kind()) {
            Some((_, make)) => make(entry, self.simulator.as_ref()),
            None => {
                let known: Vec<_> = self.makes.iter().map(|(name, _)| &**name).collect();
                Err(entry.unknown_kind(&known))
            }
        }
    }
}

/// A set-up of a robot of any type, for [`Kinds::with_any`]: `setup.into()`.
pub struct AnySetup(Box<Finish>);

/// Makes a robot of an entry, whose kind took the place of another one.
type Finish =
    dyn FnOnce(&RobotEntry, Option<Make>, Option<&MakeSimulator>) -> Result<Box<dyn AnyRobot>, CellError>;

impl<R: Robot> From<RobotSetup<R>> for AnySetup {
    fn from(mut setup: RobotSetup<R>) -> AnySetup {
        AnySetup(Box::new(move |entry, replaced, simulator| {
            if !entry.is_homed() && setup.is_homed() {
                return Err(entry.refuse_unhomed());
            }
            // The name of a robot comes from the file and not from its set-up.
            setup.rename(entry.name());
            if let Some(plant) = entry.plant() {
                let simulator = simulator.ok_or_else(|| plant.refuse_unknown())?(plant);
                let moved = setup.in_simulator(simulator);
                setup = moved.map_err(|why| plant.refuse_drives(&why, entry.kind()))?;
            }
            let of = entry.clone();
            setup = setup.stand_in_of(move |robot, period| stand_in(replaced.as_ref(), &of, robot, period));
            if let Some(on) = entry.mounted_on() {
                setup = setup.mounted_on(on);
            }
            if let Some(limit) = entry.stop_time() {
                setup = setup.stop_time(limit);
            }
            setup = entry.inputs.iter().cloned().fold(setup, RobotSetup::input);
            setup = entry.outputs.iter().cloned().fold(setup, RobotSetup::output);
            Ok(Box::new(match entry.tool {
                Some(tool) => setup.tool(tool.frame).load(tool.load),
                None => setup,
            }))
        }))
    }
}

/// A set-up with simulated drives: that of the kind that was replaced, if it is the same kind of robot; else with ideal ones.
fn stand_in<R: Robot>(
    simulated: Option<&Make>,
    entry: &RobotEntry,
    robot: &R,
    period: Duration,
) -> Result<RobotSetup<R>, CellError> {
    // Simulated drives of that kind may not be able to look for marks: then they know where the robot is.
    let entry = &entry.without_plant();
    let homed = entry.homed();
    let made = simulated.map(|make| make(entry, None).or_else(|_| make(&homed, None))).transpose()?;
    if let Some(Ok(setup)) = made.map(|setup| (setup as Box<dyn Any>).downcast::<RobotSetup<R>>()) {
        return Ok(*setup);
    }
    let drives = IdealDrives::new(robot, entry.start(robot)?, period);
    Ok(RobotSetup::new(entry.name(), robot.clone(), drives))
}
