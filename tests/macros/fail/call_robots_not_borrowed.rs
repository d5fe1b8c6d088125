//! The handles are passed by value.
//! says: one `&mut` handle for each robot

use mistakes::*;
use mrroc::prelude::*;

#[derive(Default)]
struct Carry;

#[generator(mp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
    let _ = (c, t);
    Step::Next((Demand::hold(), Demand::hold()))
}

fn main() {
    let (mut rnt, mut polycrank) = (rnt(), polycrank());
    let _ = mp().move_robots((rnt, polycrank), (), Carry);
}
