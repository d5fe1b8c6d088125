//! `cell.toml`: what a cell is made of, apart from what its programs do.
//!
//! In: the text of the file. Out: a [`CellFile`], from which [`CellFile::cell`] makes a [`Cell`] of the kinds of robots
//! that the program knows; or everything that is wrong with the file, each with its line and a caret.
//!
//! ```toml
//! step_ms = 2        # Ts, the step of the cell [ms]
//! stop_ms = 600      # the longest stop that it allows any joint [ms]; 600 unless it is said
//! after_fault = "end"    # or "await reset": stay latched until the operator resets it; end unless it is said
//! dry_run = true     # no run in real time before the whole program has kept all limits under the virtual clock; false
//!                    # unless it is said
//!
//! [robots.arm]       # a robot of this name
//! kind = "irp6"      # one of the program's kinds
//! start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]   # where a simulated arm starts [rad or m]
//! homed = false      # its drives must look for their reference marks first; they know where it is unless it is said
//! base = { xyz = [0.0, 0.5, 0.0] }   # X_WB; the world's origin unless it is said
//! tool = { xyz = [0.0, 0.0, 0.1], rpy = [0.0, 0.0, 1.57] }   # X_FE [m, rad], or the name of a tool; the flange unless it is
//!                                                             # said. The orientation may be quat_xyzw or zyz instead of rpy
//!
//! [robots.arm.inputs]    # of the robot's controller, by names for programs
//! part_seen = "digital 3"
//! sucked = { channel = "digital 4", follows = "vacuum", after_ms = 150 }   # simulated, it reads what that output has been
//!
//! [robots.arm.outputs]
//! vacuum = { channel = "digital 0", holds_body = true }   # it holds at a stop, as every output that says nothing else
//! spindle = { channel = "digital 1", turns_tool = true, on_stop = false }
//!
//! [frames.table]     # a frame in the world, for programs
//! xyz = [0.4, 0.0, 0.1]
//!
//! [obstacles.bench]  # what stands in the cell, for clearances, pictures and recordings
//! box = { size = [1.2, 0.8, 0.05] }   # or cylinder, sphere, capsule, half_space, cloud, height_field, mesh [m]
//! at = { xyz = [0.0, 0.0, -0.025] }   # its frame; that of the world, or of `frame`, unless it is said
//! frame = "table"    # the frame in which `at` is; the world unless it is said
//!
//! [tools.pen]        # a tool: its frame on the flange, and what the flange carries with it [kg, m, kg m²]
//! xyz = [0.0, 0.0, 0.1]
//! mass = 0.3
//! centre = [0.0, 0.0, 0.04]
//! inertia = [1e-4, 0.0, 0.0, 1e-4, 0.0, 2e-5]   # xx, xy, xz, yy, yz, zz about the centre
//!
//! [robots.hand]      # a gripper on the flange of the arm
//! kind = "gripper"
//! mounted_on = "arm" # base is then its pose in that flange, X_FB; it stands in the world unless it is said
//! start = [0.07]
//!
//! [robots.ur]        # an arm that a URDF describes, with a kind that reads one
//! kind = "urdf"
//! file = "ur.urdf"   # in the folder of this file
//! base_link = "base" # the link that is the base; the one on which all others hang unless it is said
//! tip = "tool0"      # the link that is the flange
//! acceleration = [15.0, 15.0, 15.0, 15.0, 15.0, 15.0]   # of each joint [rad/s² or m/s²], where the URDF states none
//! start = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
//!
//! stop_ms = 800      # the longest stop that this robot may take [ms]; that of the cell unless it is said
//! plant = { port = "mujoco", timeout_ms = 10000 }   # it moves in a simulator that others wrote, found by this name and waited
//!                                                     # for so long [ms]; 10 s unless it is said
//!
//! [cells.press]      # a cell that serves this one, as one of its robots
//! file = "press.toml"   # its own file, in the folder of this file
//!
//! [sensors.touch]    # a virtual sensor of this name
//! of = "arm"         # the robot that it belongs to, whose state goes with every order
//! readers = ["arm"]  # the robots whose ECPs may read it; the robot that it belongs to unless it is said
//! mode = "interactive"   # or "with delay", "free running"; interactive unless it is said
//! period_ms = 5      # of a free-running sensor
//! latency_ms = 2     # time that one aggregation takes under the virtual clock; none unless it is said
//! every = 4          # a reading is ordered in every fourth step; in every step unless it is said
//! stale_after_ms = 100   # a reading of that age is too old to move by; 20 steps unless it is said
//!
//! [sensors.camera]
//! mode = "free running"
//! period_ms = 5
//! stale_after_ms = 200
//!
//! [sensors.camera.external]   # its readings are sent by a program of another, such as one in Python
//! port = "camera"    # the name by which that program finds it; the sensor's unless it is said
//! rate_hz = 30.0     # how many readings it sends in a second
//! least = [0.0, -0.5, 0.0]    # of each number of a reading
//! largest = [1.0, 0.5, 6.3]
//! per_second = [2.0, 2.0, 10.0]   # by how much each may change in a second; by as much as it likes unless it is said
//!
//! [sensors.camera.external.topic]   # that program is the bridge to ROS 2, which reads a topic
//! name = "/part"
//! type = "geometry_msgs/msg/Pose2D"
//! reading = { x = "x", y = "y", angle = "theta" }   # for each field its path in a message
//!
//! [topics."/arm/joint_states"]   # how the bridge to ROS 2 publishes this topic; reliable, and each message, unless it is said
//! reliability = "best effort"
//! depth = 5          # messages that wait for a subscriber that is slow; 100 unless it is said
//! every_ms = 20      # on average one message in this time at most
//!
//! [nodes.left]       # a machine of the cell, if it has several; robots and sensors say `node = "left"`
//! address = "192.168.1.2:7447"   # where the others find it
//! mp = true          # the cell is started here, the MP runs here, and so does all that says no node
//!
//! [realtime]         # what the cell asks of the machine when it runs as processes; nothing unless the table is there
//! priority = 50      # of every process under SCHED_FIFO, 1 to 95
//! lock_memory = true # no page is fetched in a step (mlockall); true unless it is said
//! cores = [0, 1]     # a robot's ECP and EDP share one of them; of all cores unless it is said; [] pins nothing
//! permission = "required"   # or "best effort": run without what is not permitted; required unless it is said
//!
//! [recording]        # every step goes to a file; nothing is recorded unless the table is there, or by --record FILE
//! file = "run.mcap"  # a recording that is there is written anew, any other file is refused; in the folder in which the
//!                    # program runs
//! robots = ["arm"]   # of these robots; of all unless it is said. Only a recording of everything can be replayed
//! sensors = ["touch"]   # of these sensors; of all unless it is said
//! ```

