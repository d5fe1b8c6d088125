//! A semicolon takes the step away.
//! says: remove this semicolon

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
fn line(_: &mut Line) -> Step<Rnt> {
    Step::<Rnt>::Next(Demand::hold());
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
