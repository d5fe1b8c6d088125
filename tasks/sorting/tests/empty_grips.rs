//! Hands that close, and have nothing between their pads any more: the programs know, open them, and say how often; three times in a row
//! stop the cell.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::observe::Observation;
use mrroc::prelude::*;
use mrroc_robots::grasp::World;
use sorting::camera::run as recognising;
use sorting::camera::settings::{Overhead, Settings as Recognising};
use sorting::monitor::Fate;
use sorting::places::CLOSED;
use sorting::plant;
use sorting::run::Settings;

/// Numbers of the parts that were taken out of a hand.
type Away = Rc<RefCell<Vec<usize>>>;

/// So long after the hand has closed on it is a part taken away \[s\]: one that is lost while the hand closes is let pass.
const LATER: f64 = 0.1;

/// The cell, in which each of these parts is taken out of a hand that has closed on it, and counted with those over the end of the belt.
fn taking_away(cell: Cell, world: &World, (parts, end): (&'static [usize], usize)) -> (Cell, Away) {
    let away = Away::default();
    let (noted, world) = (away.clone(), world.clone());
    let mut closed = [f64::INFINITY; 2];
    let observer = move |observation: &Observation<'_>| {
        let Some(arm) = ["hand", "hand-2"].iter().position(|hand| *hand == observation.robot) else { return };
        let is_closed = observation.demanded[0] < CLOSED + 2e-4;
        closed[arm] = if is_closed { closed[arm].min(observation.time) } else { f64::INFINITY };
        let touch = world.hand(arm).and_then(|hand| hand.gripped());
        let Some(touch) = touch.filter(|_| observation.time - closed[arm] > LATER) else { return };
        if parts.contains(&touch.body) && !noted.borrow().contains(&touch.body) {
            assert!(world.take_away(touch.body, end), "{} is there", touch.body);
            noted.borrow_mut().push(touch.body);
        }
    };
    (cell.watch(observer), away)
}

/// What came of a run, whichever sensors it had.
struct Run {
    fault: Option<String>,
    fates: Vec<Fate>,
    failed: u32,
    crashes: u32,
    away: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
enum By {
    Infrared,
    Overhead(Overhead, usize),
}

/// By each sensor, and by two arms: the second one takes nothing where the first one has time for all.
const ALL: [By; 4] = [
    By::Infrared,
    By::Overhead(Overhead::Camera, 1),
    By::Overhead(Overhead::Matrix, 1),
    By::Overhead(Overhead::Camera, 2),
];

fn run(by: By, count: usize, parts: &'static [usize]) -> Run {
    let text = |report: Result<_, CellError>| report.err().map(|error| error.to_string());
    match by {
        By::Infrared => {
            let mut ready = Settings { parts: count, ..Settings::one(0.1, 5) }.ready().expect("a cell");
            let (cell, away) = taking_away(ready.cell, &ready.plant.world, (parts, plant::END_BIN));
            ready.cell = cell;
            let outcome = ready.run();
            let away = away.take();
            let (fates, failed, crashes) = (outcome.fates, outcome.failed, outcome.crashes);
            Run { fault: text(outcome.report.map(drop)), fates, failed, crashes, away }
        }
        By::Overhead(overhead, arms) => {
            let settings = Recognising::of(0.1, count, 13.3, 5).below(overhead).by(arms);
            let mut ready = settings.ready().expect("a cell");
            let (cell, away) = taking_away(ready.cell, &ready.plant.world, (parts, recognising::END_BIN));
            ready.cell = cell;
            let outcome = ready.run();
            let away = away.take();
            let (fates, failed, crashes) = (outcome.fates, outcome.failed, outcome.crashes);
            Run { fault: text(outcome.report.map(drop)), fates, failed, crashes, away }
        }
    }
}

#[test]
fn fault_340_a_hand_that_has_closed_on_nothing_is_opened_and_the_next_part_is_taken() {
    // Never three in a row.
    const AWAY: &[usize] = &[0, 1, 3];
    for by in ALL {
        let Run { fault, fates, failed, crashes, away } = run(by, 5, AWAY);
        assert_eq!((fault, crashes, away.as_slice()), (None, 0, AWAY), "{by:?}");
        let wanted: Vec<_> =
            (0..5).map(|part| if AWAY.contains(&part) { Fate::Missed } else { Fate::Sorted }).collect();
        assert_eq!((failed, fates), (3, wanted), "{by:?}");
    }
}

#[test]
fn fault_340_a_hand_that_has_closed_on_nothing_three_times_in_a_row_stops_the_cell_with_the_cause() {
    for by in ALL {
        let Run { fault, failed, away, .. } = run(by, 5, &[1, 2, 3]);
        let fault = fault.expect("the cell stops");
        assert!(fault.contains("the hand has closed on nothing three times in a row"), "{by:?}: {fault}");
        assert_eq!((failed, away), (3, vec![1, 2, 3]), "{by:?}");
    }
}
