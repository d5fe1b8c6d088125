//! An MP reacts to the robots without a state of the coordinator.
//! says: the five forms of an MP

use mistakes::*;
use mrroc::prelude::*;

#[generator(mp)]
fn follow(e: &State<(Rnt, Polycrank)>) -> Always<(Rnt, Polycrank)> {
    let _ = (e,);
    Always((Demand::hold(), Demand::hold()))
}

fn main() {
    let _ = follow;
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (&mut force(),), follow {});
}
