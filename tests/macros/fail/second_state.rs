//! Two states.
//! says: one type holds all

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, _: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, &mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
