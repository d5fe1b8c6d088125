//! The state's name is not that of its struct.
//! errors: 2, the compiler knows no such type, and no generator of the right one
//! says: Carry

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Cary) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let _ = mp().move_robots((&mut rnt(),), (), Carry);
}
