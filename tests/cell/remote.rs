//! The task program of the test of slow controllers: two robots that pace themselves, of which one answers long after the
//! other, and breaks off when it is told nothing for too long; and a camera that takes its time, too.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use mrroc::cell_file::Kinds;
use mrroc::fault::FaultKind;
use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, IdealDrives, Measured, Pace, Pulse, RobotStop, StopCause};
use mrroc_robots::{Gripper, One};
use mrroc_tests::fixture::{NOT_TOLD, OPENED, RECORDS, SILENT};

use crate::Nothing;

/// The period of these controllers.
const PERIOD: Duration = Duration::from_millis(2);

/// For how long they may be told nothing: less than the other one takes to answer.
const TIMEOUT: Duration = Duration::from_millis(400);

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    mrroc::launch(cell, Nothing)
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let kinds = Kinds::new().with("remote", |entry| {
        let gripper = Gripper::new();
        // The second robot of the file answers late.
        let answers = Duration::from_millis(if entry.name() == "late" { 1000 } else { 50 });
        let drives = IdealDrives::new(&gripper, One::new(0.07), PERIOD);
        Ok(RobotSetup::new(entry.name(), gripper, Remote { drives, answers, told: None, count: 0 }))
    });
    let camera = file.sensor("camera", Camera { frames: 0 })?;
    Ok(file.cell(&kinds)?.sensor(camera).program(|mp| {
        let (mut soon, mut late) = (mp.robot("soon")?, mp.robot("late")?);
        let mut camera = mp.sensor::<Seen>("camera")?;
        mp.move_robots((&mut soon, &mut late), (&mut camera,), Stay(200)).map(drop)
    }))
}

/// What the camera sees: how many frames it has taken.
pub struct Seen;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Frames {
    frames: u64,
}

impl Sensor for Seen {
    const KIND: &'static str = "frames";
    type Reading = Frames;
    type Configuration = ();
}

/// A camera that only one process may open: it writes down who does.
struct Camera {
    frames: u64,
}

impl VirtualSensor for Camera {
    type Kind = Seen;

    fn hardware(&self) -> Option<String> {
        // Of this folder, so that tests of other folders have others.
        std::env::current_dir().ok().map(|folder| format!("camera {}", folder.display()))
    }

    fn open(&mut self) -> Result<(), Fault> {
        std::thread::sleep(Duration::from_millis(300));
        let folder = own_option(RECORDS).map(PathBuf::from).unwrap_or_default();
        let opened = OpenOptions::new().create(true).append(true).open(folder.join(OPENED));
        let noted = opened.and_then(|mut file| writeln!(file, "{}", std::process::id()));
        noted.map_err(|error| Fault::new(FaultKind::SensorFailed).text(&error.to_string()))?;
        self.frames = 1;
        Ok(())
    }

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Frames, Fault> {
        if self.frames == 0 {
            return Err(Fault::thrown("it has not been opened"));
        }
        self.frames += 1;
        Ok(Frames { frames: self.frames })
    }
}

/// Both robots stay where they are for so many steps.
struct Stay(u32);

#[generator(mp)]
fn stay(s: &mut Stay, v: &Reading<(Seen,)>) -> Step<(Gripper, Gripper)> {
    assert!(v.0.reading().is_some_and(|seen| seen.frames > 1), "it runs before the first step");
    let Some(left) = s.0.checked_sub(1) else { return Step::Done };
    s.0 = left;
    Step::Next((Demand::hold(), Demand::hold()))
}

struct Remote {
    drives: IdealDrives<Gripper>,
    /// How long the controller takes to answer.
    answers: Duration,
    /// When it began, and when it was told something last.
    told: Option<(Instant, Instant)>,
    count: u64,
}

impl Driver<Gripper> for Remote {
    fn period(&self) -> Duration {
        PERIOD
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: Duration::from_secs(2) }
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let (began, told) = self.told.ok_or(DriveFault::NoAnswer)?;
        if told.elapsed() > TIMEOUT {
            return Err(RobotStop::new(StopCause::CommunicationLost).named(NOT_TOLD).into());
        }
        let count = (began.elapsed().as_nanos() / PERIOD.as_nanos()) as u64;
        let is_new = count > core::mem::replace(&mut self.count, count);
        Ok(is_new.then_some(Pulse { count, age: Duration::ZERO }))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        if own_option(SILENT).is_some() {
            let folder = own_option(RECORDS).map(PathBuf::from).unwrap_or_default();
            std::fs::write(folder.join(SILENT), "it is called\n").map_err(|_| DriveFault::NoAnswer)?;
            loop {
                std::thread::park();
            }
        }
        std::thread::sleep(self.answers);
        self.told = Some((Instant::now(), Instant::now()));
        Ok(())
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.drives.measured()
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        if let Some((_, told)) = &mut self.told {
            *told = Instant::now();
        }
        self.drives.tick(demanded)
    }
}
