//! The coordinator's program is asynchronous.

use mistakes::*;
use mrroc::prelude::*;

struct Lift;

#[generator(mp)]
fn lift(_: &mut Lift) -> Step<(Rnt,)> {
    Step::Done
}

async fn coordinate(mp: &mut Mp<'_>) -> Result<(), Fault> {
    mp.move_robots((&mut rnt(),), (), Lift).map(drop)
}

fn main() {
    let _ = Cell::new(std::time::Duration::from_millis(2)).program(coordinate);
}
