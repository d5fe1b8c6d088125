//! The attribute stands over the implementation of a trait.
//! says: `impl Carry { .. }`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

trait Steps {
    fn next_step(&mut self) -> Step<(Rnt,)>;
}

#[generator(mp)]
impl Steps for Carry {
    fn next_step(&mut self) -> Step<(Rnt,)> {
        Step::Done
    }
}

fn main() {
    let _ = Carry.next_step();
}
