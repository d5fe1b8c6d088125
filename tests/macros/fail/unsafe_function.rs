//! A step function is unsafe.
//! says: drop `unsafe`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
unsafe fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = unsafe { carry(&mut Carry) };
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
