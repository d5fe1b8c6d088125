//! Two methods of a block read different orders.
//! says: `&Order<Phase>`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
impl Line {
    fn first_step(&mut self, order: &Order<Phase>) -> Step<Rnt> {
        let _ = order;
        Step::Done
    }

    fn next_step(&mut self, order: &Order<Displacement>) -> Step<Rnt> {
        let _ = order;
        Step::Done
    }
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
