//! What tests and the task programs that they start as processes (`tests/cell/`) agree on: the names of environment
//! variables, and of files in the folders that some of these variables name.

/// The variable that chooses the program: [`ARMS`], [`TASKS`], [`SOAK`], [`CROWD`], [`LINE`], [`RECORDED`], [`REMOTE`] or
/// [`SERVO`].
pub const PROGRAM: &str = "MRROC_TEST_PROGRAM";
/// Two arms that are coordinated loosely and tightly, sensors in three modes.
pub const ARMS: &str = "arms";
/// The engraving and the transfer.
pub const TASKS: &str = "tasks";
/// Two arms that turn to and fro for the given time.
pub const SOAK: &str = "soak";
/// The turntable of the book, whose driver is on its page.
pub const SERVO: &str = "servo";
/// Any number of robots that stand.
pub const CROWD: &str = "crowd";
/// Two cells of an arm each under one MP.
pub const LINE: &str = "line";
/// The cell of the tests of recordings.
pub const RECORDED: &str = "recorded";
/// Two robots whose controllers answer late.
pub const REMOTE: &str = "remote";

/// The variable that names the folder for the records of the robots' demands, a file per robot.
pub const RECORDS: &str = "MRROC_TEST_RECORDS";
/// The variable that names the folder for the counts of processes, a file per role.
pub const COUNTS: &str = "MRROC_TEST_COUNTS";
/// The variable that makes an EDP use another cell, with one robot more.
pub const OTHER: &str = "MRROC_TEST_OTHER";
/// The variable that makes the MP's program compute for ever.
pub const COMPUTES: &str = "MRROC_TEST_COMPUTES";
/// The variable that makes the first step of a motion of each arm take half a second.
pub const PLANS: &str = "MRROC_TEST_PLANS";
/// The variable with the number by which the swing of [`ARMS`] is farther.
pub const FARTHER: &str = "MRROC_TEST_FARTHER";
/// The variable with the time \[s\] for which a process of [`ARMS`] may compute at a stretch.
pub const PATIENCE: &str = "MRROC_TEST_PATIENCE";
/// The variable with what the drives of [`ARMS`] say that they are.
pub const HARDWARE: &str = "MRROC_TEST_HARDWARE";
/// The variable with the path time \[s\] from which the swing differs from the recorded one.
pub const CHANGE: &str = "MRROC_TEST_CHANGE";
/// The variable that makes a picture take nothing of what processes show it.
pub const TAKES_NOTHING: &str = "MRROC_TEST_TAKES_NOTHING";
/// The variable that lets the MP of [`LINE`] go on without its left cell; `resets`: that one has a fault at first, and its operator
/// resets it; `operated`: a console does.
pub const DISPENSABLE: &str = "MRROC_TEST_DISPENSABLE";
/// How long the arms of [`SOAK`] move \[s\].
pub const SECONDS: &str = "MRROC_SOAK";

/// The file, beside the records, of what the observers of [`TASKS`] have seen.
pub const SEEN: &str = "seen";
/// The file, beside the records, of what the MP of [`SOAK`] has counted.
pub const COUNT: &str = "steps";

/// Where the camera of [`REMOTE`] writes down which processes opened it.
pub const OPENED: &str = "opened";

/// What a controller of [`REMOTE`] says when it was told nothing for too long.
pub const NOT_TOLD: &str = "nobody told it anything";

/// The steps in which the allocations of a process of [`ARMS`] are counted.
pub const STEPS: u64 = 300;

/// How long the arms of [`SOAK`] move by default \[s\]: just long enough to measure the rate of their steps.
#[must_use]
pub fn seconds() -> u32 {
    std::env::var(SECONDS).ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(10)
}
