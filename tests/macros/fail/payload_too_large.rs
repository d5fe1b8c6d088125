//! A payload takes more words than a message holds.
//! says: at most 64 words

use mistakes::*;
use mrroc::prelude::*;

#[derive(Clone, Copy, Payload)]
struct Plan {
    path: [[f64; 3]; 22],
}

fn tells<P: Payload>() -> &'static str {
    P::NAME
}

fn main() {
    let _ = tells::<Plan>();
}
