//! The processes of a launch: started, connected, reaped.

use core::cell::{Cell, RefCell};
use std::ffi::OsString;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::control::{Control, Frame};
use super::figures::Figures;
use super::scheduling::Lacks;
use super::session::Session;
use crate::iceoryx::{Clock, Seal};
use mrroc_core::cell::Permission;
use mrroc_core::cell::Rest;
use mrroc_core::fault::{Fault, FaultKind, ProcessId, Role};
use mrroc_core::link::Nanos;

/// How long a process may take to set itself up: a loaded machine is no reason to give up.
const SETTING_UP: Duration = Duration::from_secs(30);

/// How the processes of a cell are started.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// The cell's file.
    pub cell: PathBuf,
    /// What its processes are started with.
    pub arguments: Vec<OsString>,
    /// Whose time the cell runs in.
    pub clock: Clock,
    /// How long a process looks for messages before it sleeps \[ns\].
    pub spin: Nanos,
    /// What to do when the machine does not permit what the cell asks of it.
    pub permission: Permission,
    /// Whether processes say nothing but errors.
    pub quiet: bool,
    /// Whether the plant has the program's observers, and tells of the run.
    pub watched: bool,
}

/// A process could not be set up; all others are ended, and nothing has moved.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoStart {
    /// It was killed: another start may succeed.
    #[error("{0} ended while it started: {1}")]
    Died(ProcessId, String),
    /// It ended by itself, and would again.
    #[error("{0} ended while it started: {1}")]
    Ended(ProcessId, String),
    /// It says why not.
    #[error("{0}: {1}")]
    Refuses(ProcessId, String),
    /// It is of another program.
    #[error(
        "{0} sees another cell than its launcher\n help: the program or cell.toml changed meanwhile: start again"
    )]
    OtherCell(ProcessId),
    /// The machine does not give it what the cell asks for.
    #[error(
        "{0} may not have {1}\n help: allow it, as root: setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM; or write permission = \"best effort\" in [realtime] of cell.toml"
    )]
    NotPermitted(ProcessId, Lacks),
    /// It could not be started.
    #[error("{0} cannot be started: {1}")]
    Spawn(ProcessId, io::Error),
}

/// How a process ended.
#[derive(Clone, Debug)]
pub(super) struct Over {
    pub steps: u64,
    pub time: Nanos,
    pub outcome: Option<Result<(), Fault>>,
}

/// One process.
pub(super) struct Member {
    pub id: ProcessId,
    pub control: Control,
    child: RefCell<Child>,
    pub over: RefCell<Option<Over>>,
    /// Its newest figures, in real time.
    pub figures: Cell<Option<Figures>>,
    /// How robots in it came to a standstill whose commands had stopped.
    pub rests: RefCell<Vec<Rest>>,
    /// It has been waited for.
    pub gone: Cell<bool>,
}

impl Member {
    fn spawn(id: ProcessId, session: &Session, plan: &Plan) -> io::Result<Member> {
        let (ours, theirs) = UnixStream::pair()?;
        let mut command = Command::new("/proc/self/exe");
        if let Some(program) = std::env::args_os().next() {
            command.arg0(program);
        }
        // What `ps` shows: its role and whose it is.
        command.args(id.to_string().split(' '));
        command.arg("--session").arg(session.folder()).args(&plan.arguments);
        // Ctrl-C is the launcher's to act on: a robot must not lose its processes one by one.
        let child = command.stdin(Stdio::from(OwnedFd::from(theirs))).process_group(0).spawn()?;
        ours.set_read_timeout(Some(SETTING_UP))?;
        let (child, over) = (RefCell::new(child), RefCell::new(None));
        let (figures, rests, gone) = (Cell::new(None), RefCell::default(), Cell::new(false));
        Ok(Member { id, control: Control::new(ours), child, over, figures, rests, gone })
    }

    /// Its number.
    pub fn pid(&self) -> u32 {
        self.child.borrow().id()
    }

    /// Waits for its end, which has come; says how it ended.
    pub fn reap(&self) -> String {
        self.gone.set(true);
        match self.child.borrow_mut().wait() {
            Ok(status) => how(status),
            Err(error) => error.to_string(),
        }
    }

    /// Whether its part is over, and it is still there.
    pub fn is_over(&self) -> bool {
        !self.gone.get() && self.over.borrow().is_some()
    }

    /// Ends it at once.
    pub fn kill(&self) {
        // It may have ended just now.
        drop(self.child.borrow_mut().kill());
        self.reap();
    }

    /// Tells it how the cell has ended, and waits for what it makes of that; its exit status, unless it died of it.
    pub fn conclude(&self, steps: u64, time: Nanos, outcome: Result<(), Fault>) -> Option<u8> {
        let told = self.control.send(&Frame::Over { steps, time, outcome: Some(outcome) });
        self.gone.set(true);
        let status = self.child.borrow_mut().wait().ok()?;
        told.ok().and(status.code()).and_then(|code| u8::try_from(code).ok())
    }

