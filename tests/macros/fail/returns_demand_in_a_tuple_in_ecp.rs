//! An ECP's demand is returned in a tuple.
//! says: `Step::Next(demand)`

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(ecp)]
fn lift(_: &mut Lift) -> Step<Rnt> {
    Step::Next((Demand::hold(),))
}

fn main() {
    let _ = ecp().move_robot((), Lift);
}
