//! Plans of several arms.
