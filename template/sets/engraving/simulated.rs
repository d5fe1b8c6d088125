//! The whole task under the virtual clock: the same demands to the bit in every run, as fast as the processor goes.

use std::cell::Cell;
use std::rc::Rc;

use mrroc::cell_file::CellFile;
use task::generators::DEPTH;
use task::touch::TABLE;

#[test]
fn the_curve_is_engraved_as_deep_as_it_should_be() {
    let file = CellFile::read("cell.toml").expect("cell.toml is in order");
    let cell = task::cell(&file).expect("the programs fit cell.toml");
    let cell = cell.simulated().expect("simulated drives stand in for real ones");
    let lowest = Rc::new(Cell::new(f64::INFINITY));
    let low = Rc::clone(&lowest);
    let cell = cell.watch(move |robot| {
        let mut height = 0.0;
        robot.frames(&mut |frame| height = frame.translation.z); // the tool's comes last
        low.set(low.get().min(height));
    });
    cell.run().expect("no fault");
    // FILL IN: what must be true of your task.
    let depth = TABLE - lowest.get();
    assert!((depth - DEPTH).abs() < 1e-4, "engraved {depth} m deep");
}
