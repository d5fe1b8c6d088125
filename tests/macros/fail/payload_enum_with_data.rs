//! An order of loose cooperation carries data.
//! says: into a `struct` of their own

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
enum Plan {
    Rest,
    Go(f64),
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
