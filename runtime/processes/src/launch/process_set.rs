//! The processes of a launch.
//!
//! In: the places of the cell and a [`Plan`]. Out: processes that are started, connected and ready to run; at the end,
//! how each of them ended.

use core::cell::{Cell, RefCell};
use std::ffi::OsString;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::rc::Rc;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::board::figures::Figures;
use crate::control::{Control, Frame};
use crate::link::{Clock, Seal};
use crate::machine::scheduling::Lacks;
use crate::machine::signals::Signals;
use crate::session::Session;
use mrroc_core::cell::Rest;
use mrroc_core::cell::{Nodes, Permission};
use mrroc_core::console::complain;
use mrroc_core::fault::{Fault, FaultKind, ProcessId, Role};
use mrroc_core::link::Nanos;

/// How long a process may take to set itself up: long, because the machine may be loaded.
const SETTING_UP: Duration = Duration::from_secs(30);

/// Time that processes have to end after the cell closes, in addition to the time that its robots take to stop: this, and
/// so much for each process, because all of them end at once and share the machine's cores.
pub(crate) const CLOSING: Duration = Duration::from_secs(10);
const CLOSING_EACH: Duration = Duration::from_millis(250);

/// How long a process that has closed its connection may take to end.
const ENDING: Duration = Duration::from_millis(500);

/// The socket in a session's folder to which the launcher connects once for each process of another machine.
pub(crate) const FAR: &str = "far";

/// How the processes of a cell are started.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// The cell's file.
    pub cell: PathBuf,
    /// The arguments with which its processes are started.
    pub arguments: Vec<OsString>,
    /// The clock by which the cell runs.
    pub clock: Clock,
    /// How long a process polls for messages before it sleeps \[ns\].
    pub spin: Nanos,
    /// What to do when the machine does not grant what the cell asks for.
    pub permission: Permission,
    /// Whether processes print errors only.
    pub quiet: bool,
    /// Whether the program's observers are in the plant, which then also reports the result of the run.
    pub watched: bool,
    /// The machines of the cell, if it is on several.
    pub nodes: Option<Nodes>,
    /// The file for how the run ends.
    pub outcome: Option<PathBuf>,
}

/// Why a process could not be set up. All other processes are ended, and no robot has moved.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoStart {
    /// A signal killed the process: another start may succeed.
    #[error("{0} ended while it started: {1}")]
    Died(ProcessId, String),
    /// Ctrl-C came while the process started: while it opened its robot, perhaps, whose controller does not answer.
    #[error("interrupted while {0} started")]
    Interrupted(ProcessId),
    /// The process ended by itself, and another start would end alike.
    #[error("{0} ended while it started: {1}")]
    Ended(ProcessId, String),
    /// The process refused to take part, for this reason.
    #[error("{0}: {1}")]
    Refuses(ProcessId, String),
    /// The process put together another cell than the launcher did.
    #[error(
        "{0} sees another cell than its launcher\n help: the program or cell.toml changed meanwhile: start again"
    )]
    OtherCell(ProcessId),
    /// The machine does not grant the process what the cell asks for.
    #[error(
        "{0} may not have {1}\n help: allow it, as root: setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM; or write permission = \"best effort\" in [realtime] of cell.toml"
    )]
    NotPermitted(ProcessId, Lacks),
    /// The process could not be started.
    #[error("{0} cannot be started: {1}{help}", help = crate::machine::capacity::remedy(.1))]
    Spawn(ProcessId, io::Error),
}

/// How a process ended.
#[derive(Clone, Debug)]
pub(crate) struct Over {
    pub steps: u64,
    pub time: Nanos,
    pub outcome: Option<Result<(), Fault>>,
}

/// One process of the cell, as its launcher holds it.
pub(crate) struct Member {
    pub id: ProcessId,
    pub control: Control,
    /// `None` for a process of another machine.
    child: RefCell<Option<Child>>,
    /// How a process of another machine has ended, as its node says.
    pub ended: RefCell<Option<String>>,
    pub over: RefCell<Option<Over>>,
    /// Its newest figures; in real time only.
    pub figures: Cell<Option<Figures>>,
    /// How robots of this process came to a standstill after their demands had stopped.
    pub rests: RefCell<Vec<Rest>>,
    /// Whether the launcher has waited for its end.
    pub gone: Cell<bool>,
}

