//! A variant of an order carries what is no plain value.
//! says: plain are numbers

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
enum Plan {
    Rest,
    Fetch { name: &'static str },
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
