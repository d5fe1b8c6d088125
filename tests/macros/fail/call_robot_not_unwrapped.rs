//! The `?` behind `mp.robot(..)` is forgotten.
//! says: `mp.robot::<Rnt>("rnt")?`

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let mut mp = mp();
    let mut rnt = mp.robot::<Rnt>("rnt");
    let _ = mp.move_robots((&mut rnt,), (), Lift);
}
