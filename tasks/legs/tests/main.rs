//! The task of the legs.
mod runs;
