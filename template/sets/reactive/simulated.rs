//! The whole task under the virtual clock: the same demands to the bit in every run, as fast as the processor goes.

use std::cell::Cell;
use std::rc::Rc;

use mrroc::cell_file::CellFile;
use task::mp::PLACES;
use task::touch::POST;

#[test]
fn the_robot_gets_to_all_places_and_does_not_touch_the_post() {
    let file = CellFile::read("cell.toml").expect("cell.toml is in order");
    let cell = task::cell(&file).expect("the programs fit cell.toml");
    let cell = cell.simulated().expect("simulated drives stand in for real ones");
    let nearest = Rc::new(Cell::new([f64::INFINITY; 3])); // to each place, and to the post [m]
    let seen = Rc::clone(&nearest);
    let cell = cell.watch(move |robot| {
        let mut tool = [0.0; 2];
        robot.frames(&mut |frame| tool = [frame.translation.x, frame.translation.y]); // the tool's comes last
        let far = |x: f64, y: f64| (tool[0] - x).hypot(tool[1] - y);
        let [one, two] = PLACES.map(|[x, y]| far(x, y));
        let [a, b, c] = seen.get();
        seen.set([a.min(one), b.min(two), c.min(far(POST[0], POST[1]) - POST[2])]);
    });
    cell.run().expect("no fault");
    // FILL IN: what must be true of your task.
    let [one, two, gap] = nearest.get();
    assert!(one < 2e-3 && two < 2e-3, "as near to the places as {one} m and {two} m");
    assert!(gap > 0.0 && gap < 0.025, "the tool went around the post, {gap} m beside it");
}
