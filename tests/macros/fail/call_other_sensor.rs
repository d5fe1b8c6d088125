//! Another sensor than that of the list in the call.
//! says: the list is `(WristForce,)`: pass the handles in its order

use mistakes::*;
use mrroc::prelude::*;

struct Press;

#[generator(mp)]
fn press(_: &mut Press, v: &Reading<(WristForce,)>) -> Step<(Rnt,)> {
    let _ = v;
    Step::Done
}

fn main() {
    let (mut rnt, mut camera) = (rnt(), camera());
    let _ = mp().move_robots((&mut rnt,), (&mut camera,), Press);
}
