//! The macros from token stream to token stream, without a compiler.

mod classes;
mod expansion;
mod robustness;
