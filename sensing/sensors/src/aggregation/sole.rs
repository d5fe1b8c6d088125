//! The classifier where there is one kind of part only.

use super::vision::Classifier;

/// Takes whatever it is shown for the one class that there is. Whether it truly is a part of that class, its outline tells
/// ([`Vision::FIT`](super::Vision::FIT)), so that no network is needed.
///
/// ```
/// use mrroc_sensors::aggregation::{Classifier, Sole};
///
/// assert_eq!(Sole.classify(&[0.0]), Some(vec![1.0]));
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Sole;

impl Classifier for Sole {
    fn classify(&mut self, _: &[f32]) -> Option<Vec<f32>> {
        Some(vec![1.0])
    }
}
