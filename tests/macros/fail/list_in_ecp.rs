//! An ECP's robot is written as a list.
//! says: without parentheses: `Rnt`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(ecp)]
fn carry(_: &mut Carry) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = ecp().move_robot((), Carry);
}
