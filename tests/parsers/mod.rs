//! Readers under bad input, fault 33 in docs/safety: no panic, and no more than 256 MB, whatever they read.
//!
//! `just fuzz 1000000` runs so many mutated inputs in all; inputs that fail are written to the target folder.

mod bombs;
mod mutation;
mod targets;

use std::panic::catch_unwind;
use std::time::Instant;

use mrroc::random::Random;
use mrroc_counting_allocator::peak;
use mutation::mutate;
use targets::TARGETS;

/// Most memory that reading may take \[bytes\].
const MEMORY: usize = 256 << 20;

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("parsers/corpus").join(name);
    let mut files: Vec<_> =
        std::fs::read_dir(folder).expect("a corpus").map(|file| file.expect("a file").path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).expect("readable")).collect()
}

/// Reads one input; if this panics or takes too much memory, the input is kept and its file is named.
fn read(name: &str, target: targets::Target, input: &[u8]) {
    let (outcome, most) = peak(|| catch_unwind(|| target(input)));
    if outcome.is_err() || most > MEMORY {
        let kept = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.failing"));
        std::fs::write(&kept, input).expect("the target folder can be written");
        panic!("{name}: {} bytes at once, reading {}", most, kept.display());
    }
}

/// So many mutated inputs in all, by a seed.
fn readers_survive(inputs: usize, seed: u64) {
    let each = inputs / TARGETS.len();
    std::thread::scope(|scope| {
        for half in 0..2 {
            scope.spawn(move || {
                for (name, target) in TARGETS.iter().skip(half).step_by(2) {
                    let (corpus, mut random) = (corpus(name), Random::seeded(seed));
                    corpus.iter().for_each(|input| read(name, *target, input));
                    let (began, mut worst) = (Instant::now(), 0.0_f64);
                    for _ in 0..each {
                        let input = mutate(&corpus, &mut random);
                        let one = Instant::now();
                        read(name, *target, &input);
                        worst = worst.max(one.elapsed().as_secs_f64());
                    }
                    let all = began.elapsed().as_secs_f64();
                    println!(
                        "{name:<9} seed {seed}: {each} inputs in {all:.1} s, the slowest {:.1} ms",
                        worst * 1e3
                    );
                }
            });
        }
    });
}

#[test]
fn fault_33_readers_survive_what_they_read() {
    readers_survive(23_333, 1);
}

#[test]
#[ignore = "takes minutes: `just fuzz`"]
fn fault_33_readers_survive_so_many_inputs() {
    let inputs = std::env::var("MRROC_FUZZ").expect("`just fuzz` sets MRROC_FUZZ");
    let seed = std::env::var("MRROC_FUZZ_SEED").expect("`just fuzz` sets MRROC_FUZZ_SEED");
    readers_survive(
        inputs.parse().expect("MRROC_FUZZ is a number"),
        seed.parse().expect("MRROC_FUZZ_SEED is a number"),
    );
}
