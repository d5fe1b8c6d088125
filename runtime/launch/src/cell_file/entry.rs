//! A robot and a sensor as the cell file describes them.

use core::cell::RefCell;
use core::ops::Range;
use core::time::Duration;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::str::FromStr;

use mrroc_core::cell::{CellError, InputSetup, OutputSetup};
use mrroc_core::pose::Pose;
use mrroc_core::robot::JointVector;
use mrroc_core::robot::{Robot, Tool};
use mrroc_core::sensor::VspMode;

use super::error::{At, Source};
use super::external::ExternalEntry;
use super::plant::PlantEntry;

/// A robot of a cell file, from which the set-up of its kind is made.
#[derive(Clone, Debug)]
pub struct RobotEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: At<String>,
    pub(super) kind: At<String>,
    pub(super) start: Option<At<Vec<At<f64>>>>,
    pub(super) homed: Option<At<bool>>,
    pub(super) base: Option<Pose>,
    pub(super) tool: Option<Tool>,
    pub(super) mounted_on: Option<At<String>>,
    pub(super) stop_time: Option<Duration>,
    pub(super) node: Option<At<String>>,
    pub(super) inputs: Vec<InputSetup>,
    pub(super) outputs: Vec<OutputSetup>,
    pub(super) plant: Option<PlantEntry>,
    pub(super) description: Description,
}

/// What an entry says of a robot that another file describes, and of one that is reached by a network. Only some kinds ask for it.
#[derive(Clone, Debug, Default)]
pub(super) struct Description {
    pub file: Option<At<String>>,
    pub base_link: Option<At<String>>,
    pub tip: Option<At<String>>,
    pub acceleration: Option<At<Vec<At<f64>>>>,
    pub address: Option<At<String>>,
    pub listen: Option<At<String>>,
    pub period: Option<At<Duration>>,
    pub corrections: Option<At<String>>,
    pub calibration: Option<At<String>>,
    pub coupled: Option<At<bool>>,
    /// What of it the kind asked for.
    pub asked: Rc<RefCell<Vec<EntryKey>>>,
}

impl Description {
    /// Where this key stands, if it is there.
    fn span(&self, key: EntryKey) -> Option<&Range<usize>> {
        fn of<T>(at: &Option<At<T>>) -> Option<&Range<usize>> {
            at.as_ref().map(|at| &at.span)
        }
        match key {
            EntryKey::File => of(&self.file),
            EntryKey::BaseLink => of(&self.base_link),
            EntryKey::Tip => of(&self.tip),
            EntryKey::Acceleration => of(&self.acceleration),
            EntryKey::Address => of(&self.address),
            EntryKey::Listen => of(&self.listen),
            EntryKey::Period => of(&self.period),
            EntryKey::Corrections => of(&self.corrections),
            EntryKey::Calibration => of(&self.calibration),
            EntryKey::Coupled => of(&self.coupled),
        }
    }
}