mod entry;
mod error;
mod external;
mod heights;
mod kinds;
mod lower;
mod obstacle;
#[cfg(test)]
mod page;
mod plant;
mod points;
mod reader;
mod topic;

use core::time::Duration;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use mrroc_core::cell::Realtime;
use mrroc_core::cell::{AfterFault, Cell, CellError, Nodes, SensorSetup};
use mrroc_core::observe::Recording;
use mrroc_core::observe::layout::{Layout, RobotLayout};
use mrroc_core::pose::Pose;
use mrroc_core::robot::Tool;
use mrroc_core::sensor::Sensor;
use mrroc_core::sensor::VirtualSensor;

pub use entry::{EntryKey, RobotEntry};
pub use error::CellFileError;
pub use external::{Believable, ExternalEntry};
pub use heights::Heights;
pub use kinds::{AnySetup, Kinds};
pub use obstacle::{ObstacleEntry, ObstacleMesh, ObstacleShape};
pub use plant::PlantEntry;
pub use topic::{Place, PublishedEntry, TopicEntry, TopicReading, TopicText};

use crate::files;
use entry::SensorEntry;
use error::Source;
use lower::LowerEntry;

/// Whether a robot is an arm: a belt, a gripper or a table has at most three joints.
pub(crate) fn is_arm(robot: &&RobotLayout) -> bool {
    robot.joints.len() > 3
}

