//! What the camera saw.
