//! A step function is asynchronous.
//! says: drop `async`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
async fn carry(_: &mut Carry) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
