//! Sweeps of the worked tasks: two arms that carry a bar, and an arm that engraves a text.

use std::time::Duration;

use engraving::drawing::hershey::Font;
use engraving::drawing::{Drawing, Vec2};
use engraving::ecp::{Activity, Job};
use engraving::layout::{HEIGHT_ERROR, Layout};
use engraving::placement::{Plate, Sizing, place};
use engraving::probe::PlateSurface;
use engraving::sampling::Sampling;
use mrroc::observe::Shown;
use mrroc::prelude::*;
use mrroc::testing::{LinkFault, Press, Sweep};
use mrroc_robots::SimulatedIrp6;

/// The transfer's arms and hands, with nothing between them and without the guard, which has tests of its own.
pub fn transfer() -> Cell {
    transfer_of(&transfer::file().expect("in order"))
}

/// The same of this file.
pub fn transfer_of(file: &CellFile) -> Cell {
    let cell = transfer::cell(file, &transfer::plant::drives()).expect("in order");
    cell.guard(u32::MAX, |_| Ok(())).program(transfer::mp::coordinate)
}

/// One small letter, engraved.
pub fn engraving() -> Cell {
    let plate = Plate { width: 12.0, height: 12.0, margin: 3.0 };
    let layout = Layout::new(&plate).expect("within reach");
    let drawing: Drawing =
        Font::open("futural").and_then(|font| font.write("i", 4.0)).expect("a text").drawing;
    let drawing = place(&drawing, &plate, Sizing::Natural).expect("it fits").drawing.sunk(0.3);
    let arm = SimulatedIrp6::new(layout.arm.clone(), &layout.park);
    let surface = layout.plate.translation.z + HEIGHT_ERROR;
    let probe = PlateSurface::new(layout.arm.clone(), layout.tool, arm.shaft(), surface);
    let mut job = Job {
        drawing,
        sampling: Sampling::default(),
        plate: layout.plate,
        middle: Vec2::new(plate.width / 2.0, plate.height / 2.0),
        orientation: layout.orientation,
        feed: 10e-3,
        step: 2e-3,
        park: layout.park,
        activity: Shown::new(Activity::default()),
    };
    let irp6 = RobotSetup::new("irp6", layout.arm, arm).tool(layout.tool).program(move |ecp| job.run(ecp));
    Cell::new(Duration::from_millis(2))
        .robot(irp6)
        .sensor(SensorSetup::new("probe", probe).of("irp6"))
        .program(engraving::mp::coordinate)
}

/// Steps for which a task that goes on after a fault is watched.
const WATCHED: u64 = 500;

/// Processes that are killed, stalled, and links at fault, each in another one of `every` steps.
pub fn task(cell: fn() -> Cell, every: u64) -> Sweep<'static> {
    let sweep = Sweep::new(cell).every(every).threads(2).forking(WATCHED).kills().stalls(3).stalls(30);
    let links =
        [(LinkFault::Drop, 1), (LinkFault::Delay(2), 2), (LinkFault::Corrupt, 1), (LinkFault::Forge, 1)];
    let sweep = links.into_iter().fold(sweep, |sweep, (fault, steps)| sweep.links(fault, steps));
    sweep.presses(Press::Abort).presses(Press::SuspendAndResume(150))
}

#[test]
fn a_process_that_is_killed_in_either_task_leaves_all_robots_standing_within_the_bound() {
    for (cell, every) in [(transfer as fn() -> Cell, 7919), (engraving as fn() -> Cell, 3989)] {
        let report = Sweep::new(cell).every(every).kills().threads(2).forking(WATCHED).run();
        println!("{report}");
        assert!(report.is_clean() && report.total().stopped > 0, "{report}");
    }
}

#[test]
#[ignore = "takes minutes, or hours: `just sweep-tasks`"]
fn every_fault_in_a_share_of_the_steps_of_the_engraving_and_of_the_transfer_breaks_no_promise() {
    let every = std::env::var("MRROC_EVERY").expect("`just sweep-tasks` sets MRROC_EVERY");
    let every = every.parse().expect("MRROC_EVERY is a number");
    for (name, cell) in [("engraving", engraving as fn() -> Cell), ("transfer", transfer)] {
        let report = task(cell, every).run();
        println!("{name}: each fault in every {every}th step\n{report}");
        assert!(report.is_clean(), "{report}");
    }
}
