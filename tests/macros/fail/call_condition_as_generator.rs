//! A condition is passed to Move.
//! says: is no generator

use mistakes::*;
use mrroc::prelude::*;

struct Dwell;

#[condition(mp)]
fn dwell(_: &mut Dwell) -> bool {
    true
}

fn main() {
    let _ = (dwell(&mut Dwell), mp().move_robots((&mut rnt(),), (), Dwell));
}
