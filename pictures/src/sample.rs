//! A robot at the end of a servo period.
//!
//! In: where its joints, links and tool are. Out: the same, and how fast it all is, once that is known.

use mrroc::pose::Pose;
use nalgebra::Vector3;

/// A robot at the end of a servo period.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Time since the cell started \[s\].
    pub time: f64,
    /// Joint positions demanded [rad or m].
    pub demanded: Vec<f64>,
    /// Joint positions measured [rad or m].
    pub measured: Vec<f64>,
    /// Where the links begin, from the base to the flange, in the world \[m\].
    pub links: Vec<Vector3<f64>>,
    /// `X_WE`, the pose of the tool.
    pub tool: Pose,
    /// How fast all that is; none at first.
    pub rates: Option<Rates>,
}

impl Sample {
    /// Whether all of it is numbers.
    pub fn is_finite(&self) -> bool {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        self.time.is_finite()
            && finite(&self.demanded)
            && finite(&self.measured)
            && self.links.iter().all(|point| finite(point.as_slice()))
            && finite(self.tool.translation.vector.as_slice())
            && finite(self.tool.rotation.coords.as_slice())
    }
}

/// What changes how fast.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rates {
    /// The middle of the window \[s\].
    pub time: f64,
    /// Of the demanded joint positions [rad/s or m/s].
    pub demanded: Vec<f64>,
    /// Of the measured joint positions [rad/s or m/s].
    pub measured: Vec<f64>,
    /// Speed of the tool [m/s], at least 0.
    pub tool: f64,
}