/// A cell as its file describes it: names, kinds, places and periods, without programs.
#[derive(Clone, Debug)]
pub struct CellFile {
    source: Rc<Source>,
    questions: Option<CellFileError>,
    step: Duration,
    stop_time: Option<Duration>,
    after_fault: AfterFault,
    realtime: Option<Realtime>,
    recording: Option<Recording>,
    dry_run: bool,
    nodes: Option<Nodes>,
    robots: Vec<RobotEntry>,
    cells: Vec<LowerEntry>,
    sensors: Vec<SensorEntry>,
    published: Vec<PublishedEntry>,
    frames: Vec<(String, Pose)>,
    obstacles: Vec<ObstacleEntry>,
    tools: Vec<(String, Tool)>,
}

/// The longest file \[bytes\]; the file of a cell with 31 robots has some thousand bytes.
const MOST_BYTES: u64 = 1 << 20;

impl CellFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`CellFileError`]: the file cannot be read, or everything that is wrong with it.
    pub fn read(path: impl AsRef<Path>) -> Result<CellFile, CellFileError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let mut text = String::new();
        // A device file may be endless: reading one byte more than allowed is enough to refuse it.
        let read = files::open(path).and_then(|file| file.take(MOST_BYTES + 1).read_to_string(&mut text));
        match read {
            Ok(_) => CellFile::parse(&name, &text),
            Err(error) => Err(CellFileError::unreadable(&name, &error)),
        }
    }

    /// Reads the text of a file that messages call `name`.
    ///
    /// # Errors
    /// [`CellFileError`] with everything that is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<CellFile, CellFileError> {
        if text.len() as u64 > MOST_BYTES {
            return Err(CellFileError::too_long(name, MOST_BYTES));
        }
        reader::read(name, text)
    }

    /// The file in which the operator's panel keeps the poses that it teaches a robot: `poses/left.txt` beside this file. There is
    /// none before a pose was taught.
    #[must_use]
    pub fn poses(&self, robot: &str) -> PathBuf {
        crate::files::poses(Path::new(&self.source.file), robot)
    }

    /// What is allowed in the file but improbable, such as a tool of 300 m: probably it has another unit.
    #[must_use]
    pub const fn questions(&self) -> Option<&CellFileError> {
        self.questions.as_ref()
    }

    /// The pairs of robots in a cell's layout that stand in one place although both are arms: probably one has no `base`.
    #[must_use]
    pub fn arms_in_one_place(&self, layout: &Layout) -> Vec<[&str; 2]> {
        // A belt, a gripper or a table may well be where an arm is.
        let is_arm = |name: &str| layout.robots.iter().filter(is_arm).any(|robot| robot.name == name);
        let stands = |robot: &&RobotEntry| robot.mounted_on().is_none() && is_arm(robot.name());
        let arms: Vec<_> = self.robots.iter().filter(stands).collect();
        let near = |a: &RobotEntry, b: &RobotEntry| {
            let by = a.base().inv_mul(&b.base());
            by.translation.vector.norm() < 1e-3 && by.rotation.angle() < 1e-3
        };
        let pairs = arms.iter().enumerate().flat_map(|(i, a)| arms[i + 1..].iter().map(move |b| (*a, *b)));
        pairs.filter(|(a, b)| near(a, b)).map(|(a, b)| [a.name(), b.name()]).collect()
    }

    /// The step of the cell, `Ts`.
    #[must_use]
    pub fn step(&self) -> Duration {
        self.step
    }

    /// The robots, in the order of the file.
    #[must_use]
    pub fn robots(&self) -> &[RobotEntry] {
        &self.robots
    }

    /// What stands in the cell, in the order of the file.
    #[must_use]
    pub fn obstacles(&self) -> &[ObstacleEntry] {
        &self.obstacles
    }

    /// The machines of the cell; `None` if it is on one.
    #[must_use]
    pub fn nodes(&self) -> Option<&Nodes> {
        self.nodes.as_ref()
    }

    /// Makes a cell with the robots of the file, each set up by its kind. The program adds its programs and sensors to
    /// it.
    ///
    /// # Errors
    /// Everything that the file asks for and the kinds cannot provide, for all robots at once.
    pub fn cell(&self, kinds: &Kinds) -> Result<Cell, CellError> {
        let mut cell = Cell::new(self.step)
            .expect_sensors(self.sensors.iter().map(|sensor| &*sensor.name))
            .expect_cells(self.cells.iter().map(|lower| &*lower.name))
            .ask_for(self.realtime.clone())
            .after_fault(self.after_fault);
        if let Some(limit) = self.stop_time {
            cell = cell.stop_time(limit);
        }
        if let Some(recording) = &self.recording {
            cell = cell.record(recording.clone());
        }
        if self.dry_run {
            cell = cell.demand_dry_run();
        }
        if let Some(nodes) = &self.nodes {
            cell = cell.on_nodes(nodes.clone());
        }
        cell = self.frames.iter().fold(cell, |cell, (name, frame)| cell.frame(name, *frame));
        cell = self.tools.iter().fold(cell, |cell, (name, tool)| cell.tool(name, *tool));
        let mut errors = Vec::new();
        for obstacle in &self.obstacles {
            match obstacle.solid(|entry, mesh| kinds.mesh(entry, mesh)) {
                Ok(solid) => cell = cell.shows_obstacle(obstacle.name(), obstacle.place_of_solid(), solid),
                Err(error) => errors.push(error),
            }
        }
        // Of each simulator, its first robot and that one's servo period: it makes its steps with all robots at a time.
        let mut periods = BTreeMap::new();
        for entry in &self.robots {
            match kinds.set_up(entry) {
                Ok(robot) => {
                    if let Some(plant) = entry.plant() {
                        let period = robot.servo_period().length;
                        let first = periods.entry(plant.port()).or_insert((entry.name(), period));
                        if first.1 != period {
                            errors.push(plant.refuse_period(period, first.0, first.1));
                        }
                    }
                    cell.push_robot(robot);
                }
                Err(error) => errors.push(error),
            }
        }
        CellError::all(errors).map(|()| cell)
    }

    fn sensor_entry(&self, name: &str) -> Result<&SensorEntry, CellError> {
        let there = || self.sensors.iter().map(|sensor| &*sensor.name);
        let found = self.sensors.iter().find(|entry| entry.name == name);
        found.ok_or_else(|| self.source.missing("sensors", name, there()).into())
    }

    /// What the file says of the virtual sensor `name` and the program of another that sends its readings.
    ///
    /// # Errors
    /// The file has no sensor of that name, or says nothing of such a program.
    pub fn external(&self, name: &str) -> Result<&ExternalEntry, CellError> {
        let there =
            || self.sensors.iter().filter(|sensor| sensor.external.is_some()).map(|sensor| &*sensor.name);
        let entry = self.sensor_entry(name)?.external.as_ref();
        entry.ok_or_else(|| self.source.missing("sensors", &format!("{name}.external"), there()).into())
    }

    /// The sensors whose programs are on other machines.
    pub fn gateways(&self) -> impl Iterator<Item = &ExternalEntry> {
        let external = self.sensors.iter().filter_map(|sensor| sensor.external.as_ref());
        external.filter(|external| external.address().is_some())
    }

    /// The sensors whose readings are messages of ROS 2.
    pub fn topics(&self) -> impl Iterator<Item = (&ExternalEntry, &TopicEntry)> {
        let external = self.sensors.iter().filter_map(|sensor| sensor.external.as_ref());
        external.filter_map(|external| Some((external, external.topic()?)))
    }

    /// How the bridge to ROS 2 publishes topics, as far as the file says.
    #[must_use]
    pub fn published(&self) -> &[PublishedEntry] {
        &self.published
    }

    /// The set-up of the virtual sensor that the file calls `name`, computed by `sensor`.
    ///
    /// # Errors
    /// The file has no sensor of that name, or says that a program of another sends its readings.
    pub fn sensor<V: VirtualSensor>(&self, name: &str, sensor: V) -> Result<SensorSetup<V>, CellError>
    where
        <V::Kind as Sensor>::Configuration: Default,
    {
        let entry = self.sensor_entry(name)?;
        if let Some(external) = entry.external.as_ref().filter(|_| sensor.python().is_none()) {
            return Err(external.refuse_computed());
        }
        let mut setup = SensorSetup::new(name, sensor).mode(entry.mode).latency(entry.latency);
        if let Some(robot) = &entry.of {
            setup = setup.of(robot);
        }
        if let Some(readers) = &entry.readers {
            setup = setup.readers(readers.iter().map(String::as_str));
        }
        if let Some(steps) = entry.every {
            setup = setup.every(steps);
        }
        if let Some(age) = entry.stale_after {
            setup = setup.stale_after(age);
        }
        Ok(setup)
    }
}
