//! Finds a path of all joints from a start to one of several goals: RRT-Connect, then shortcuts. Several robots first try to move one
//! after the other. What earlier queries have proven may be remembered, and is tried before any search.
//!
//! Deterministic: the same world, start, goals and settings give the same path, to the bit; with a roadmap the same sequence of queries gives the same
//! paths. Effort is counted in checks of eight postures,
//! not in time. Literature: Kuffner and LaValle, *RRT-Connect* (ICRA 2000), and for samples that nodes near what is in the way
//! are not tried for: Yershova and others, *Dynamic-Domain RRTs* (ICRA 2005); samples are a Halton sequence, shifted by the seed.

mod connect;
mod roadmap;
mod sampling;
mod several;
mod shorten;
mod space;
mod tree;
mod turns;

pub(crate) use connect::{connect, rooted, straight};
pub(crate) use roadmap::Roadmap;
pub(crate) use sampling::Samples;
pub(crate) use several::find;
pub(crate) use shorten::{shorten, shorten_any};
pub(crate) use space::{Joints, Space};

/// Positions of all joints along a path [rad or m].
pub(crate) type Points = Vec<Vec<f32>>;

/// The longest leg where something is kept upright: straight motions leave that the more, the longer they are [rad or m].
const UPRIGHT: f32 = 0.4;

/// The root of the sum of squares over all joints [rad or m].
pub(crate) fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum::<f32>().sqrt()
}

fn between(a: &[f32], b: &[f32], share: f32) -> Vec<f32> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * share).collect()
}
