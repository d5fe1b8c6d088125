//! What tests and the task programs that they start as processes (`tests/cell/`) agree on: the names of the programs and of their
//! options, which stand behind `--` on the command line, and of files in the folders that some of these options name.

/// The option that chooses the program: [`ARMS`], [`TASKS`], [`SOAK`], [`CROWD`], [`LINE`], [`RECORDED`], [`REMOTE`] or
/// [`SERVO`].
pub const PROGRAM: &str = "program";
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

/// The option that names the folder for the records of the robots' demands, a file per robot.
pub const RECORDS: &str = "records";
/// The option that names the folder for the counts of processes, a file per role.
pub const COUNTS: &str = "counts";
/// The option that makes an EDP use another cell, with one robot more.
pub const OTHER: &str = "other";
/// The option that makes the MP's program compute for ever.
pub const COMPUTES: &str = "computes";
/// The option that makes the first step of a motion of each arm take half a second.
pub const PLANS: &str = "plans";
/// The option with the number by which the swing of [`ARMS`] is farther.
pub const FARTHER: &str = "farther";
/// The option with the number of times that [`ARMS`] go out and back before they swing.
pub const TIMES: &str = "times";
/// The option with the step in which [`ARMS`] and [`LINE`] are suspended, until a console resumes them.
pub const SUSPENDED: &str = "suspended";
/// The option with the time \[s\] for which a process of [`ARMS`] may compute at a stretch.
pub const TIMEOUT: &str = "timeout";
/// The option with what the drives of [`ARMS`] say that they are.
pub const HARDWARE: &str = "hardware";
/// The option with the path time \[s\] from which the swing differs from the recorded one.
pub const CHANGE: &str = "change";
/// The option that makes a picture take nothing of what processes show it.
pub const TAKES_NOTHING: &str = "takes-nothing";
/// The option that lets the MP of [`LINE`] go on without its left cell; `resets`: that one has a fault at first, and its operator
/// resets it; `operated`: a console does.
pub const DISPENSABLE: &str = "dispensable";
/// How long the arms of [`SOAK`] move \[s\].
pub const SECONDS: &str = "seconds";

/// The file, beside the records, of what the observers of [`TASKS`] have seen.
pub const SEEN: &str = "seen";
/// The file, beside the records, of what the MP of [`SOAK`] has counted.
pub const COUNT: &str = "steps";

/// Where the camera of [`REMOTE`] writes down which processes opened it.
pub const OPENED: &str = "opened";

/// The option that makes the controllers of [`REMOTE`] never answer, and the file beside the records that says that one is called.
pub const SILENT: &str = "silent";

/// What a controller of [`REMOTE`] says when it was told nothing for too long.
pub const NOT_TOLD: &str = "nobody told it anything";

/// The steps in which the allocations of a process of [`ARMS`] are counted.
pub const STEPS: u64 = 300;
