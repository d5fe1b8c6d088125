//! A payload has a parameter.
//! says: without parameters

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
struct Many<T> {
    of: T,
}

type Plan = Many<f64>;

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
