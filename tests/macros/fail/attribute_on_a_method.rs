//! The attribute stands over a method instead of over its block.
//! says: put the attribute over the `impl` block

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

impl Carry {
    #[generator(mp)]
    fn next_step(&mut self) -> Step<(Rnt,)> {
        Step::Done
    }
}

fn main() {
    let _ = Carry.next_step();
}
