//! A launch of the task program, for tests: its processes, the files that it leaves behind, and the demands of its
//! robots.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use mrroc_tests::fixture::{ARMS, COUNTS, PROGRAM, RECORDS};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// The file of how a launch in real time ended.
const OUTCOME: &str = "outcome.json";

/// The time after which anything counts as hanging.
const LIVENESS: Duration = Duration::from_secs(120);

/// A folder of a test: the cell, its sessions, the records of its robots.
pub struct Place {
    folder: PathBuf,
    program: &'static str,
}

impl Place {
    /// For the arms.
    pub fn new(test: u32) -> Place {
        Place::of(test, ARMS, include_str!("cell.toml"))
    }

    /// For this program and its cell. The folder's name is short, because names of sockets in it have 108 bytes.
    pub fn of(test: u32, program: &'static str, cell: &str) -> Place {
        let folder = PathBuf::from(format!("/tmp/mr{}-{test}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        fs::write(folder.join("cell.toml"), cell).expect("a file");
        Place { folder, program }
    }

    /// Writes another file beside that of the cell.
    pub fn write(&self, file: &str, text: &str) {
        fs::write(self.folder.join(file), text).expect("a file");
    }

    /// The program, in this folder. What is added to this command is an option of the test program.
    pub fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cell"));
        command
            .args(["--cell", "cell.toml"])
            .args(arguments)
            .arg("--")
            .arg(option(PROGRAM))
            .arg(self.program);
        command.current_dir(&self.folder).env("XDG_RUNTIME_DIR", &self.folder);
        command
    }

    /// Starts the program; its records go to a folder of this name.
    pub fn start(&self, records: &str, arguments: &[&str]) -> Launch {
        self.start_with(&[], records, arguments)
    }

    /// Starts the program; the counts of what its processes allocate go to a folder of this name.
    pub fn count(&self, counts: &str, arguments: &[&str]) -> Launch {
        let folder = self.records(counts);
        let mut program = self.telling(&folder, arguments);
        program.arg(option(COUNTS)).arg(&folder);
        self.spawn(program, folder)
    }

    /// Starts the program with these options of its own; its records go to a folder of this name.
    pub fn start_with(&self, options: &[(&str, &str)], records: &str, arguments: &[&str]) -> Launch {
        self.start_writing([None, None], options, records, arguments)
    }

    /// Starts the program with these outputs, or files of its records for its standard output and its standard error.
    pub fn start_writing(
        &self,
        [output, errors]: [Option<Stdio>; 2],
        options: &[(&str, &str)],
        records: &str,
        arguments: &[&str],
    ) -> Launch {
        let folder = self.records(records);
        let mut program = self.telling(&folder, arguments);
        program.arg(option(RECORDS)).arg(&folder);
        for (name, value) in options {
            program.arg(option(name)).args(Some(value).filter(|value| !value.is_empty()));
        }
        if let Some(output) = output {
            program.stdout(output);
        }
        if let Some(errors) = errors {
            program.stderr(errors);
        }
        self.spawn(program, folder)
    }

    /// Starts this command, whose messages go to a folder of this name.
    pub fn start_command(&self, mut program: Command, records: &str) -> Launch {
        let folder = self.records(records);
        let file = |name: &str| File::create(folder.join(name)).expect("a file");
        program.stdout(file("stdout")).stderr(file("stderr"));
        self.spawn(program, folder)
    }

    /// The program, whose messages go to a folder, and a file of its outcome where it runs processes.
    fn telling(&self, folder: &Path, arguments: &[&str]) -> Command {
        let outcome = folder.join(OUTCOME).display().to_string();
        let told: &[&str] = if arguments.contains(&"--processes") { &["--outcome", &outcome] } else { &[] };
        let mut program = self.program(&[arguments, told].concat());
        let file = |name: &str| File::create(folder.join(name)).expect("a file");
        program.stdout(file("stdout")).stderr(file("stderr"));
        program
    }

    /// The processes of its sessions, whoever their parent is.
    pub fn processes(&self) -> Vec<Process> {
        let all = fs::read_dir("/proc").expect("processes").flatten();
        let pids = all.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
        let base = self.base();
        let ours = pids.filter(|&pid| session(pid).is_some_and(|folder| folder.starts_with(&base)));
        let processes = ours.filter_map(|pid| Some(Process { pid, role: role(pid)? }));
        processes.filter(Process::is_alive).collect()
    }

    /// An empty folder of this name.
    fn records(&self, records: &str) -> PathBuf {
        let records = self.folder.join(records);
        let _ = fs::remove_dir_all(&records);
        fs::create_dir_all(&records).expect("a folder");
        records
    }

    fn spawn(&self, mut program: Command, records: PathBuf) -> Launch {
        let child = program.spawn().expect("the program starts");
        Launch { child, place: self.folder.clone(), records, seen: BTreeSet::new() }
    }

    /// The folder of the sessions.
    pub fn base(&self) -> PathBuf {
        self.folder.join("mrroc")
    }

    /// The sessions that there are.
    pub fn sessions(&self) -> BTreeSet<String> {
        sessions(&self.base())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

fn sessions(base: &Path) -> BTreeSet<String> {
    let names = fs::read_dir(base).into_iter().flatten().flatten();
    names.filter_map(|entry| entry.file_name().into_string().ok()).filter(|name| name.contains('-')).collect()
}

/// Segments of shared memory of a session.
pub fn segments(session: &str) -> Vec<String> {
    let number = session.split_once('-').expect("a session's name").1;
    let prefix = format!("mrroc_{number}_");
    let names = fs::read_dir("/dev/shm").expect("shared memory").flatten();
    names
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.starts_with(&prefix))
        .collect()
}

/// One process of a launch.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Process {
    pub pid: i32,
    /// `mp`, `ecp left` ..
    pub role: String,
}

impl Process {
    /// The name, the parent and the state of a process that is there.
    fn stat(pid: i32) -> Option<(i32, char)> {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
        Some((fields.next()?.chars().next()?, fields.next()?.parse().ok()?))
            .map(|(state, parent)| (parent, state))
    }

