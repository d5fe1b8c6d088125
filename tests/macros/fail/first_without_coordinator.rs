//! An MP's first step reacts to the robots without a state of the coordinator.
//! says: the five forms of an MP

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp, first = grasp)]
fn carry(_: &mut Carry, _: Tick) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = carry(&mut Carry, Tick { step: 0, dt: 0.0, duration: 0.0 });
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}

fn grasp(_: &State<(Rnt, Polycrank)>) -> Step<(Rnt, Polycrank)> {
    Step::Done
}
