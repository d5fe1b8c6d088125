//! A generator of the MP is passed to an ECP.
//! says: Generator>::Robots == Rnt

use mistakes::*;
use mrroc::prelude::*;

#[derive(Default)]
struct Carry;

#[generator(mp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
    let _ = (c, t);
    Step::Next((Demand::hold(), Demand::hold()))
}

fn main() {
    let _ = ecp().move_robot((), Carry);
}
