//! The demand is returned without `Step::Next`.
//! says: expected `Step<Rnt>`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
fn line(_: &mut Line) -> Step<Rnt> {
    Demand::hold()
}

fn main() {
    let _ = ecp().move_robot((), Line);
}