impl Member {
    /// Starts a process of this machine.
    pub fn spawn(id: ProcessId, session: &Session, plan: &Plan) -> io::Result<Member> {
        let (ours, theirs) = UnixStream::pair()?;
        let mut command = Command::new("/proc/self/exe");
        if let Some(program) = std::env::args_os().next() {
            command.arg0(program);
        }
        // `ps` shows these arguments: the role, and the robot or sensor that it belongs to.
        command.args(id.to_string().split(' '));
        command.arg("--session").arg(session.folder()).args(&plan.arguments);
        // A process group of its own keeps Ctrl-C away from the process: only the launcher acts on it, so that a robot
        // does not lose its processes one by one.
        let child = command.stdin(Stdio::from(OwnedFd::from(theirs))).process_group(0).spawn()?;
        ours.set_read_timeout(Some(SETTING_UP))?;
        Ok(Member::new(id, Control::new(ours), Some(child)))
    }

    /// The process at a place that is on another machine, to which the carrier of this session speaks.
    fn far(id: ProcessId, place: usize, session: &Session) -> io::Result<Member> {
        let mut stream = UnixStream::connect(session.folder().join(FAR))?;
        stream.write_all(&(place as u64).to_le_bytes())?;
        stream.set_read_timeout(Some(SETTING_UP))?;
        Ok(Member::new(id, Control::new(stream), None))
    }

    fn new(id: ProcessId, control: Control, child: Option<Child>) -> Member {
        Member {
            id,
            control,
            child: RefCell::new(child),
            ended: RefCell::default(),
            over: RefCell::default(),
            figures: Cell::new(None),
            rests: RefCell::default(),
            gone: Cell::new(false),
        }
    }

    /// The number of the process; 0 for one of another machine.
    pub fn pid(&self) -> u32 {
        self.child.borrow().as_ref().map_or(0, Child::id)
    }

    /// How a process of this machine has ended, if it has.
    fn status(&self) -> io::Result<Option<ExitStatus>> {
        self.child.borrow_mut().as_mut().map_or(Ok(None), Child::try_wait)
    }

    /// Ends a process: at once on this machine; elsewhere its node does so, when it hears that its launcher is gone.
    fn end(&self) {
        match self.child.borrow_mut().as_mut() {
            // Killing fails if the process has ended just now.
            Some(child) => drop(child.kill()),
            None => self.control.hang_up(),
        }
    }

    /// How a process of another machine has ended.
    fn told_end(&self) -> String {
        self.ended.borrow().clone().unwrap_or_else(|| "nothing is known of it any more".to_owned())
    }

