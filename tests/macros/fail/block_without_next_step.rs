//! A block holds no `next_step`.
//! says: `fn next_step(&mut self, t: Tick) -> Step<R>`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
impl Line {
    fn step(&mut self) -> Step<Rnt> {
        Step::Done
    }
}

fn main() {
    let _ = Line.step();
    let _ = ecp().move_robot((), Line);
}
