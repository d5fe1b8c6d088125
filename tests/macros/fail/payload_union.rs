//! A payload is a union.
//! says: write a `struct` or an `enum`

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
union Plan {
    a: u64,
    b: f64,
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
