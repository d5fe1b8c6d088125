//! The attribute stands over a struct.
//! says: stands over a step function

use mistakes::*;
use mrroc::prelude::*;

#[generator(mp)]
struct Carry;

fn carry(_: &mut Carry) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry);
}
