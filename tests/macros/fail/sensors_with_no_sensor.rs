//! Something in the list of sensors is none.
//! says: a tuple of kinds of sensors

use mistakes::*;
use mrroc::prelude::*;

struct Press;

#[generator(ecp)]
fn press(_: &mut Press, _: &Reading<(Rnt,)>) -> Step<Rnt> {
    Step::Done
}

fn main() {}
