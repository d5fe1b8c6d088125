//! The first step reads another order than the attribute names.
//! says: order = Phase

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(ecp, first = begin, order = Phase)]
fn carry(_: &mut Carry) -> Step<Rnt> {
    Step::Done
}

fn begin(order: &Order<Displacement>, _: &mut Carry) -> Step<Rnt> {
    let _ = order;
    Step::Done
}

fn main() {
    let _ = (carry(&mut Carry), ecp().move_robot((), Carry));
}
