//! Two generators for one state type.
//! says: conflicting implementations

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

#[generator(mp)]
fn lift(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = (carry(&mut Carry), lift(&mut Carry));
}
