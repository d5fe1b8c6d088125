//! The whole task under the virtual clock: the same demands to the bit in every run, as fast as the processor goes.

use mrroc::cell_file::CellFile;
use task::belt::Shown;

#[test]
fn the_first_part_comes_into_the_tray() {
    let file = CellFile::read("cell.toml").expect("cell.toml is in order");
    let shown = Shown::default();
    let cell = task::cell(&file, &shown).expect("the programs fit cell.toml");
    cell.run().expect("no fault");
    // FILL IN: what must be true of your task.
    let line = shown.borrow();
    let world = line.as_ref().expect("a cell was made").world();
    assert_eq!((world.taken(0), world.taken(1)), (1, 0), "in the tray, and on the floor");
    assert_eq!(world.hand(0).expect("an arm").crashes(), 0, "no finger came down on a part");
}
