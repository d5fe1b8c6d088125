//! The reading is taken by value.
//! says: `&Reading<(WristForce,)>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, v: Reading<(WristForce,)>) -> Step<(Rnt, Polycrank)> {
    let _ = v;
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (&mut force(),), Carry);
}
