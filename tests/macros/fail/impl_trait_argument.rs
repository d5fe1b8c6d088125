//! An argument of an unnamed type.
//! says: `fn line<R: Robot>(c: &mut Line<R>, ..)`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, _: impl Robot) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Rnt);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