    /// Waits for a process whose end has come, and says how it ended. One that has closed its connection and goes on is
    /// killed.
    pub fn reap(&self) -> String {
        self.gone.set(true);
        if self.child.borrow().is_none() {
            return self.told_end();
        }
        let until = Instant::now() + ENDING;
        loop {
            match self.status() {
                Ok(Some(status)) => return how(status),
                Ok(None) if Instant::now() < until => {}
                Ok(None) => break,
                Err(error) => return error.to_string(),
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.end();
        match self.child.borrow_mut().as_mut().map(Child::wait) {
            Some(Ok(status)) => how(status),
            Some(Err(error)) => error.to_string(),
            None => self.told_end(),
        }
    }

    /// Whether its part of the run is over while the process still exists.
    pub fn is_over(&self) -> bool {
        !self.gone.get() && self.over.borrow().is_some()
    }

    /// Kills the process.
    pub fn kill(&self) {
        self.end();
        self.reap();
    }

    /// Sends the result of the run to the process and waits for its end. Returns its exit status; `None` if it was
    /// killed or could not be told.
    pub fn conclude(&self, steps: u64, time: Nanos, outcome: Result<(), Fault>) -> Option<u8> {
        let told = self.control.send(&Frame::Over { steps, time, outcome: Some(outcome) });
        self.gone.set(true);
        let status = self.child.borrow_mut().as_mut()?.wait().ok()?;
        told.ok().and(status.code()).and_then(|code| u8::try_from(code).ok())
    }

    /// The fault by which the death of this process stops the cell.
    pub fn death(&self, how: &str) -> Fault {
        Fault::new(FaultKind::PeerLost).in_process(self.id).text(how)
    }

    /// Waits for the next frame of the process while the cell is set up, or for Ctrl-C.
    fn expect(&self, signals: &Signals) -> Result<Frame, NoStart> {
        match self.next_but_figures(signals) {
            Ok(Frame::Refuses(text)) => Err(NoStart::Refuses(self.id, text)),
            Ok(Frame::Gone(how)) => Err(NoStart::Ended(self.id, how)),
            Ok(frame) => Ok(frame),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(NoStart::Interrupted(self.id)),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                Err(NoStart::Ended(self.id, format!("it did nothing for {} s", SETTING_UP.as_secs())))
            }
            Err(_) => {
                self.gone.set(true);
                let Some(ended) = self.child.borrow_mut().as_mut().map(Child::wait) else {
                    return Err(NoStart::Ended(self.id, self.told_end()));
                };
                Err(match ended {
                    Ok(status) if status.signal().is_some() => NoStart::Died(self.id, how(status)),
                    Ok(status) => NoStart::Ended(self.id, how(status)),
                    Err(error) => NoStart::Spawn(self.id, error),
                })
            }
        }
    }

    /// Waits until the process says something: [`io::ErrorKind::Interrupted`] if Ctrl-C comes before, and
    /// [`io::ErrorKind::WouldBlock`] after the time in which it should have been set up.
    fn wait(&self, signals: &Signals) -> io::Result<()> {
        let until = Instant::now() + SETTING_UP;
        while !signals.ends() {
            let left = until.saturating_duration_since(Instant::now());
            let mut ready = [
                PollFd::from_borrowed_fd(self.control.descriptor(), PollFlags::IN),
                PollFd::from_borrowed_fd(signals.descriptor(), PollFlags::IN),
            ];
            match poll(&mut ready, Timespec::try_from(left).ok().as_ref()) {
                Ok(0) => return Err(io::ErrorKind::WouldBlock.into()),
                Ok(_) if !ready[0].revents().is_empty() => return Ok(()),
                // Ctrl-Z suspends what runs, and nothing runs yet.
                Ok(_) => signals.clear(),
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Err(io::ErrorKind::Interrupted.into())
    }

    /// What the process says next. One that opens its drives says its figures once a second meanwhile: they do not count.
    fn next_but_figures(&self, signals: &Signals) -> io::Result<Frame> {
        for _ in 0..SETTING_UP.as_secs() {
            self.wait(signals)?;
            match self.control.receive()? {
                Frame::Figures(_) => {}
                frame => return Ok(frame),
            }
        }
        Err(io::ErrorKind::WouldBlock.into())
    }
}

/// `killed by signal 9`, `status 1`.
fn how(status: ExitStatus) -> String {
    match (status.signal(), status.code()) {
        (Some(signal), _) => format!("it was killed by signal {signal}"),
        (None, Some(code)) => format!("it ended with status {code}"),
        (None, None) => "it ended".to_owned(),
    }
}

/// What processes are started with.
pub(super) struct Start<'a> {
    pub plan: &'a Plan,
    /// Of the cell that the launcher has put together: the processes put together the same.
    pub fingerprint: u64,
    pub session: &'a Session,
    /// Which start of the session this is.
    pub epoch: u64,
    /// Ctrl-C ends it.
    pub signals: &'a Signals,
}

impl Start<'_> {
    /// What a process is told first.
    fn welcome(&self) -> Frame {
        let seal = Seal { session: self.session.number(), epoch: self.epoch };
        let Plan { clock, spin, .. } = *self.plan;
        Frame::Welcome { seal, cell: self.session.cell(), clock, spin }
    }

    /// Starts the carrier, and waits until it has found all other machines ready.
    fn carrier(&self, id: ProcessId) -> Result<Rc<Member>, NoStart> {
        let carrier =
            Member::spawn(id, self.session, self.plan).map_err(|error| NoStart::Spawn(id, error))?;
        drop(carrier.control.send_now(&self.welcome()));
        match carrier.expect(self.signals) {
            Ok(Frame::Created { fingerprint }) if fingerprint == self.fingerprint => Ok(Rc::new(carrier)),
            Ok(_) => {
                carrier.kill();
                Err(NoStart::OtherCell(id))
            }
            Err(error) => {
                carrier.kill();
                Err(error)
            }
        }
    }
}

/// All processes of a launch. Dropping it ends those that still run: once robots may move, it hangs up, by which
/// each process closes the cell, and waits until robots have braked, before it kills anything.
pub(super) struct ProcessSet {
    /// The processes by their places.
    pub members: Vec<Rc<Member>>,
    /// How long the robots may take to stop.
    stop: Duration,
    /// Whether the processes were told to run.
    runs: Cell<bool>,
}

impl ProcessSet {
    /// Starts the processes at `places` and connects them. They then wait for [`go`](ProcessSet::go). Their robots take up
    /// to `stop` for a stop.
    pub fn start(places: &[ProcessId], stop: Duration, start: &Start) -> Result<ProcessSet, NoStart> {
        let mut process_set = ProcessSet { members: Vec::new(), stop, runs: Cell::new(false) };
        let Start { plan, session, .. } = *start;
        // Nothing is started here before all other machines are ready for it.
        let carrier = match plan.nodes.as_ref().and_then(Nodes::first) {
            Some(node) => Some(start.carrier(ProcessId::new(Role::Node, node.name))?),
            None => None,
        };
        for (place, &id) in places.iter().enumerate() {
            let is_far =
                plan.nodes.as_ref().is_some_and(|nodes| nodes.of(id).is_some_and(|node| node != nodes.mp()));
            let member =
                if is_far { Member::far(id, place, session) } else { Member::spawn(id, session, plan) };
            process_set.members.push(Rc::new(member.map_err(|error| NoStart::Spawn(id, error))?));
        }
        // Behind the others, so that these are at their places.
        process_set.members.extend(carrier);
        match process_set.set_up(start) {
            Ok(()) => Ok(process_set),
            Err(interrupted @ NoStart::Interrupted(_)) => Err(interrupted),
            // If a process has died, its death is the reason for the other processes' errors.
            Err(error) => Err(process_set.first_dead().unwrap_or(error)),
        }
    }

