//! The kinds of robots that a `cell.toml` may name, simulated.

use core::f64::consts::PI;
use core::time::Duration;
use std::cell::RefCell;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use mrroc::fault::Excess;
use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, IdealDrives};
use mrroc_launch::cell_file::{AnySetup, EntryKey, Kinds, RobotEntry};
use mrroc_launch::files;
use nalgebra::SVector;

use crate::clearance::drawn_mesh;
use crate::models::{
    ArmCalibration, Conveyor, Driven, Gripper, IoBlock, Irp6, Irp6FiveDof, Irp6Track, Kinematics,
    NoCalibration, NoJoints, One, Polycrank, Rnt, Serial, TwoFingers, UrdfError, UrdfText,
};
use crate::simulation::grasp::{Belt, Grasp, Jaws, Pads, World, WorldError};
use crate::simulation::{Simulated, Unhomed};

/// The servo period of a device without joints.
const BLOCK: Duration = Duration::from_millis(2);

/// The robots of this crate, each simulated from the joint positions that the cell file gives as its `start`, and standing
/// at its `base`.
///
/// | kind | robot | `start` |
/// |---|---|---|
/// | `irp6` | [`Irp6::nominal`] | 6 x rad |
/// | `irp6-calibrated` | [`Irp6::calibrated`] | 6 x rad |
/// | `irp6-5dof` | [`Irp6FiveDof::nominal`] | 5 x rad |
/// | `irp6-track` | [`Irp6Track::nominal`] | m, 6 x rad |
/// | `rnt` | [`Rnt`] | rad, 2 x m, 3 x rad |
/// | `polycrank` | [`Polycrank`] | 7 x rad |
/// | `gripper` | [`Gripper`], which an object may stop anywhere | m |
/// | `conveyor` | [`Conveyor`]; it needs `stop_ms = 5000` in its table | m |
/// | `io-block` | [`IoBlock`]: inputs and outputs, and no joints | none |
/// | `urdf` | [`Serial`], read from the `file` of the entry, from its `base_link` to its `tip`, with its `acceleration` | a rad or m for each joint |
///
/// With `calibration = ".."` an `irp6` or a `urdf` has the dimensions that were measured of this one arm ([`ArmCalibration`]): programs see it as it is, and
/// the file of another arm is refused.
///
/// With `homed = false` the drives do not know where the robot is, which is near `start`, and look for their marks first
/// ([`Unhomed`]).
///
/// With `coupled = true` the links couple the motors ([`Simulated::coupled`]); a robot whose masses are not known is refused.
///
/// A `start` that the drives cannot take is refused, as one beyond the joint limits is. [`Kinds::with`] puts the drives of
/// a real robot in the place of simulated ones.
#[must_use]
pub fn simulated() -> Kinds {
    const ARM: [f64; 6] = Irp6::READY.data.0[0];
    Kinds::new()
        .meshes(drawn_mesh)
        .with("irp6", |entry| set_up(entry, irp6(entry)?, ARM))
        .with("irp6-calibrated", |entry| set_up(entry, Irp6::calibrated().with_base(entry.base()), ARM))
        .with("irp6-5dof", |entry| {
            set_up(entry, Irp6FiveDof::nominal().with_base(entry.base()), [0.0, -1.57, 0.16, 0.6, 1.0])
        })
        .with("irp6-track", |entry| {
            let start = [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0];
            set_up(entry, Irp6Track::nominal().with_base(entry.base()), start)
        })
        .with("rnt", |entry| {
            set_up(entry, Rnt::new().with_base(entry.base()), [0.0, 0.5, 0.55, 0.0, 1.3, 0.0])
        })
        .with("polycrank", |entry| {
            let start = [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2];
            set_up(entry, Polycrank::new().with_base(entry.base()), start)
        })
        .with("gripper", |entry| {
            let robot = Gripper::new().with_base(entry.base());
            let limits = robot.limits();
            // What is grasped keeps the fingers off their demand: that is no fault.
            let stroke: One = limits.upper - limits.lower;
            Ok(set_up(entry, robot, [0.07])?.following_error(stroke))
        })
        .with("conveyor", |entry| set_up(entry, Conveyor::new().with_base(entry.base()), [0.0]))
        .with("io-block", |entry| {
            let drives = IdealDrives::new(&IoBlock::new(), NoJoints::zeros(), BLOCK);
            Ok(RobotSetup::new(entry.name(), IoBlock::new(), drives))
        })
        .with_any("urdf", urdf)
}

