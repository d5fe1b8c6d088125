//! A block's first step is named in the attribute.
//! says: `fn first_step(&mut self, ..)`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

fn begin(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

#[generator(ecp, first = begin)]
impl Line {
    fn next_step(&mut self) -> Step<Rnt> {
        Step::Done
    }
}

fn main() {
    let _ = (begin(&mut Line), Line.next_step());
    let _ = ecp().move_robot((), Line);
}
