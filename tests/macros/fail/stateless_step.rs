//! A function without arguments returns a step.
//! says: `Always<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

#[generator(mp)]
fn trigger() -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = trigger();
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), trigger {});
}
