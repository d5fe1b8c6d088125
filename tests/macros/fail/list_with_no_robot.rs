//! Something in the list is no robot.
//! says: a tuple or an array of robots
//! errors: 2, since the compiler repeats it where the body makes a step of the list

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<(Rnt, WristForce)> {
    Step::Done
}

fn main() {}
