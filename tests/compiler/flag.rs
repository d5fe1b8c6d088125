//! Prints whether a flag is set that nobody has set, by two forms of one function: `false false` where the compiler is right.

use std::hint::black_box;

/// rustc 1.95 drops the comparison at `opt-level` 2 and 3, because the caller branches on it as well: it sets the flag always.
fn take_by_or(word: u8, flag: &mut bool) -> bool {
    let asked = word != 0;
    *flag |= asked;
    asked
}

/// How the runtime writes it.
fn take_by_branch(word: u8, flag: &mut bool) -> bool {
    let asked = word != 0;
    if asked {
        *flag = true;
    }
    asked
}

#[inline(never)]
fn hear_by_or(word: u8, flag: &mut bool, count: &mut u32) {
    if take_by_or(word, flag) {
        *count += 1;
    }
}

#[inline(never)]
fn hear_by_branch(word: u8, flag: &mut bool, count: &mut u32) {
    if take_by_branch(word, flag) {
        *count += 1;
    }
}

fn main() {
    let (mut or, mut branch, mut count) = (false, false, 0);
    hear_by_or(black_box(0), &mut or, &mut count);
    hear_by_branch(black_box(0), &mut branch, &mut count);
    println!("{or} {branch}");
    assert_eq!(count, 0, "the branch itself is right");
}
