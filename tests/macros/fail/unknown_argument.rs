//! An argument that no step function has.
//! says: keep it in the state

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, _: f64) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, 1.0);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
