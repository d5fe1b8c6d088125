//! The state's lifetime is hidden.
//! says: `<'_>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry<'a>(&'a f64);

#[generator(mp)]
fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry(&1.0));
}
