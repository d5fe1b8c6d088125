//! A payload is not `Copy`.
//! says: `Plan: Copy`

use mistakes::*;
use mrroc::prelude::*;

#[derive(Payload)]
struct Plan {
    x: f64,
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
