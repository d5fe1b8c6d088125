//! The state is taken by shared reference.
//! says: `&mut Carry`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
