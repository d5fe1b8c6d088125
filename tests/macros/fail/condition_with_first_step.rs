//! A condition has a first step.
//! says: no argument of `#[condition(..)]`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[condition(mp, first = held)]
fn held(_: &mut Carry) -> bool {
    true
}

fn main() {
    let _ = held(&mut Carry);
    let _ = mp().wait_until((&mut rnt(), &mut polycrank()), (&mut force(),), Carry);
}
