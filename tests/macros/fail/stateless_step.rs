//! A function without arguments returns a step.
//! says: `Always<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

#[generator(mp)]
fn nudge() -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = nudge();
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), nudge {});
}
