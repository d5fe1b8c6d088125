//! A generator of an ECP is passed to the MP with its list of one.

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp)]
fn line(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = mp().move_robots((&mut rnt(),), (), Line);
}
