//! A step function has a foreign calling convention.
//! says: drop the `extern`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
extern "C-unwind" fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