/// The kinds `irp6`, `two-fingers` and `conveyor` in one simulated world: the arm may hold a body of it, the hand closes on what its pads
/// touch, and the conveyor's belt carries bodies, as `belt` says. A hand has `mounted_on = ".."`, its arm, and stands below that in the file.
///
/// They share the world, so all of them run in one process.
///
/// ```
/// use mrroc_robots::grasp::{Belt, World};
/// use mrroc_robots::simulated_in;
///
/// let kinds = simulated_in(&World::empty(), Belt::new(-0.5, 1.0, 0.3));
/// # let _ = kinds;
/// ```
#[must_use]
pub fn simulated_in(world: &World, belt: Belt) -> Kinds {
    simulated_in_with(world, belt, |_, _| ())
}

/// The same, where `arms` is shown the drives of each arm, under its name, before they go into the world: a camera that looks at the arm needs its
/// [shaft](Simulated::shaft).
#[must_use]
pub fn simulated_in_with(
    world: &World,
    belt: Belt,
    arms: impl Fn(&str, &Simulated<Irp6, 6>) + 'static,
) -> Kinds {
    /// What an arm holds yields by this [N/m, N m/rad].
    const GRASP: [f64; 2] = [2e4, 20.0];
    /// How wide a pad is, and how far it reaches beyond the origin of the tool frame \[m\].
    const PADS: [f64; 2] = [0.024, 0.008];
    let [carried, hands, belts] = [world.clone(), world.clone(), world.clone()];
    // The arms in the order in which they came into the world, by their names.
    let names = Rc::<RefCell<Vec<String>>>::default();
    let of_hands = Rc::clone(&names);
    Kinds::new()
        .meshes(drawn_mesh)
        .with("irp6", move |entry| {
            let robot = irp6(entry)?;
            let drives = Simulated::new(robot.clone(), &entry.start(&robot)?);
            arms(entry.name(), &drives);
            let [stiffness, rotational] = GRASP;
            let grasp = Grasp::new(stiffness, rotational).with_tool(entry.tool());
            let arm = carried.arm(drives, grasp).map_err(|error| impossible(entry, &error))?;
            names.borrow_mut().push(entry.name().to_owned());
            Ok(RobotSetup::new(entry.name(), robot, arm))
        })
        .with("two-fingers", move |entry| {
            let robot = TwoFingers::new().with_base(entry.base());
            let drive = Simulated::new(robot.clone(), &entry.start(&robot)?);
            let on = entry.mounted_on().and_then(|on| of_hands.borrow().iter().position(|name| name == on));
            let hand = on.and_then(|arm| hands.hand(arm)).ok_or_else(|| {
                entry.refuse_start(
                    "the hand is on no arm that comes before it".to_owned(),
                    "write it below its arm, with mounted_on = \"ARM\"".to_owned(),
                )
            })?;
            let [width, ahead] = PADS;
            let jaws = Jaws::new(drive, hand, Pads::new(width, ahead));
            let jaws = jaws.map_err(|error| impossible(entry, &error))?;
            // What it holds keeps the fingers off their demand: that is no fault.
            Ok(RobotSetup::new(entry.name(), robot, jaws).following_error(One::new(TwoFingers::STROKE)))
        })
        .with("conveyor", move |entry| {
            let robot = Conveyor::new().with_base(entry.base());
            let drive = Simulated::new(robot.clone(), &entry.start(&robot)?);
            let drive = belts.belt(drive, belt).map_err(|error| impossible(entry, &error))?;
            Ok(RobotSetup::new(entry.name(), robot, drive))
        })
}

fn impossible(entry: &RobotEntry, error: &WorldError) -> CellError {
    entry.refuse_start(error.to_string(), "write figures in range".to_owned())
}

/// The most bytes of a file with a calibration.
const MOST: u64 = 1 << 20;

/// The calibration that an entry names, if it names one, and its file.
fn calibration(entry: &RobotEntry) -> Result<Option<(ArmCalibration, PathBuf)>, CellError> {
    let Some(path) = entry.calibration() else { return Ok(None) };
    let mut text = String::new();
    let read = files::open(&path).and_then(|file| file.take(MOST).read_to_string(&mut text));
    if let Err(why) = read {
        let what = format!("{} cannot be read: {why}", path.display());
        return Err(entry.refuse(EntryKey::Calibration, what, CALIBRATE.to_owned()));
    }
    let parsed = ArmCalibration::parse(&text).map_err(|why| wrong_calibration(entry, &path, &why))?;
    Ok(Some((parsed, path)))
}

/// What to do about a calibration that is none.
const CALIBRATE: &str =
    "write the file that `calibrate` has made for this robot, as seen from the folder of this file";

