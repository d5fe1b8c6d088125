//! The robots are seen in another order than they are moved.
//! says: `&State<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, e: &State<(Polycrank, Rnt)>) -> Step<(Rnt, Polycrank)> {
    let _ = e;
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
