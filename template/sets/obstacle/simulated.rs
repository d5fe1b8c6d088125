//! The whole task under the virtual clock: the same demands to the bit in every run, as fast as the processor goes.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use mrroc::cell_file::CellFile;
use mrroc_robots::clearance::DryRun;
use task::mp::PLACES;
use task::world::{MARGIN, known};

#[test]
fn the_tool_gets_to_all_places_and_the_arm_keeps_its_margin() {
    let file = CellFile::read("cell.toml").expect("cell.toml is in order");
    let cell = task::cell(&file).expect("the programs fit cell.toml");
    let cell = cell.simulated().expect("simulated drives stand in for real ones");
    let run = Rc::new(RefCell::new(DryRun::new(known(&file).expect("a world").1)));
    let nearest = Rc::new(Cell::new([f64::INFINITY; PLACES.len()])); // to each place [m]
    let (seen, places) = (Rc::clone(&run), Rc::clone(&nearest));
    let cell = cell.watch(move |robot| {
        let mut tool = [0.0; 3];
        robot.frames(&mut |frame| tool = frame.translation.vector.into()); // the tool's comes last
        let far = |[x, y, z]: [f64; 3]| (tool[0] - x).hypot(tool[1] - y).hypot(tool[2] - z);
        let before = places.get();
        places.set(std::array::from_fn(|i| before[i].min(far(PLACES[i]))));
        seen.borrow_mut().observe(robot);
    });
    cell.run().expect("no fault");
    // FILL IN: what must be true of your task.
    assert!(nearest.get().iter().all(|far| *far < 2e-3), "as near to the places as {:?} m", nearest.get());
    let mut run = run.borrow_mut();
    let closest = run.closest().expect("postures").expect("the arm was seen");
    // Encoders round where simulated drives stand, by less than 0.1 mm.
    assert!(closest.nearest.distance > MARGIN - 1e-4, "{} at {} s", closest.nearest, closest.time);
}
