//! An MP's condition takes an order.
//! says: nobody orders an MP

use mistakes::*;
use mrroc::prelude::*;

#[condition(mp)]
fn held(order: &Order<Phase>) -> bool {
    order.value() == Phase::Grasp
}

fn main() {
    let _ = held;
    let _ = mp().wait_until((&mut rnt(), &mut polycrank()), (&mut force(),), held {});
}
