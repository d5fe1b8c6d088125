//! A method takes its state by value.
//! says: `&mut self`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
impl Line {
    fn next_step(self) -> Step<Rnt> {
        Step::Done
    }
}

fn main() {
    let _ = Line.next_step();
    let _ = ecp().move_robot((), Line);
}
