//! A step function returns a demand instead of a step.
//! says: `Step<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> (Demand<Rnt>, Demand<Polycrank>) {
    (Demand::hold(), Demand::hold())
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
