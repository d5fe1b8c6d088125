//! An MP's demand for one robot is returned without its tuple.
//! says: (Demand<Rnt>,)

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Next(Demand::hold())
}

fn main() {
    let _ = mp().move_robots((&mut rnt(),), (), Lift);
}
