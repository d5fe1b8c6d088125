//! The sensors are left out of a call.
//! errors: 2, the compiler counts the arguments and tells what of them fits
//! says: takes 3 arguments

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = mp().move_robots((&mut rnt(),), Lift);
}
