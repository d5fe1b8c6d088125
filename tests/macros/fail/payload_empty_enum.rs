//! An order without variants.
//! says: name at least one variant

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
enum Plan {}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
