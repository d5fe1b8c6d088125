//! The terminal condition reads sensors that the attribute does not name.
//! says: `sensors = (WristForce,)`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, until = over)]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}

fn over(v: &Reading<(WristForce,)>) -> bool {
    v.0.reading().is_some()
}