    /// Whether it still runs.
    pub fn is_alive(&self) -> bool {
        Process::stat(self.pid).is_some_and(|(_, state)| state != 'Z')
            && role(self.pid).as_ref() == Some(&self.role)
    }

    /// Kills it.
    pub fn kill(&self) {
        self.signal(Signal::KILL);
    }

    /// Sends it a signal, if its number still belongs to the same process.
    pub fn signal(&self, what: Signal) {
        if self.is_alive() {
            signal(self.pid, what);
        }
    }
}

fn role(pid: i32) -> Option<String> {
    let arguments = fs::read(format!("/proc/{pid}/cmdline")).ok()?;
    let words: Vec<_> = arguments.split(|&byte| byte == 0).skip(1).map(String::from_utf8_lossy).collect();
    let end = words.iter().position(|word| word == "--session")?;
    Some(words[..end].join(" "))
}

/// The folder of the session that a process is in.
fn session(pid: i32) -> Option<PathBuf> {
    let arguments = fs::read(format!("/proc/{pid}/cmdline")).ok()?;
    let mut words = arguments.split(|&byte| byte == 0);
    words.find(|word| *word == b"--session")?;
    Some(PathBuf::from(std::str::from_utf8(words.next()?).ok()?))
}

fn signal(pid: i32, signal: Signal) {
    if let Some(pid) = Pid::from_raw(pid) {
        let _ = kill_process(pid, signal);
    }
}

/// A launch.
pub struct Launch {
    child: Child,
    place: PathBuf,
    records: PathBuf,
    /// Sessions that it had.
    seen: BTreeSet<String>,
}

impl Launch {
    pub fn pid(&self) -> i32 {
        i32::try_from(self.child.id()).expect("a process's number")
    }

    /// The processes that the launcher has started and that still exist.
    pub fn processes(&mut self) -> Vec<Process> {
        self.look();
        let all = fs::read_dir("/proc").expect("processes").flatten();
        let pids = all.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
        let ours = pids.filter(|&pid| Process::stat(pid).is_some_and(|(parent, _)| parent == self.pid()));
        ours.filter_map(|pid| Some(Process { pid, role: role(pid)? })).collect()
    }

    fn look(&mut self) {
        self.seen.extend(sessions(&self.place.join("mrroc")));
    }

