//! A field of a payload is no plain value.
//! says: plain are numbers

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
struct Plan {
    name: &'static str,
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
