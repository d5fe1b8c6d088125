//! A function without state has a parameter.
//! says: `c: &mut Hold<R>`

use mistakes::*;
use mrroc::prelude::*;

#[generator(ecp)]
fn hold<R: Robot>() -> Always<R> {
    Always(Demand::hold())
}

fn main() {
    let _ = hold::<Rnt>();
    let _ = ecp().move_robot((), hold {});
}
