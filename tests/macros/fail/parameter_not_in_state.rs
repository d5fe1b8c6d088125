//! A parameter is not in the state's type.
//! says: `PhantomData<R>`

use mistakes::*;
use mrroc::prelude::*;

struct Carry;

#[generator(ecp)]
fn carry<R: Robot>(_: &mut Carry) -> Step<R> {
    Step::Done
}

fn main() {
    let _ = carry::<Rnt>(&mut Carry);
    let _ = ecp().move_robot((), Carry);
}
