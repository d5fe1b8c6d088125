//! How tests and the task programs that they start as processes (`tests/cell/`) tell each other things: names of
//! variables of the environment, and of files in the folders that some of them name.

/// Names the program to be: [`ARMS`], [`TASKS`], [`SOAK`] or [`RECORDED`].
pub const PROGRAM: &str = "MRROC_TEST_PROGRAM";
/// Two arms that are coordinated loosely and tightly, sensors in three modes.
pub const ARMS: &str = "arms";
/// The engraving and the transfer.
pub const TASKS: &str = "tasks";
/// Two arms that turn to and fro for as long as they are told.
pub const SOAK: &str = "soak";
/// The cell of the tests of recordings.
pub const RECORDED: &str = "recorded";

/// Names the folder of the records of what robots were demanded: a file per robot.
pub const RECORDS: &str = "MRROC_TEST_RECORDS";
/// Names the folder of what is counted of processes: a file per role.
pub const COUNTS: &str = "MRROC_TEST_COUNTS";
/// Under it an EDP is of another program, which has one robot more.
pub const OTHER: &str = "MRROC_TEST_OTHER";
/// Makes the MP's program compute for ever instead.
pub const COMPUTES: &str = "MRROC_TEST_COMPUTES";
/// The path time \[s\] from which a recorded swing is another one.
pub const CHANGE: &str = "MRROC_TEST_CHANGE";
/// How long the arms of [`SOAK`] move \[s\].
pub const SECONDS: &str = "MRROC_SOAK";

/// The file of what the observers of [`TASKS`] have seen, beside the records.
pub const SEEN: &str = "seen";
/// The file of what the MP of [`SOAK`] has counted, beside the records.
pub const COUNT: &str = "steps";

/// Steps in which what a process of [`ARMS`] allocates is counted.
pub const STEPS: u64 = 300;

/// How long the arms of [`SOAK`] move \[s\]: just long enough for the rate of their steps to be known, if nobody says.
#[must_use]
pub fn seconds() -> u32 {
    std::env::var(SECONDS).ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(10)
}
