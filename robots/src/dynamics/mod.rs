//! Rigid-body dynamics of open trees: the torques that a motion takes, and the motion that torques make.
//!
//! In: links with their masses, joint positions, speeds and accelerations or torques. Out: the terms of the equation of motion
//!
//! ```text
//! M(q) qddot + h(q, qdot) = tau + J^T F,      h = Coriolis, centrifugal and gravity terms
//! ```
//!
//! | function of [`Tree`] | what | algorithm (Featherstone 2008) |
//! |---|---|---|
//! | [`inverse_dynamics`](Tree::inverse_dynamics) | tau of q, qdot, qddot | recursive Newton-Euler, table 5.1 |
//! | [`mass_matrix`](Tree::mass_matrix) | M | composite rigid bodies, table 6.2 |
//! | [`bias`](Tree::bias), [`gravity_torques`](Tree::gravity_torques) | h, and h at rest | recursive Newton-Euler |
//! | [`forward_dynamics`](Tree::forward_dynamics) | qddot of q, qdot, tau | M, h and Cholesky's factors, table 6.1 |
//! | [`kinetic_energy`](Tree::kinetic_energy), [`potential_energy`](Tree::potential_energy) | energies of the links | sums over the bodies |
//!
//! All vectors are written along the axes of the world W, spatial ones at the origin of the base B. After its construction a
//! tree allocates nothing, so a servo period may use it. Motors, gears and friction are no part of it: they are
//! [`Driven`](crate::Driven)'s, and the plant adds them. A robot gives its tree by [`Driven::tree`](crate::Driven::tree).
//!
//! | file | concept |
//! |---|---|
//! | `segment.rs` | [`Segment`]: a joint and the body that it moves |
//! | `tree.rs` | [`Tree`] and what is wrong with one |
//! | `posture.rs` | where axes and bodies are at q |
//! | `inverse.rs`, `forward.rs`, `energy.rs` | the functions of the table |

mod energy;
mod forward;
mod inverse;
mod posture;
mod segment;
#[cfg(test)]
mod tests;
mod tree;

pub use forward::{Dynamics, Equation};
pub use segment::Segment;
pub use tree::{Tree, TreeError};
