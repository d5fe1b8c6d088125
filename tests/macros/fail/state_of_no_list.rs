//! The state of the robots does not say of which.
//! says: `<L>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, e: &State) -> Step<(Rnt, Polycrank)> {
    let _ = e;
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
