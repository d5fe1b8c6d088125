//! Generators of this task.
