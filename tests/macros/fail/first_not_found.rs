//! The function of the first step does not exist.
//! says: cannot find value `gasp`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, first = gasp)]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
