//! One robot more than the list has is passed.
//! says: one `&mut` handle for each robot

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

fn main() {
    let (mut rnt, mut polycrank) = (rnt(), polycrank());
    let _ = mp().move_robots((&mut rnt, &mut polycrank), (), Lift);
}
