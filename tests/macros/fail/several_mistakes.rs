//! Three mistakes in one signature are reported at once.
//! errors: 3, one for each
//! says: `(Rnt,)`
//! says: `t: Tick`
//! says: nobody orders an MP

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry, _: &Order<Phase>, _: &Tick) -> Step<(Rnt)> {
    Step::Done
}

fn main() {
    let _ = carry;
    let _ = mp().move_robots((&mut rnt(),), (), Carry);
}
