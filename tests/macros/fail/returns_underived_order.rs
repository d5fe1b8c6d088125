//! The order's payload is not derived.
//! errors: 2, since the compiler repeats it where the body makes a step of the list
//! says: `#[derive(Clone, Copy, mrroc::payload::Payload)]`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[derive(Clone, Copy)]
struct Plan;

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<(Rnt,), Plan> {
    Step::Done
}

fn main() {}
