//! The tick is taken by reference.
//! says: `t: Tick`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, t: &Tick) -> Step<(Rnt, Polycrank)> {
    let _ = t;
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, &Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
