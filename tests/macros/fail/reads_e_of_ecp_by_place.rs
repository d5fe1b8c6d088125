//! An ECP reads the state of its robot as if it were a list.

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
fn line(_: &mut Line, e: &State<Rnt>) -> Step<Rnt> {
    let _ = e.0.demanded().joints;
    Step::Done
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
