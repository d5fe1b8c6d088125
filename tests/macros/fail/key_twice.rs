//! A key is said twice.
//! says: leave one of them out

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, first = begin, first = begin)]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}

fn begin(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}
