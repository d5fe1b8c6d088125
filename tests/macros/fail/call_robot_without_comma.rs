//! A list of one robot without its comma in the call.
//! says: `(&mut rnt,)`

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let mut rnt = rnt();
    let _ = mp().move_robots((&mut rnt), (), Lift);
}
