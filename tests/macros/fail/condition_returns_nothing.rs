//! A condition returns nothing.
//! says: `-> bool`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[condition(mp)]
fn held(_: &mut Carry) {}

fn main() {
    held(&mut Carry);
    let _ = mp().wait_until((&mut rnt(), &mut polycrank()), (&mut force(),), Carry);
}
