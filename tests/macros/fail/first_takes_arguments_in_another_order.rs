//! The first step takes its arguments in another order.
//! says: in this order

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp, first = begin)]
fn line(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

fn begin(_: &mut Line, _: Tick, _: &State<Rnt>) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
