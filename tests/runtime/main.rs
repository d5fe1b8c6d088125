//! The runtime's promises, a file per promise.

mod moves;
