//! Tests of the task.

mod accuracy;
