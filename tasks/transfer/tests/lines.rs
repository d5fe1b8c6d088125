//! How few lines the task takes: counted, and printed.

use transfer::lines::{Counts, LIMITS};

#[test]
fn the_programs_are_as_short_as_promised() {
    let counts = Counts::of_this_task();
    println!("{counts}");
    assert!(counts.transmit <= LIMITS.transmit && counts.transmit >= 1, "{counts}");
    assert!(counts.trajectory <= LIMITS.trajectory && counts.trajectory >= 5, "{counts}");
    assert!(counts.programs <= LIMITS.programs && counts.programs >= 10, "{counts}");
}
