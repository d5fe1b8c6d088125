//! The maze task: what it keeps, and what faults do to it.

mod camera;
mod faults;
mod force;
mod lines;
mod reactive;
mod runs;
mod shared;
mod wheels;

use maze::mazes::Seeded;
use mrroc_map::Layout;

fn islands() -> Layout {
    let [islands, _] = Seeded::shipped(0).expect("mazes");
    islands.layout
}

/// The shipped mazes, and so many by chance.
fn with_shipped(count: u64) -> Vec<Seeded> {
    let shipped = Seeded::shipped(0).expect("mazes");
    shipped.into_iter().chain((0..count).map(Seeded::by_chance)).collect()
}
