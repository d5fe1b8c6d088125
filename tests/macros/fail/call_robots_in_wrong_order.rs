//! Robots in the wrong order in the call.
//! says: the list is `(Rnt, Polycrank)`: pass the handles in its order

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
    let _ = mp().move_robots((&mut polycrank, &mut rnt), (), Carry);
}
