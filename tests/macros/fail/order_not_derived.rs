//! The order's payload is not derived.
//! says: #[derive(Clone, Copy, mrroc::payload::Payload)]

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[derive(Clone, Copy)]
struct Plan;

#[generator(ecp)]
fn carry(_: &mut Carry, _: &Order<Plan>) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = ecp().move_robot((), Carry);
}
