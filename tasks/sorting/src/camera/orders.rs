//! What the coordinator tells arm and hand: loosely, which part to take where.

use mrroc::prelude::*;

/// A task of the arm and its hand.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Task {
    /// Take a part from the belt and bring it over its bin.
    Pick {
        /// Its number.
        part: u32,
        /// Where it is, and how it is to be grasped.
        place: Place,
        /// The bin, as [`bin`](super::layout::bin) counts them.
        bin: u32,
    },
    /// Arm: go down to the belt with a part that it cannot bring to its bin; the belt has a gap there.
    PutBack,
    /// Hand: let it go.
    Release,
    /// Arm: to where it waits.
    Return,
}

/// Where a part is grasped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Place {
    /// Along the belt, where that had run 0 \[m\] ..
    pub along: f64,
    /// .. and across it, along x of the world from the middle of the belt \[m\].
    pub across: f64,
    /// Angle of the tool about z of the world, 0 to half a turn \[rad\].
    pub yaw: f64,
}
