//! A free function takes `self`.
//! says: over the `impl` block
//! errors: 2, since the compiler itself refuses a method outside of a block before it looks further

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(&mut self) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {}
