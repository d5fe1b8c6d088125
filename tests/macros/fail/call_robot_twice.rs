//! One robot is passed twice.
//! says: mutable more than once

use mistakes::*;
use mrroc::prelude::*;

struct Both;

#[generator(mp)]
fn both(_: &mut Both) -> Step<(Rnt, Rnt)> {
    Step::Done
}

fn main() {
    let mut rnt = rnt();
    let _ = mp().move_robots((&mut rnt, &mut rnt), (), Both);
}
