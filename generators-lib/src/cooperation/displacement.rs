//! What the coordinator orders an arm in a step of tight cooperation.
//!
//! ```text
//! X_EsE = X_WEs^-1 X_WE        of X_WE, and of X_WEs demanded at the start of the instruction
//! ```
//!
//! Source: Zieliński's MRROC++ paper, section 8: the MP computes the displacements, the ECPs' generators only transmit.

use mrroc::prelude::*;

/// `X_EsE`, a displacement from the pose Es demanded at the start of the instruction, in the tool's own axes of that
/// moment: seven numbers, an order of tight cooperation.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Displacement {
    /// `X_EsE` \[m\].
    pub pose: Pose,
}

impl Displacement {
    /// From the start `X_WEs` to `X_WE`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn between(X_WEs: &Pose, X_WE: &Pose) -> Self {
        Displacement { pose: X_WEs.inv_mul(X_WE) }
    }
}

/// Where a tool was and where it is to be: sent to a transparent ECP as a pose, to one that transmits as a
/// [`Displacement`]. One generator serves both.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Placed {
    /// As demanded at the start of the instruction.
    pub X_WEs: Pose,
    /// As demanded now.
    pub X_WE: Pose,
}

impl<R: Robot> From<Placed> for Demand<R> {
    fn from(placed: Placed) -> Self {
        Demand::pose(placed.X_WE)
    }
}

impl From<Placed> for Displacement {
    fn from(placed: Placed) -> Self {
        Displacement::between(&placed.X_WEs, &placed.X_WE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::payload::Wire;
    use nalgebra::Vector3;

    #[test]
    fn a_displacement_leads_from_the_start_to_the_end_and_takes_seven_numbers() {
        let from = Pose::new(Vector3::new(0.8, -0.3, 0.5), Vector3::new(3.0, 0.1, -0.2));
        let to = Pose::new(Vector3::new(0.7, 0.1, 0.2), Vector3::new(1.0, -0.5, 0.4));
        let end = from * Displacement::between(&from, &to).pose;
        assert!((end.translation.vector - to.translation.vector).norm() < 1e-15 * 4.0);
        assert!(end.rotation.angle_to(&to.rotation) < 1e-7);
        assert_eq!(Displacement::LEN, 7);
        const { assert!(Displacement::TIGHT) };
    }
}
