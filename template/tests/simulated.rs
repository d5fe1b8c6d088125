//! The whole task under the virtual clock: the same demands to the bit in every run, as fast as the processor goes.

use std::cell::Cell;
use std::rc::Rc;

use mrroc::cell_file::CellFile;

#[test]
fn the_task_runs_to_its_end() {
    let file = CellFile::read("cell.toml").expect("cell.toml is in order");
    let cell = task::cell(&file).expect("the programs fit cell.toml");
    let cell = cell.simulated().expect("simulated drives stand in for real ones");
    let (lowest, highest) = (Rc::new(Cell::new(f64::INFINITY)), Rc::new(Cell::new(f64::NEG_INFINITY)));
    let (low, high) = (Rc::clone(&lowest), Rc::clone(&highest));
    let cell = cell.watch(move |robot| {
        let mut height = 0.0;
        robot.frames(&mut |frame| height = frame.translation.z); // the tool's comes last
        low.set(low.get().min(height));
        high.set(high.get().max(height));
    });
    cell.run().expect("no fault");
    let risen = highest.get() - lowest.get();
    // FILL IN: what must be true of your task.{% if task == "empty" %}
    assert!(risen < 0.2, "nothing may move far: {risen} m"); // of any robot{% else %}
    assert!((risen - 0.1).abs() < 0.001, "the tool rises by 0.1 m, not {risen} m"); // and comes back{% endif %}
}
