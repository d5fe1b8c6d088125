//! The task program of the soak: both arms turn to and fro, coordinated tightly, by what a sensor sees of one of them.
//!
//! Its MP keeps count of its own steps and writes them down at the end.

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::Instant;

use mrroc::launch::own_option;
use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_robots::Irp6;
use mrroc_tests::fixture::{COUNT, RECORDS, SECONDS};
use mrroc_tests::{Follow, Turned};

use crate::Nothing;

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    mrroc::launch(cell, Nothing)
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let mut count = Count::new(file.step().as_secs_f64());
    let cell = file
        .cell(&mrroc_robots::simulated())?
        .sensor(file.sensor("column", Looking)?)
        .ecp("left", arm)
        .ecp("right", arm)
        .program(coordinate);
    Ok(cell.on_step(move |step, _: &Operator| count.note(step)))
}

/// Steps in a row that a cell of 1 ms goes on without.
const BUDGET: u64 = 20;

/// Steps of the MP as it begins them.
struct Count {
    /// The period \[s\].
    period: f64,
    began: Option<(Instant, u64)>,
    last: u64,
    begun: u64,
    skipped: u64,
    /// How late the least late of the first and of the last [`LOOKED_AT`] steps were \[s\], and when \[s\].
    first: (f64, f64),
    recent: Vec<(f64, f64)>,
}

/// Steps at either end whose least late one tells the rate: others are late by chance.
const LOOKED_AT: usize = 1000;

impl Count {
    fn new(period: f64) -> Count {
        let recent = Vec::with_capacity(LOOKED_AT);
        Count { period, began: None, last: 0, begun: 0, skipped: 0, first: (f64::INFINITY, 0.0), recent }
    }

    fn note(&mut self, step: u64) {
        let now = Instant::now();
        let (began, origin) = *self.began.get_or_insert((now, step));
        if self.begun > 0 {
            // In longer times the cell was stopped.
            let missed = step - self.last - 1;
            self.skipped += if missed <= BUDGET { missed } else { 0 };
        }
        (self.last, self.begun) = (step, self.begun + 1);
        let time = (now - began).as_secs_f64();
        let late = (time - (step - origin) as f64 * self.period, time);
        let place = (self.begun as usize - 1) % LOOKED_AT;
        if self.begun as usize <= LOOKED_AT {
            self.recent.push(late);
            if late.0 < self.first.0 {
                self.first = late;
            }
        } else {
            self.recent[place] = late;
        }
    }
}

impl Drop for Count {
    /// In the MP's process alone there is anything to tell.
    fn drop(&mut self) {
        let Some(folder) = own_option(RECORDS).filter(|_| self.begun > 0) else { return };
        let last = self.recent.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        // Slow by so much of its time.
        let slow = (last.0 - self.first.0) / (last.1 - self.first.1);
        let text = format!("{} {} {slow:e}\n", self.begun, self.skipped);
        let _ = fs::write(PathBuf::from(folder).join(COUNT), text);
    }
}

/// Where an arm's column is.
struct Column;

impl Sensor for Column {
    const KIND: &'static str = "column";
    type Reading = Angle;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Angle {
    /// \[rad\].
    column: f64,
}

struct Looking;

impl VirtualSensor for Looking {
    type Kind = Column;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Angle, Fault> {
        Ok(Angle { column: order.robot.map_or(0.0, |robot| robot.joints[0]) })
    }
}

fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let mut column = mp.sensor::<Column>("column")?;
    // After a reset the program begins anew; its time does not.
    static BEGAN: OnceLock<Instant> = OnceLock::new();
    let passed = BEGAN.get_or_init(Instant::now).elapsed().as_secs_f64();
    let seconds = own_option(SECONDS).and_then(|seconds| seconds.parse().ok()).unwrap_or(10.0_f64);
    let swing = Swing { t: 0.0, end: (seconds - passed).max(1.0) };
    mp.move_robots((&mut left, &mut right), (&mut column,), swing)?;
    Ok(())
}

/// Both columns to and fro, against each other; the reading makes a difference of its own.
struct Swing {
    t: f64,
    end: f64,
}

/// Amplitude \[rad\] and angular frequency [rad/s] of the swing: slow enough for a machine that is late.
const AMPLITUDE: f64 = 0.02;
const FREQUENCY: f64 = 0.6;

#[generator(mp)]
fn swing(c: &mut Swing, v: &Reading<(Column,)>, t: Tick) -> Step<(Irp6, Irp6), Turned> {
    if c.t >= c.end {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(c.end);
    let seen = v.0.reading().map_or(0.0, |reading| 1e-9 * reading.column);
    // From rest.
    let by = AMPLITUDE * (1.0 - (FREQUENCY * c.t).cos()) + seen;
    Step::Next((Turned { by }, Turned { by: -by }))
}

fn arm(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    ecp.serve(|ecp, _: Turned| ecp.move_robot((), Follow::from_here()).map(drop))
}
