//! A step function fails with something else than a fault.
//! says: `Result<Step<(Rnt, Polycrank)>, Fault>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) -> Result<Step<(Rnt, Polycrank)>, String> {
    Ok(Step::Done)
}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