    /// Sleeps, and notes its sessions meanwhile.
    pub fn let_run(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.look();
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits until all `count` processes of a cell in lock-step are there, and lets its time stand still: its launcher waits for its MP,
    /// which is stopped, however long. [`thaw`](Launch::thaw) lets it go on.
    pub fn freeze(&mut self, count: usize) {
        assert!(self.comes_to(|launch| launch.processes().len() == count), "{}", self.said());
        self.mp().signal(Signal::STOP);
    }

    /// Lets a cell go on that was [frozen](Launch::freeze).
    pub fn thaw(&mut self) {
        self.mp().signal(Signal::CONT);
    }

    fn mp(&mut self) -> Process {
        self.processes().into_iter().find(|process| process.role == "mp").expect("it runs")
    }

    /// Sends a signal to the launcher.
    pub fn signal(&self, what: Signal) {
        signal(self.pid(), what);
    }

    /// Whether a signal has stopped the launcher.
    pub fn is_stopped(&self) -> bool {
        Process::stat(self.pid()).is_some_and(|(_, state)| state == 'T')
    }

    /// Waits until it has come so far; whether it has. It may be over before, since a machine that is late stops a cell.
    pub fn comes_to(&mut self, is_so: impl Fn(&mut Launch) -> bool) -> bool {
        let until = Instant::now() + LIVENESS;
        while !is_so(self) {
            assert!(Instant::now() < until, "it does not come: {}", self.said());
            if self.end_if_over().is_some() {
                return is_so(self);
            }
            self.let_run(Duration::from_millis(1));
        }
        true
    }

    /// How it ended, if it has.
    pub fn end_if_over(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("a child")
    }

    /// Waits for its end.
    pub fn end(&mut self) -> ExitStatus {
        let until = Instant::now() + LIVENESS;
        loop {
            self.look();
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status;
            }
            if Instant::now() > until {
                let left = self.processes();
                left.iter().for_each(Process::kill);
                let _ = self.child.kill();
                panic!("it does not end; left: {left:?}; said: {}", self.said());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// What it printed on its standard error.
    pub fn said(&self) -> String {
        self.text("stderr")
    }

    /// How it ended in real time, as the launcher wrote it; `Null` if it was refused, or could not write.
    pub fn outcome(&self) -> Value {
        serde_json::from_str(&self.text(OUTCOME)).unwrap_or_default()
    }

    /// The sessions that it had.
    pub fn had(&self) -> &BTreeSet<String> {
        &self.seen
    }

    /// The text of a file of its records; empty if the file does not exist.
    pub fn text(&self, file: &str) -> String {
        fs::read_to_string(self.records.join(file)).unwrap_or_default()
    }

    /// The lines of a robot's record; none when its EDP did not come so far.
    pub fn record(&self, robot: &str) -> Vec<String> {
        let text = self.text(robot);
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        text[..whole].lines().map(str::to_owned).collect()
    }

    /// What a robot's drives did, whichever process they were in.
    pub fn drives(&self, robot: &str) -> Vec<Period> {
        self.record(&format!("{robot}.plant")).iter().map(|line| Period::read(line)).collect()
    }

    /// Asserts that it has left no process, no file and no segment.
    pub fn assert_nothing_left(&self, processes: &[Process]) {
        wait_for_end(processes);
        for session in &self.seen {
            assert_eq!(segments(session), Vec::<String>::new(), "shared memory is left");
            assert!(!self.place.join("mrroc").join(session).exists(), "{session} is left");
        }
    }
}

impl Drop for Launch {
    fn drop(&mut self) {
        // A test that fails leaves no process behind.
        if let Ok(None) = self.child.try_wait() {
            for process in self.processes() {
                process.kill();
            }
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// A servo period of a robot's drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Period {
    /// Whether they had power, or their brakes applied.
    pub powered: bool,
    /// Whether their EDP has taken it away, at standstill.
    pub switched_off: bool,
    /// What the encoders read: positions \[rad\], then velocities [rad/s].
    pub measured: Vec<f64>,
}

impl Period {
    fn read(line: &str) -> Period {
        let mut words = line.split(' ');
        let did = words.next();
        let (powered, switched_off) = (did == Some("tick"), did == Some("off"));
        Period {
            powered,
            switched_off,
            measured: words.map(|word| word.parse().expect("a number")).collect(),
        }
    }

    /// Whether the robot moves at most at 1e-3 rad/s.
    pub fn stands(&self) -> bool {
        self.measured[self.measured.len() / 2..].iter().all(|velocity| velocity.abs() <= 1e-3)
    }
}

/// An option of the test program.
fn option(name: &str) -> String {
    format!("--{name}")
}

/// Whether the robots have had so many demands.
pub fn has_moved(periods: usize) -> impl Fn(&mut Launch) -> bool {
    move |launch| launch.record("left").len() >= periods
}

/// Waits for a condition that becomes true unless something hangs.
pub fn wait_until(mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + LIVENESS;
    while !is_so() {
        assert!(Instant::now() < until, "it does not come");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Waits until none of the processes exists.
pub fn wait_for_end(processes: &[Process]) {
    let until = Instant::now() + LIVENESS;
    while processes.iter().any(Process::is_alive) {
        assert!(
            Instant::now() < until,
            "left: {:?}",
            processes.iter().filter(|p| p.is_alive()).collect::<Vec<_>>()
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What a line of a record says was demanded.
pub fn demanded(line: &str) -> &str {
    line.split_once(' ').expect("a time and the joints").1
}

/// In how many of its last periods a robot's demands did not change.
pub fn periods_at_rest(record: &[String]) -> usize {
    let Some(last) = record.last() else { return 0 };
    record.iter().rev().take_while(|line| demanded(line) == demanded(last)).count()
}
