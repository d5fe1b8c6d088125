//! Generators made of generators, by the [`Generator`](mrroc::generator::Generator) trait alone.
//!
//! | combinator | what it does |
//! |---|---|
//! | [`Sequence`] | one after the other, without a step of rest between them |
//! | [`Handover`] | one after the other on the move, without a step of velocity between them |
//! | [`Each`](mrroc::generator::Each) | the motions of several robots at once, as one motion of the MP |
//! | [`Corrected`] | any generator of poses, displaced by a sensor at a limited rate |
//! | [`Compliant`] | any generator of poses, whose tool also presses and yields by a force law |
//! | [`Override`] | brakes one on its path when a condition holds, then another takes over |
//! | [`Arbitrate`] | of a list by priority, the first that the readings call for, handed over at rest |
//! | [`Superpose`] | two at once: their velocities, weighted by the readings and added, within limits |
//! | [`Blind`] | one without sensors among others that have some |
//!
//! A combinator's class is what its parts take together; each is tested as the generators are.

mod arbitrate;
mod blind;
mod compliant;
mod corrected;
mod handover;
mod override_;
mod sequence;
mod superpose;

pub use arbitrate::Arbitrate;
pub use blind::Blind;
pub use compliant::Compliant;
pub use corrected::{Corrected, CorrectionLimits};
pub use handover::Handover;
pub use override_::Override;
pub use sequence::Sequence;
pub use superpose::Superpose;
