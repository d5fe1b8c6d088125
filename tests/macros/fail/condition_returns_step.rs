//! A condition returns a step.
//! says: `#[generator(mp)]`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[condition(mp)]
fn held(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = held(&mut Carry);
    let _ = mp().wait_until((&mut rnt(), &mut polycrank()), (&mut force(),), Carry);
}