    /// The fault that its death is.
    pub fn death(&self, how: &str) -> Fault {
        Fault::new(FaultKind::PeerLost).in_process(self.id).text(how)
    }

    /// Waits for an answer while the cell is set up.
    fn expect(&self) -> Result<Frame, NoStart> {
        match self.control.receive() {
            Ok(Frame::Refuses(text)) => Err(NoStart::Refuses(self.id, text)),
            Ok(frame) => Ok(frame),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                Err(NoStart::Ended(self.id, format!("it did nothing for {} s", SETTING_UP.as_secs())))
            }
            Err(_) => {
                self.gone.set(true);
                let ended = self.child.borrow_mut().wait();
                Err(match ended {
                    Ok(status) if status.signal().is_some() => NoStart::Died(self.id, how(status)),
                    Ok(status) => NoStart::Ended(self.id, how(status)),
                    Err(error) => NoStart::Spawn(self.id, error),
                })
            }
        }
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

/// All processes of a launch. Those that are left are ended with it.
pub(super) struct ProcessSet(pub Vec<Rc<Member>>);

impl ProcessSet {
    /// Starts the processes at `places` and connects them. They wait to be told to go.
    pub fn start(
        places: &[ProcessId],
        fingerprint: u64,
        session: &Session,
        epoch: u64,
        plan: &Plan,
    ) -> Result<ProcessSet, NoStart> {
        let mut process_set = ProcessSet(Vec::new());
        for &id in places {
            let member = Member::spawn(id, session, plan).map_err(|error| NoStart::Spawn(id, error))?;
            process_set.0.push(Rc::new(member));
        }
        match process_set.set_up(fingerprint, (session, epoch), plan) {
            Ok(()) => Ok(process_set),
            // One that died explains what another one lacks.
            Err(error) => Err(process_set.first_dead().unwrap_or(error)),
        }
    }

    fn set_up(
        &self,
        fingerprint: u64,
        (session, epoch): (&Session, u64),
        plan: &Plan,
    ) -> Result<(), NoStart> {
        let seal = Seal { session: session.number(), epoch };
        self.tell(&Frame::Welcome { seal, clock: plan.clock, spin: plan.spin });
        for member in &self.0 {
            if member.expect()? != (Frame::Created { fingerprint }) {
                return Err(NoStart::OtherCell(member.id));
            }
        }
        session.keep_others_out();
        self.tell(&Frame::Connect);
        let mut lacking = Lacks::default();
        for member in &self.0 {
            let Frame::Ready { lacks } = member.expect()? else { return Err(NoStart::OtherCell(member.id)) };
            if lacks.is_nothing() {
                continue;
            }
            if plan.permission == Permission::Required {
                return Err(NoStart::NotPermitted(member.id, lacks));
            }
            lacking = lacking.and(lacks);
        }
        if !lacking.is_nothing() && !plan.quiet {
            eprintln!("note: best effort: not every process has {lacking}");
        }
        Ok(())
    }

    /// A process that has ended while it was set up.
    fn first_dead(&self) -> Option<NoStart> {
        self.0.iter().filter(|member| !member.gone.get()).find_map(|member| {
            let status = member.child.borrow_mut().try_wait().ok()??;
            // One that refused has said so, and ends by itself.
            status.signal().map(|_| NoStart::Died(member.id, how(status)))
        })
    }

    /// The newest figures of all processes that have told any.
    pub fn figures(&self) -> Vec<(ProcessId, Figures)> {
        self.0.iter().filter_map(|member| Some((member.id, member.figures.get()?))).collect()
    }

    /// Tells all that are still at work. Whoever is gone does not hear it; that it is gone is seen elsewhere.
    pub fn tell(&self, frame: &Frame) {
        for member in self.0.iter().filter(|member| !member.gone.get() && member.over.borrow().is_none()) {
            drop(member.control.send(frame));
        }
    }

    /// Tells the MP.
    pub fn tell_mp(&self, frame: &Frame) {
        if let Some(mp) = self.0.iter().find(|member| member.id == ProcessId::MP && !member.gone.get()) {
            drop(mp.control.send(frame));
        }
    }

    /// The plant, if it has ended well and waits for what there is to tell of the run.
    pub fn plant_over(&self) -> Option<&Rc<Member>> {
        self.0.iter().find(|member| member.id.role == Role::Plant && member.is_over())
    }

    /// Waits for all, but for one that goes on, to end, at most until a time; ends those that have not.
    pub fn reap(&self, goes_on: Option<&Rc<Member>>, until: Instant) {
        let goes_on = goes_on.map(|member| member.id);
        for member in self.0.iter().filter(|member| !member.gone.get() && Some(member.id) != goes_on) {
            loop {
                let ended = member.child.borrow_mut().try_wait();
                if !matches!(ended, Ok(None)) {
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
        self.0.iter().filter(|member| !member.gone.get()).for_each(|member| member.kill());
    }
}
