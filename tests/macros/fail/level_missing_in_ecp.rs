//! The attribute of an ECP's motion names no level.
//! says: `#[generator(ecp)]`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator]
fn line(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
