//! A function without state is passed itself instead of its constant.
//! says: one without as `name {}`

use mistakes::*;
use mrroc::prelude::*;

#[generator(ecp)]
fn transmit(order: &Order<Displacement>) -> Always<Rnt> {
    Always(Demand::displacement(order.value().pose))
}

fn main() {
    let _ = ecp().move_robot((), transmit);
}
