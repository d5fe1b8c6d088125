//! A network from an ONNX file, as a classifier.

use rten::Model;
use rten_tensor::NdTensor;
use rten_tensor::prelude::*;
use thiserror::Error;

use super::vision::Classifier;

/// A network with one input of 1 x so many features and one output of a score for each class, 0 to 1.
pub struct Network {
    model: Model,
}

/// Why a network cannot be used.
#[derive(Debug, Error)]
pub enum NetworkError {
    /// The file is no network that can be read.
    #[error("the network cannot be read: {0}")]
    Unreadable(String),
    /// It has another number of inputs or outputs.
    #[error("the network has {inputs} inputs and {outputs} outputs: it must have one of each")]
    Ends {
        /// How many inputs.
        inputs: usize,
        /// How many outputs.
        outputs: usize,
    },
    /// It does not take the features, or gives no scores for these classes.
    #[error("the network does not make scores of {classes} classes of {features} features: train it anew")]
    Shape {
        /// How many features it is to take.
        features: usize,
        /// How many classes there are.
        classes: usize,
    },
}

impl core::fmt::Debug for Network {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Network")
    }
}

impl Network {
    /// Reads an ONNX file's bytes, of a network that tells so many classes by so many features.
    ///
    /// # Errors
    /// [`NetworkError`] for what does not fit.
    pub fn read(bytes: Vec<u8>, features: usize, classes: usize) -> Result<Self, NetworkError> {
        let model = Model::load(bytes).map_err(|error| NetworkError::Unreadable(error.to_string()))?;
        let (inputs, outputs) = (model.input_ids().len(), model.output_ids().len());
        if (inputs, outputs) != (1, 1) {
            return Err(NetworkError::Ends { inputs, outputs });
        }
        let mut network = Self { model };
        let fits = network.classify(&vec![0.0; features]).is_some_and(|scores| scores.len() == classes);
        if fits { Ok(network) } else { Err(NetworkError::Shape { features, classes }) }
    }
}

impl Classifier for Network {
    fn classify(&mut self, features: &[f32]) -> Option<Vec<f32>> {
        let input = NdTensor::from_data([1, features.len()], features.to_vec());
        let run = self.model.run_one(input.view().into(), None);
        let scores: NdTensor<f32, 2> = run.ok()?.try_into().ok()?;
        let scores: Vec<f32> = scores.iter().copied().collect();
        scores.iter().all(|score| score.is_finite()).then_some(scores)
    }
}