fn wrong_calibration(entry: &RobotEntry, path: &Path, why: &NoCalibration) -> CellError {
    entry.refuse(EntryKey::Calibration, format!("{}: {why}", path.display()), CALIBRATE.to_owned())
}

/// An IRp-6 with its design dimensions, or those of its calibration.
fn irp6(entry: &RobotEntry) -> Result<Irp6, CellError> {
    let arm = Irp6::nominal().with_base(entry.base());
    match calibration(entry)? {
        None => Ok(arm),
        Some((ArmCalibration::Irp6(calibration), _)) => Ok(arm.calibrated_by(&calibration)),
        Some((ArmCalibration::Chain(_), path)) => {
            let why = NoCalibration("it is the calibration of a chain of joints, not of an irp6".to_owned());
            Err(wrong_calibration(entry, &path, &why))
        }
    }
}

/// The chain of a URDF that an entry names.
struct Described<'e> {
    path: PathBuf,
    urdf: UrdfText,
    base_link: String,
    tip: &'e str,
}

fn described(entry: &RobotEntry) -> Result<Described<'_>, CellError> {
    let path = entry.file()?;
    let tip = entry.tip()?;
    let refuse = |why: &UrdfError| refused(entry, &path, why);
    let urdf = UrdfText::read(&path).map_err(|why| refuse(&why))?;
    let base_link = match entry.base_link() {
        Some(link) => link.to_owned(),
        None => urdf.root().map_err(|why| refuse(&why))?,
    };
    Ok(Described { path, urdf, base_link, tip })
}

/// An arm read from a URDF, whose number of joints that file says.
fn urdf(entry: &RobotEntry) -> Result<AnySetup, CellError> {
    let described = described(entry)?;
    let Described { path, urdf, base_link, tip } = &described;
    let joints = urdf.joints(base_link, tip).map_err(|why| refused(entry, path, &why))?;
    match joints.len() {
        1 => serial::<1>(entry, &described),
        2 => serial::<2>(entry, &described),
        3 => serial::<3>(entry, &described),
        4 => serial::<4>(entry, &described),
        5 => serial::<5>(entry, &described),
        6 => serial::<6>(entry, &described),
        7 => serial::<7>(entry, &described),
        8 => serial::<8>(entry, &described),
        count => {
            let what = format!("the chain from `{base_link}` to `{tip}` has {count} joints that move");
            let help = "choose another `tip` or `base_link`: a robot has 1 to 8 of them".to_owned();
            Err(entry.refuse(EntryKey::Tip, what, help))
        }
    }
}

/// The arm of `N` joints that an entry's `file`, `base_link`, `tip` and `acceleration` describe, at its `base`: for kinds of
/// arms that a URDF describes, and whose drives are real.
///
/// # Errors
/// What is wrong with them, at the key that can mend it.
pub fn urdf_arm<const N: usize>(entry: &RobotEntry) -> Result<Serial<N>, CellError> {
    arm(entry, &described(entry)?)
}

/// The arm of `N` joints with its simulated drives.
fn serial<const N: usize>(entry: &RobotEntry, described: &Described<'_>) -> Result<AnySetup, CellError> {
    let robot = arm::<N>(entry, described)?;
    let middle = (robot.limits().lower + robot.limits().upper) * 0.5;
    set_up(entry, robot, middle.into()).map(AnySetup::from)
}

