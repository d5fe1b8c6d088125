//! An MP's list is one robot without parentheses.
//! says: `(Rnt,)`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<Rnt> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(),), (), Carry);
}
