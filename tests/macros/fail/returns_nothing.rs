//! A step function returns nothing.
//! says: `-> Step<(Rnt, Polycrank)>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(mp)]
fn carry(_: &mut Carry) {}

fn main() {
    let _ = carry(&mut Carry);
    let _ = mp().move_robots((&mut rnt(), &mut polycrank()), (), Carry);
}
