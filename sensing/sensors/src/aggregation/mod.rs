//! What a program makes of what sensors give: `f_v` (eq. 14), without a cell and without physics.

mod bars;
mod blobs;
mod charuco;
mod chessboard;
mod circles;
mod dark;
mod debounce;
mod features;
mod hearing;
mod homography;
mod lateral;
#[cfg(feature = "networks")]
mod network;
mod passages;
mod pattern;
mod rectified;
mod relief;
mod relief_features;
mod sole;
mod vision;

pub use bars::{Bars, BarsKnown, NoBars};
pub use blobs::{Blob, Blobs};
pub use charuco::{Charuco, Dictionary};
pub use chessboard::{Board, Grey, NoBoard, refine};
pub use circles::{Circles, Rows};
pub use debounce::{Debounce, Edge};
pub use features::{FEATURES, Moments, features};
pub use hearing::{HeardObject, Hearing};
pub use lateral::{Lateral, Laterals};
#[cfg(feature = "networks")]
pub use network::{Network, NetworkError};
pub use passages::{Passage, Passages};
pub use pattern::Pattern;
pub use rectified::Rectified;
pub use relief::{Deaf, Relief, Reliefs, Sample};
pub use relief_features::{RELIEF_FEATURES, relief_features};
pub use sole::Sole;
pub use vision::{Blind, Classifier, DetectedObject, PartClass, Vision};