impl RobotEntry {
    /// The robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name.value
    }

    /// The kind that the file gives it.
    #[must_use]
    pub fn kind(&self) -> &str {
        &self.kind.value
    }

    /// `mounted_on`: the robot on whose flange this one is mounted. The robot gets it even if the set-up does not use it.
    #[must_use]
    pub fn mounted_on(&self) -> Option<&str> {
        self.mounted_on.as_ref().map(|on| &*on.value)
    }

    /// `base`: the pose of the robot's base in the world, `X_WB` [m, rad]; the world's origin by default. Of a robot that
    /// is mounted on another the pose in the flange of that.
    #[must_use]
    pub fn base(&self) -> Pose {
        self.base.unwrap_or_else(Pose::identity)
    }

    /// `tool`: the pose of the tool on the flange, `X_FE`; the flange by default. The robot gets this tool even if the
    /// set-up does not use it.
    #[must_use]
    pub fn tool(&self) -> Pose {
        self.tool.map_or_else(Pose::identity, |tool| tool.frame)
    }

    /// `stop_ms`: the longest stop that the robot may take, if it is not that of the cell. The robot gets it even if the set-up
    /// does not use it.
    #[must_use]
    pub fn stop_time(&self) -> Option<Duration> {
        self.stop_time
    }

    /// `plant`: the simulator of others in which the robot moves, if it does. The robot gets it even if the set-up does not use
    /// it.
    #[must_use]
    pub const fn plant(&self) -> Option<&PlantEntry> {
        self.plant.as_ref()
    }

    /// `homed`: whether the drives know where the robot is when the cell starts; true by default.
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.homed.as_ref().is_none_or(|homed| homed.value)
    }

    /// The same with drives that know where the robot is.
    pub(super) fn homed(&self) -> RobotEntry {
        RobotEntry { homed: None, ..self.clone() }
    }

    /// The same with drives of its own.
    pub(super) fn without_plant(&self) -> RobotEntry {
        RobotEntry { plant: None, ..self.clone() }
    }

    /// Refuses `homed = false` for a kind whose drives know where the robot is anyway.
    pub(super) fn refuse_unhomed(&self) -> CellError {
        let span = self.homed.as_ref().map_or(&self.kind.span, |homed| &homed.span);
        let what = format!("the drives of kind `{}` know where the robot is", self.kind());
        self.source.complain(span, what, "leave `homed` out, or write homed = true".to_owned()).into()
    }

    /// `start`: the joint positions at which a simulated robot of this kind starts [rad or m].
    ///
    /// # Errors
    /// The file has no `start`, it has another number of joints, or a joint is outside the robot's position limits. A
    /// kind refuses other impossible positions itself, by [`RobotEntry::refuse_start`].
    pub fn start<R: Robot>(&self, robot: &R) -> Result<R::Joints, CellError> {
        let joints = R::Joints::LEN;
        let Some(start) = &self.start else {
            let what = format!("robot `{}` has no `start`", self.name());
            let mut units: Vec<_> = (0..joints).map(|i| robot.joint(i).unit(0)).collect();
            units.dedup();
            let help = format!("write start = [..], {joints} joint positions [{}]", units.join(", "));
            return Err(self.source.complain(&self.name.span, what, help).into());
        };
        if start.value.len() != joints {
            let what = format!("`start` has {} numbers, {} has {joints} joints", start.value.len(), R::KIND);
            let help = format!("write one joint position for each: {joints} numbers");
            return Err(self.source.complain(&start.span, what, help).into());
        }
        let limits = robot.limits();
        for (i, At { value, span }) in start.value.iter().enumerate() {
            let (lower, upper) = (limits.lower[i], limits.upper[i]);
            // Limits whose range is empty are reported by the cell, which checks them.
            if lower < upper && !(lower..=upper).contains(value) {
                let unit = robot.joint(i).unit(0);
                let what = format!("`start` of joint {} is {value} {unit}, outside its limits", i + 1);
                let help = format!("write a number from {lower:.4} to {upper:.4} {unit}");
                return Err(self.source.complain(span, what, help).into());
            }
        }
        Ok(R::Joints::from_joints(|i| start.value[i].value))
    }

    /// `file`: the file that describes the robot, such as a URDF. A relative path is looked for in the folder of the cell file.
    ///
    /// # Errors
    /// The cell file has no `file`.
    pub fn file(&self) -> Result<PathBuf, CellError> {
        let example = "\"arm.urdf\", the file that describes it";
        let file = self.asked(&self.description.file, EntryKey::File, example)?;
        Ok(self.in_folder(&file.value))
    }

    fn in_folder(&self, file: &str) -> PathBuf {
        Path::new(&self.source.file).parent().unwrap_or(Path::new("")).join(file)
    }

    /// `tip`: the link of that description that is the flange.
    ///
    /// # Errors
    /// The cell file has no `tip`.
    pub fn tip(&self) -> Result<&str, CellError> {
        let example = "\"tool0\", the link of its file that is the flange";
        self.asked(&self.description.tip, EntryKey::Tip, example).map(|tip| &*tip.value)
    }

    /// `base_link`: the link of that description that is the base; `None` by default, which is the one on which all
    /// others hang.
    #[must_use]
    pub fn base_link(&self) -> Option<&str> {
        self.ask(EntryKey::BaseLink);
        self.description.base_link.as_ref().map(|link| &*link.value)
    }

    /// `acceleration`: the largest acceleration of each joint [rad/s² or m/s²], for a description that states none; `None`
    /// if the cell file has none.
    ///
    /// # Errors
    /// Another number of values than `joints`.
    pub fn acceleration(&self, joints: usize) -> Result<Option<Vec<f64>>, CellError> {
        self.ask(EntryKey::Acceleration);
        let Some(given) = &self.description.acceleration else { return Ok(None) };
        if given.value.len() != joints {
            let what =
                format!("`acceleration` has {} numbers, the robot has {joints} joints", given.value.len());
            let help = format!("write one acceleration for each: {joints} numbers [rad/s² or m/s²]");
            return Err(self.source.complain(&given.span, what, help).into());
        }
        Ok(Some(given.value.iter().map(|number| number.value).collect()))
    }

    /// `address`: the address of the robot's controller in its network.
    ///
    /// # Errors
    /// The cell file has no `address`, or it is none.
    pub fn address(&self) -> Result<IpAddr, CellError> {
        let example = "\"192.168.1.10\", where the robot's controller is";
        self.network(&self.description.address, EntryKey::Address, example)
    }

    /// `address` of a controller that is called at a port: `port`, unless the cell file says another one.
    ///
    /// # Errors
    /// The cell file has no `address`, or it is none.
    pub fn address_and_port(&self, port: u16) -> Result<SocketAddr, CellError> {
        let example =
            "\"192.168.1.10\", where the robot's controller is, or \"192.168.1.10:1502\", with a port";
        let text = self.asked(&self.description.address, EntryKey::Address, example)?;
        match text.value.parse::<IpAddr>() {
            Ok(address) => Ok(SocketAddr::new(address, port)),
            Err(_) => self.network(&self.description.address, EntryKey::Address, example),
        }
    }

    /// `listen`: the address of this machine in that network, and the port on which it listens for the robot.
    ///
    /// # Errors
    /// The cell file has no `listen`, or it is none, or says any address: a robot is listened for on one.
    pub fn listen(&self) -> Result<SocketAddr, CellError> {
        let example = "\"192.168.1.2:49152\", this machine's address there and a port";
        let listen: SocketAddr = self.network(&self.description.listen, EntryKey::Listen, example)?;
        if listen.ip().is_unspecified() {
            let what =
                format!("robot `{}` would be listened for on every network of this machine", self.name());
            return Err(self.refuse(EntryKey::Listen, what, format!("write listen = {example}")));
        }
        Ok(listen)
    }

    /// `period_ms`: the period of the robot's controller, where that may be chosen; `None` if the cell file has none.
    #[must_use]
    pub fn period(&self) -> Option<Duration> {
        self.ask(EntryKey::Period);
        self.description.period.as_ref().map(|period| period.value)
    }

    /// `corrections`: what the robot's controller counts the corrections from that it is sent; `None` if the cell file does not
    /// say it.
    #[must_use]
    pub fn corrections(&self) -> Option<&str> {
        self.ask(EntryKey::Corrections);
        self.description.corrections.as_ref().map(|text| &*text.value)
    }

    /// `calibration`: the file with the calibration of this one arm; `None` if the cell file names none. A relative path is
    /// looked for in the folder of the cell file.
    #[must_use]
    pub fn calibration(&self) -> Option<PathBuf> {
        self.ask(EntryKey::Calibration);
        self.description.calibration.as_ref().map(|file| self.in_folder(&file.value))
    }

    /// `coupled`: whether the links of a simulated robot couple its motors; false by default.
    #[must_use]
    pub fn is_coupled(&self) -> bool {
        self.ask(EntryKey::Coupled);
        self.description.coupled.as_ref().is_some_and(|coupled| coupled.value)
    }

    fn network<T: FromStr>(
        &self,
        value: &Option<At<String>>,
        key: EntryKey,
        example: &str,
    ) -> Result<T, CellError> {
        let text = self.asked(value, key, example)?;
        text.value.parse().map_err(|_| {
            let what = format!("`{}` is no {} of a network", text.value, key.name());
            self.source.complain(&text.span, what, format!("write {} = {example}", key.name())).into()
        })
    }

    /// Refuses what a key of this entry says, or that it is not there: `what` is wrong with it, and `help` says what to write.
    #[must_use]
    pub fn refuse(&self, key: EntryKey, what: String, help: String) -> CellError {
        let span = self.description.span(key);
        self.source.complain(span.unwrap_or(&self.name.span), what, help).into()
    }

    fn ask(&self, key: EntryKey) {
        self.description.asked.borrow_mut().push(key);
    }

    fn asked<'a, T>(
        &self,
        value: &'a Option<At<T>>,
        key: EntryKey,
        example: &str,
    ) -> Result<&'a At<T>, CellError> {
        self.ask(key);
        value.as_ref().ok_or_else(|| {
            let what = format!("robot `{}` has no `{}`", self.name(), key.name());
            self.source.complain(&self.name.span, what, format!("write {} = {example}", key.name())).into()
        })
    }

    /// Refuses what describes the robot if its kind has not asked for it, and so has not read it.
    pub(super) fn all_read(&self) -> Result<(), CellError> {
        let asked = self.description.asked.borrow();
        let unread = EntryKey::ALL.into_iter().filter(|key| !asked.contains(key));
        match unread.filter_map(|key| Some((key, self.description.span(key)?))).next() {
            None => Ok(()),
            Some((key, span)) => {
                let what = format!("the kind `{}` does not read `{}`", self.kind(), key.name());
                Err(self.source.complain(span, what, key.instead().to_owned()).into())
            }
        }
    }

    /// Refuses the `start` for a reason that limits of single joints cannot express, such as motors that several joints
    /// share: `what` is wrong with it, and `help` says what to write.
    #[must_use]
    pub fn refuse_start(&self, what: String, help: String) -> CellError {
        let span = self.start.as_ref().map_or(&self.name.span, |start| &start.span);
        self.source.complain(span, what, help).into()
    }

    pub(super) fn unknown_kind(&self, known: &[&str]) -> CellError {
        let what = format!("no kind of robot `{}`", self.kind());
        let help = mrroc_core::suggestion::suggestion(self.kind(), known, "the program knows");
        self.source.complain(&self.kind.span, what, help).into()
    }
}

