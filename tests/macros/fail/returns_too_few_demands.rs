//! A demand is missing in the tuple that is returned.
//! says: Polycrank

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Next((Demand::hold(),))
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
