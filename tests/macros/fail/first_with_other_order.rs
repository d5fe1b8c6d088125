//! The first step takes its arguments in another order.
//! says: in this order

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, first = grasp)]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}

fn grasp(_: Tick, _: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}
