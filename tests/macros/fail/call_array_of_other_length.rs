//! A list of two robots of one kind is passed three.
//! says: the list is `[Rnt; 2]`: pass the handles in its order

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<[Rnt; 2]> {
    Step::Done
}

fn main() {
    let (mut a, mut b, mut c) = (rnt(), rnt(), rnt());
    let _ = mp().move_robots([&mut a, &mut b, &mut c], (), Lift);
}
