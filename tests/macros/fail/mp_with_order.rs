//! An MP's step function takes an order.
//! says: nobody orders an MP

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, order: &Order<Phase>) -> Step<(Rnt, Polycrank)> {
    let _ = order;
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
