//! `cargo +nightly fuzz run rtde ../parsers/corpus/rtde`, in this folder.
#![no_main]

#[path = "../../parsers/targets.rs"]
#[allow(dead_code, reason = "each target is one of them")]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::rtde(bytes));
