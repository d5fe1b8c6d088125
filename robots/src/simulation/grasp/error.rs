//! Errors in the description of a world, found before anything moves.

/// Why a world, or an arm in it, cannot be simulated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A mass, a stiffness or a period is not above zero, or is NaN.
    #[error("{what} is {actual} {unit}, it must be above 0 and finite")]
    NotPositive {
        /// Which quantity: `"the body's mass"`.
        what: &'static str,
        /// Its value.
        actual: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A damping or a friction is negative or NaN.
    #[error("{what} is {actual} {unit}, it must be 0 or more and finite")]
    Negative {
        /// Which quantity: `"the table's friction"`.
        what: &'static str,
        /// Its value.
        actual: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// No rigid body has these principal moments: each must be above 0 and at most the sum of the other two.
    #[error(
        "the body's principal moments of inertia {} kg m², {} kg m² and {} kg m² are those of no rigid body",
        .0[0], .0[1], .0[2]
    )]
    Inertia(
        /// The principal moments, ascending [kg m²]; NaN where the tensor is not symmetric or not finite.
        [f64; 3],
    ),
    /// The base of a belt is not level.
    #[error("the belt's base leans by {0} rad, it must be level")]
    Leaning(
        /// The angle of its z axis to the vertical \[rad\].
        f64,
    ),
    /// A sink has no inside.
    #[error("a sink reaches from {lower:?} to {upper:?}, its lower corner must be below its upper one")]
    Sink {
        /// Its lower corner \[m\].
        lower: [f64; 3],
        /// Its upper corner \[m\].
        upper: [f64; 3],
    },
    /// A pose is not finite.
    #[error("{0} is not finite")]
    NotFinite(
        /// Which pose: `"the body's pose"`.
        &'static str,
    ),
}

/// `actual` where it is above 0 and finite.
pub(super) fn positive(what: &'static str, actual: f64, unit: &'static str) -> Result<f64, WorldError> {
    let is_positive = actual > 0.0 && actual.is_finite();
    if is_positive { Ok(actual) } else { Err(WorldError::NotPositive { what, actual, unit }) }
}

/// `actual` where it is 0 or above and finite.
pub(super) fn not_negative(what: &'static str, actual: f64, unit: &'static str) -> Result<f64, WorldError> {
    let is_positive = actual >= 0.0 && actual.is_finite();
    if is_positive { Ok(actual) } else { Err(WorldError::Negative { what, actual, unit }) }
}
