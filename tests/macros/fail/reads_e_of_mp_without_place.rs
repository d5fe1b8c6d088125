//! An MP reads the state of its list as if it were one robot's.
//! says: demanded

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, e: &State<(Rnt, Polycrank)>) -> Step<(Rnt, Polycrank)> {
    let _ = e.demanded().joints;
    Step::Done
}

fn main() {
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