/// A key of an entry that only some kinds read, for [`RobotEntry::refuse`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryKey {
    /// `file`.
    File,
    /// `base_link`.
    BaseLink,
    /// `tip`.
    Tip,
    /// `acceleration`.
    Acceleration,
    /// `address`.
    Address,
    /// `listen`.
    Listen,
    /// `period_ms`.
    Period,
    /// `corrections`.
    Corrections,
    /// `calibration`.
    Calibration,
    /// `coupled`.
    Coupled,
}

impl EntryKey {
    const ALL: [EntryKey; 10] = [
        EntryKey::File,
        EntryKey::BaseLink,
        EntryKey::Tip,
        EntryKey::Address,
        EntryKey::Listen,
        EntryKey::Acceleration,
        EntryKey::Period,
        EntryKey::Corrections,
        EntryKey::Calibration,
        EntryKey::Coupled,
    ];

    /// As the cell file writes it.
    const fn name(self) -> &'static str {
        match self {
            EntryKey::File => "file",
            EntryKey::BaseLink => "base_link",
            EntryKey::Tip => "tip",
            EntryKey::Acceleration => "acceleration",
            EntryKey::Address => "address",
            EntryKey::Listen => "listen",
            EntryKey::Period => "period_ms",
            EntryKey::Corrections => "corrections",
            EntryKey::Calibration => "calibration",
            EntryKey::Coupled => "coupled",
        }
    }

    /// What to do where a kind does not read it.
    const fn instead(self) -> &'static str {
        match self {
            EntryKey::File | EntryKey::BaseLink | EntryKey::Tip | EntryKey::Acceleration => {
                "leave it out, or write kind = \"urdf\" for an arm that a file describes"
            }
            EntryKey::Address | EntryKey::Listen => "leave it out, or write the kind of a robot on a network",
            EntryKey::Period => "leave it out: the period of these drives cannot be chosen",
            EntryKey::Corrections => "leave it out, or write the kind of a robot that is sent corrections",
            EntryKey::Calibration => {
                "leave it out, or write a kind that is calibrated: irp6, urdf, or one whose controller tells its calibration"
            }
            EntryKey::Coupled => "leave it out: the drives of this kind are not simulated by their masses",
        }
    }
}

/// A sensor of a cell file.
#[derive(Clone, Debug)]
pub(super) struct SensorEntry {
    pub name: String,
    pub of: Option<String>,
    pub readers: Option<Vec<String>>,
    pub every: Option<u32>,
    pub stale_after: Option<Duration>,
    pub mode: VspMode,
    pub latency: Duration,
    pub node: Option<At<String>>,
    pub external: Option<ExternalEntry>,
}