    fn set_up(&self, start: &Start) -> Result<(), NoStart> {
        let Start { plan, fingerprint, signals, .. } = *start;
        let welcome = start.welcome();
        let others = || self.members.iter().filter(|member| member.id.role != Role::Node);
        for member in others() {
            drop(member.control.send_now(&welcome));
        }
        for member in others() {
            if member.expect(signals)? != (Frame::Created { fingerprint }) {
                return Err(NoStart::OtherCell(member.id));
            }
        }
        self.tell(&Frame::Connect);
        let mut lacking = Lacks::default();
        for member in &self.members {
            let Frame::Ready { lacks } = member.expect(signals)? else {
                return Err(NoStart::OtherCell(member.id));
            };
            if lacks.is_nothing() {
                continue;
            }
            if plan.permission == Permission::Required {
                return Err(NoStart::NotPermitted(member.id, lacks));
            }
            lacking = lacking.and(lacks);
        }
        if !lacking.is_nothing() && !plan.quiet {
            complain(&format!("note: best effort: not every process has {lacking}"));
        }
        Ok(())
    }

    /// A process that was killed while it was set up.
    fn first_dead(&self) -> Option<NoStart> {
        self.members.iter().filter(|member| !member.gone.get()).find_map(|member| {
            let status = member.status().ok()??;
            // A process that refused has sent its reason and ends by itself, with a status and not by a signal.
            status.signal().map(|_| NoStart::Died(member.id, how(status)))
        })
    }

    /// The newest figures of all processes that have reported any.
    pub fn figures(&self) -> Vec<(ProcessId, Figures)> {
        self.members.iter().filter_map(|member| Some((member.id, member.figures.get()?))).collect()
    }

