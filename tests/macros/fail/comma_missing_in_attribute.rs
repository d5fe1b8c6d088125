//! A comma is missing between the arguments of the attribute.
//! says: a comma separates arguments: `#[generator(ecp, key = value)]`

use mistakes::*;
use mrroc::prelude::*;

struct Line;

#[generator(ecp first = begin)]
fn line(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

fn begin(_: &mut Line) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = (line(&mut Line), begin(&mut Line));
    let _ = ecp().move_robot((), Line);
}
