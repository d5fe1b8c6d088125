//! A generator is passed to Wait.
//! says: is no condition

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = (lift(&mut Lift), mp().wait_until((&mut rnt(),), (), Lift));
}