    /// Time that the processes have to end after the cell closes, in addition to the time that its robots take to stop.
    pub fn closing(&self) -> Duration {
        CLOSING + CLOSING_EACH * self.members.len().try_into().unwrap_or(u32::MAX)
    }

    /// Lets the processes run. The cell's time begins at `origin` of the machine's monotonic clock \[ns\].
    pub fn go(&self, origin: Nanos) {
        self.runs.set(true);
        self.tell(&Frame::Go { origin });
    }

    /// Sends a frame to all processes whose part is not over. A frame to a process that has just died is lost; its
    /// death is noticed at the end of its stream. So is one to a process that has read nothing for a long time.
    pub fn tell(&self, frame: &Frame) {
        for member in
            self.members.iter().filter(|member| !member.gone.get() && member.over.borrow().is_none())
        {
            drop(member.control.send_now(frame));
        }
    }

    /// Sends a frame to the MP.
    pub fn tell_mp(&self, frame: &Frame) {
        if let Some(mp) = self.members.iter().find(|member| member.id == ProcessId::MP && !member.gone.get())
        {
            drop(mp.control.send_now(frame));
        }
    }

    /// Sends a frame to the MP of the lower cell that a process is in.
    pub fn tell_mp_of(&self, process: ProcessId, frame: &Frame) {
        let mp = ProcessId { name: process.cell(), ..ProcessId::MP };
        if let Some(mp) = self.members.iter().find(|member| member.id == mp && !member.gone.get()) {
            drop(mp.control.send_now(frame));
        }
    }

    /// The plant, if its part is over and it waits for the result of the run.
    pub fn plant_over(&self) -> Option<&Rc<Member>> {
        self.members.iter().find(|member| member.id.role == Role::Plant && member.is_over())
    }

    /// Waits until `until` for all processes except `goes_on` to end, and kills those that have not ended by then.
    pub fn reap(&self, goes_on: Option<&Rc<Member>>, until: Instant) {
        let goes_on = goes_on.map(|member| member.id);
        for member in self.members.iter().filter(|member| !member.gone.get() && Some(member.id) != goes_on) {
            loop {
                if member.child.borrow().is_none() {
                    member.kill();
                    break;
                }
                if !matches!(member.status(), Ok(None)) {
                    member.reap();
                    break;
                }
                if Instant::now() > until {
                    member.kill();
                    break;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }
}

impl Drop for ProcessSet {
    fn drop(&mut self) {
        // A process that sets itself up moves nothing, and none of these is told to run any more.
        if self.runs.get() {
            self.members.iter().for_each(|member| member.control.hang_up());
            self.reap(None, Instant::now() + self.stop + self.closing());
        }
        self.members.iter().filter(|member| !member.gone.get()).for_each(|member| member.kill());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A process that brakes for some time after its launcher has hung up, and then says so in a file.
    fn braking(id: ProcessId, file: &std::path::Path) -> Rc<Member> {
        let (ours, theirs) = UnixStream::pair().expect("a pair of sockets");
        let script = format!("cat >{0}.read; sleep 0.3; echo stands >{0}", file.display());
        let child =
            Command::new("sh").args(["-c", &script]).stdin(Stdio::from(OwnedFd::from(theirs))).spawn();
        Rc::new(Member::new(id, Control::new(ours), Some(child.expect("a process"))))
    }

    #[test]
    fn fault_62_processes_that_move_robots_are_killed_after_their_robots_have_braked_and_no_sooner() {
        let folder = std::env::temp_dir().join(format!("mrroc-drop-{}", std::process::id()));
        std::fs::create_dir(&folder).expect("a folder");
        for (runs, told) in [(true, Some("stands\n".to_owned())), (false, None)] {
            let file = folder.join(if runs { "runs" } else { "starts" });
            let edp = braking(ProcessId::PLANT, &file);
            let set =
                ProcessSet { members: vec![edp], stop: Duration::from_secs(60), runs: Cell::new(false) };
            if runs {
                set.go(0);
            }
            drop(set);
            assert_eq!(std::fs::read_to_string(&file).ok(), told, "runs: {runs}");
        }
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