fn arm<const N: usize>(entry: &RobotEntry, described: &Described<'_>) -> Result<Serial<N>, CellError> {
    let Described { path, urdf, base_link, tip } = described;
    let refuse = |why: &UrdfError| refused(entry, path, why);
    let builder = Serial::<N>::from_urdf(urdf.as_str(), base_link, tip).map_err(|why| refuse(&why))?;
    let given = entry.acceleration(N)?.map(|given| SVector::<f64, N>::from_column_slice(&given));
    let Some(acceleration) = given.or(builder.stated_acceleration()) else {
        let what =
            format!("robot `{}` has no `acceleration`, and {} states none", entry.name(), path.display());
        let help =
            format!("write acceleration = [..], the largest one of each of its {N} joints [rad/s² or m/s²]");
        return Err(entry.refuse(EntryKey::Acceleration, what, help));
    };
    let robot = builder.with_acceleration(acceleration).map_err(|why| refuse(&why))?;
    let robot = robot.with_base(entry.base());
    let robot = match calibration(entry)? {
        None => robot,
        Some((ArmCalibration::Chain(calibration), path)) => {
            robot.calibrated_by(&calibration).map_err(|why| wrong_calibration(entry, &path, &why))?
        }
        Some((ArmCalibration::Irp6(_), path)) => {
            let why = NoCalibration("it is the calibration of an irp6, not of an arm of a URDF".to_owned());
            return Err(wrong_calibration(entry, &path, &why));
        }
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(robot.with_meshes(urdf.as_str(), base_link, tip, folder))
}

/// What is wrong with a URDF, at the key of the entry that can mend it.
fn refused(entry: &RobotEntry, path: &Path, why: &UrdfError) -> CellError {
    let file = path.display();
    let (key, what, help) = match why {
        UrdfError::File { why, .. } => (
            EntryKey::File,
            format!("{file} cannot be read: {why}"),
            match why.kind() == std::io::ErrorKind::InvalidData {
                true => "save it as plain text in UTF-8",
                false => "write the name of a URDF, as seen from the folder of this file",
            },
        ),
        UrdfError::NoSuchLink { role: "tip", .. } => {
            (EntryKey::Tip, format!("{file}: {why}"), "write the link that is the flange")
        }
        UrdfError::NoSuchLink { .. } | UrdfError::NoRoot { .. } => (
            EntryKey::BaseLink,
            format!("{file}: {why}"),
            "write base_link = \"..\", the link that is the base",
        ),
        UrdfError::NotBelow { .. } | UrdfError::WrongCount { .. } | UrdfError::TooManyJoints { .. } => {
            (EntryKey::Tip, format!("{file}: {why}"), "write other links as `base_link` and `tip`")
        }
        UrdfError::AboveFile { .. } | UrdfError::BadCallerLimit { .. } => {
            (EntryKey::Acceleration, format!("{file}: {why}"), "write what the drives of the robot can do")
        }
        _ => (
            EntryKey::File,
            format!("{file}: {why}"),
            "mend the URDF, or choose a chain without this by `tip`",
        ),
    };
    entry.refuse(key, what, help.to_owned())
}

/// A robot with its simulated drives at the `start` of its entry; `example` is one that they can take.
fn set_up<const N: usize, R: Driven<N> + Kinematics<N>>(
    entry: &RobotEntry,
    robot: R,
    example: [f64; N],
) -> Result<RobotSetup<R>, CellError> {
    let start: SVector<f64, N> = entry.start(&robot)?;
    robot.check_coupled(&start, &start, 1.0).map_err(|limit| {
        let CoupledLimit { joint, what, excess } = limit;
        let (Excess { actual, limit, unit }, allowed) = (excess, excess.allowed());
        let space = if unit.is_empty() { "" } else { " " };
        let what = format!(
            "the drives cannot take this `start`: joint {}: {what} {actual:.4}{space}{unit}, {allowed} {limit:.4}{space}{unit}",
            joint + 1
        );
        entry.refuse_start(what, format!("write joint positions that they can take, such as {example:?}"))
    })?;
    let massless = || {
        let what = format!("no masses are known of the links of robot `{}`", entry.name());
        entry.refuse(
            EntryKey::Coupled,
            what,
            "leave it out, or give the links of its URDF an <inertial>".to_owned(),
        )
    };
    if entry.is_homed() {
        let drives = match entry.is_coupled() {
            true => Simulated::coupled(robot.clone(), &start).ok_or_else(massless)?,
            false => Simulated::new(robot.clone(), &start),
        };
        return Ok(RobotSetup::new(entry.name(), robot, drives));
    }
    let hidden = hidden(&robot, &start, entry.name());
    let drives = match entry.is_coupled() {
        true => Unhomed::coupled(robot.clone(), &hidden).ok_or_else(massless)?,
        false => Unhomed::new(robot.clone(), &hidden),
    };
    Ok(RobotSetup::unhomed(entry.name(), robot, drives))
}

/// A place near `start` that the file does not tell: every motor up to half a turn from there, by the robot's name.
fn hidden<const N: usize, R: Driven<N> + Kinematics<N>>(
    robot: &R,
    start: &SVector<f64, N>,
    name: &str,
) -> SVector<f64, N> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut aside = || {
        // FNV-1a, once around the name for each motor.
        for byte in name.bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        PI * (2.0 * ((hash >> 11) as f64 / (1_u64 << 53) as f64) - 1.0)
    };
    let motors = robot.motors(start);
    let aside = SVector::from_fn(|_, _| aside());
    let there = |sign: f64| robot.shafts(&(motors + aside * sign), &SVector::zeros()).joints.position;
    [1.0, -1.0].into_iter().map(there).find(|q| robot.is_attainable(q)).unwrap_or(*start)
}
