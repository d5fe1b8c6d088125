//! The state is a number.
//! says: `struct Carry { .. }`

use mistakes::*;
use mrroc::prelude::*;

#[generator(mp)]
fn count(_: &mut f64) -> Step<(Rnt, Polycrank)> {
    Step::Done
}

fn main() {
    let _ = count(&mut 1.0);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), count {});
}
