//! The cell: arm, touch probe, programs; and a run of it under the virtual clock.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::RunReport;
use mrroc::observe::Shown;
use mrroc::prelude::*;
use mrroc_robots::{Irp6, Shaft, SimulatedIrp6};
use nalgebra::Translation3;

use crate::deviation::{Corners, Deviation};
use crate::drawing::{Drawing, Vec2};
use crate::ecp::{Activity, Job, PROBE_HEIGHT, travel_height};
use crate::execution::{Execution, Instruments};
use crate::layout::{HEIGHT_ERROR, Layout, OutOfReach};
use crate::mp::coordinate;
use crate::placement::Plate;
use crate::plate::{Cutter, HeightMap};
use crate::probe::PlateSurface;
use crate::sampling::Sampling;
use crate::trace::Trace;

/// Size of a cell of the plate's height map \[mm\].
const CELL: f64 = 0.05;
/// How far the recorded path may leave the executed one \[mm\].
const TRACE_TOLERANCE: f64 = 0.002;

/// What may be chosen for a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The step \[s\], a multiple of the arm's servo period of 2 ms or an even part of it.
    pub step: f64,
    /// Feed along the strokes whose file says none [mm/s], > 0.
    pub feed: f64,
    /// Depth of the strokes whose file says no heights \[mm\], > 0.
    pub depth: f64,
    /// The cutter.
    pub cutter: Cutter,
}

/// What came of a run.
pub struct Outcome {
    /// Steps and simulated time.
    pub report: RunReport,
    /// What was measured.
    pub execution: Execution,
    /// Where the probe found the plate, over the promised height \[m\].
    pub height_found: Option<f64>,
}

/// Checks that the arm reaches every point of the drawing, which has been sunk, at all heights that it will take there.
///
/// # Errors
/// The first place that it does not reach.
pub fn check_reach(
    layout: &Layout,
    plate: &Plate,
    drawing: &Drawing,
    sampling: &Sampling,
) -> Result<u64, OutOfReach> {
    layout.joints(Vec2::new(plate.width / 2.0, plate.height / 2.0), PROBE_HEIGHT)?;
    let mut samples = 0;
    for sample in sampling.samples(drawing) {
        samples += 1;
        let travel = travel_height(drawing.strokes[sample.stroke].manner());
        for height in [travel + 0.002, sample.position.z * 1e-3 - 0.004] {
            layout.joints(sample.position.xy(), height)?;
        }
    }
    Ok(samples)
}

/// What a cell is put together from.
struct Parts {
    arm: RobotSetup<Irp6>,
    probe: PlateSurface,
    /// What the arm truly does, and what it is at: for those who look on.
    shaft: Shaft,
    activity: Shown<Activity>,
    /// `X_WP` of the plate's true surface.
    surface: Pose,
}

impl Parts {
    fn new(
        layout: &Layout,
        plate: &Plate,
        drawing: &Drawing,
        sampling: Sampling,
        settings: Settings,
    ) -> Parts {
        let surface =
            Pose::from_parts(Translation3::new(0.0, 0.0, HEIGHT_ERROR), Default::default()) * layout.plate;
        let drives = SimulatedIrp6::new(layout.arm.clone(), &layout.park);
        let shaft = drives.shaft();
        let activity = Shown::new(Activity::default());
        let mut job = Job {
            drawing: drawing.clone().sunk(settings.depth),
            sampling,
            plate: layout.plate,
            middle: Vec2::new(plate.width / 2.0, plate.height / 2.0),
            orientation: layout.orientation,
            feed: settings.feed * 1e-3,
            step: settings.step,
            park: layout.park,
            activity: activity.clone(),
        };
        let probe = PlateSurface::new(layout.arm.clone(), layout.tool, shaft.clone(), surface.translation.z);
        let arm = RobotSetup::new("irp6", layout.arm.clone(), drives)
            .tool(layout.tool)
            .shows(&activity)
            .program(move |ecp| job.run(ecp));
        Parts { arm, probe, shaft, activity, surface }
    }

    fn cell(self, step: f64) -> Cell {
        Cell::new(Duration::from_secs_f64(step))
            .prefer_real_time()
            .robot(self.arm)
            .sensor(SensorSetup::new("probe", self.probe).of("irp6"))
            .program(coordinate)
    }
}

/// The cell without instruments.
#[must_use]
pub fn cell(
    layout: &Layout,
    plate: &Plate,
    drawing: &Drawing,
    sampling: Sampling,
    settings: Settings,
) -> Cell {
    Parts::new(layout, plate, drawing, sampling, settings).cell(settings.step)
}

/// What looks at a run: it sees the arm where its simulated drives are, on the memory link or in the plant.
pub struct Watch {
    execution: Rc<RefCell<Execution>>,
    activity: Shown<Activity>,
    /// Height that the plate was promised to have [m, world].
    promised: f64,
}

impl Watch {
    /// The cell with instruments.
    #[must_use]
    pub fn over(
        layout: &Layout,
        plate: &Plate,
        drawing: &Drawing,
        sampling: Sampling,
        settings: Settings,
    ) -> (Cell, Watch) {
        let mut parts = Parts::new(layout, plate, drawing, sampling, settings);
        let activity = parts.activity.clone();
        let execution = Rc::new(RefCell::new(Execution::new(
            layout.arm.clone(),
            parts.shaft.clone(),
            activity.clone(),
            &parts.surface,
            Instruments {
                deviation: Deviation::new(&drawing.clone().sunk(settings.depth), &sampling, Corners::Counted),
                surface: HeightMap::new(plate, CELL, settings.cutter),
                trace: Trace::new(TRACE_TOLERANCE),
            },
        )));
        parts.arm = parts.arm.observe(Execution::observer(&execution));
        (parts.cell(settings.step), Watch { execution, activity, promised: layout.plate.translation.z })
    }

    /// Length of the path in the material so far \[mm\].
    pub fn progress(&self) -> impl Fn() -> f64 + 'static {
        let execution = Rc::clone(&self.execution);
        move || execution.borrow().cut_length
    }

    /// What came of a run that took so long. The cell is gone.
    ///
    /// # Panics
    /// When the cell, or what tells the [`progress`](Watch::progress) of it, is still there.
    #[must_use]
    pub fn outcome(self, report: RunReport) -> Outcome {
        let height_found = self.activity.get().plate_height().map(|height| height - self.promised);
        let execution = Rc::into_inner(self.execution).map(RefCell::into_inner);
        let mut execution = execution.expect("the cell has dropped its observer");
        execution.surface.finish();
        Outcome { report, execution, height_found }
    }
}

/// Engraves the drawing on the memory link. `on_step` is called at the start of every step with its index and the length of
/// the path in the material so far \[mm\].
///
/// # Errors
/// The first cause when the run ends with a fault.
pub fn engrave(
    layout: &Layout,
    plate: &Plate,
    drawing: &Drawing,
    sampling: Sampling,
    settings: Settings,
    mut on_step: impl FnMut(u64, f64) + 'static,
) -> Result<Outcome, CellError> {
    let (cell, watch) = Watch::over(layout, plate, drawing, sampling, settings);
    let progress = watch.progress();
    let report = cell.on_step(move |step, _| on_step(step, progress())).run()?;
    Ok(watch.outcome(report))
}
