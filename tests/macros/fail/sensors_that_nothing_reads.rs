//! The attribute names sensors that nothing reads.
//! says: take `&Reading<..>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, sensors = (WristForce,))]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
