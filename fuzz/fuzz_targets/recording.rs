//! `cargo +nightly fuzz run recording ../tests/parsers/corpus/recording`, in this folder.
#![no_main]

#[path = "../../tests/parsers/targets.rs"]
#[allow(dead_code, reason = "each target is one of them")]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::recording(bytes));
