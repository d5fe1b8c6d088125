//! A state whose step function has no attribute is passed to Move.
//! says: `#[generator(mp)]` or `#[generator(ecp)]`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

fn carry(_: &mut Carry) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry);
    let mut rnt = rnt();
    let _ = mp().move_robots((&mut rnt,), (), Carry);
}
