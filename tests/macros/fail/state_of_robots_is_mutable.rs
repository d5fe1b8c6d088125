//! The state of the robots is to be written.
//! says: `&State<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, e: &mut State<(Rnt, Polycrank)>) -> Step<(Rnt, Polycrank)> {
    let _ = e;
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
