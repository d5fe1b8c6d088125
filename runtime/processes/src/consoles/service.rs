//! The thread of the console server.
//!
//! In: requests of all consoles, and the state board. Out: presses for the MP; answers and pictures for the consoles.
//!
//! So many consoles are served at a time. A further one waits for a place, and may stop or abort the cell meanwhile: a
//! place becomes free when a console disconnects, or has connected without asking for anything. Whoever does not get one
//! is told so. All consoles take turns, with one request each.
//!
//! One press of each kind of button is under way at a time, and the MP carries out one of each kind in a step, so that
//! the MP's work does not grow with the number of consoles and presses. Waiting presses of the same button share one
//! press and its answer. The thread reads from the MP's entry on the state board what the MP did, so that the MP sends
//! no answers.

use std::collections::BTreeSet;
use std::os::unix::net::{UnixListener, UnixStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt::socket_peercred;

use super::beside::{BodyPicture, CarriedPicture, ReadingPicture};
use super::console::{Console, PendingRequest};
use super::mp_session::MpSession;
use super::picture::{CellPicture, Picture, ProcessPicture, RobotPicture};
use crate::board::StateBoard;
use crate::board::entry::{self, MpPanel, RobotEntry, ecp};
use crate::board::figures::Figures;
use crate::control::Frame;
use crate::link::monotonic;
use mrroc_core::console::complain;
use mrroc_core::fault::{Fault, Name, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::observe::recording::{Command, CommandRecord};
use mrroc_core::operator::button::Button;
use mrroc_core::operator::jog::JogStop;
use mrroc_core::operator::request::Addressed;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::operator::{Answer, CellState, Request};

/// The most consoles that are served at a time.
const CONSOLES: usize = 128;

/// The most consoles that wait for a place. What is beyond waits in the queue of the socket.
const WAITING: usize = 32;

/// The most connections of consoles.
pub(crate) const CONNECTIONS: usize = CONSOLES + WAITING;

/// How long a console without a place may take to send its request.
const TURN: Duration = Duration::from_millis(250);

/// How long a console that has not asked for anything keeps its place while others wait for one.
const IDLE: Duration = Duration::from_secs(1);

/// What a console is told that gets no place.
const TOO_MANY: &str = "there are too many consoles: ask again; stop, abort and let-go are always taken";

/// How many other users are told of.
const STRANGERS: usize = 16;

/// The shortest time between two rounds, so that a flood of requests does not keep a core busy; one that comes alone waits for nothing.
const ROUND: Duration = Duration::from_millis(1);

/// How often the server looks for the answer to a press that is under way.
const LOOK: Duration = Duration::from_millis(2);

/// The time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);

/// A process of the cell, and whether it runs.
pub(super) struct Seat {
    pub id: ProcessId,
    pub pid: u32,
    pub runs: bool,
    pub figures: Figures,
}

/// The state of the console server's thread.
pub(super) struct Service {
    pub listeners: Vec<UnixListener>,
    pub end: UnixStream,
    pub board: StateBoard,
    pub seats: Arc<Mutex<Vec<Seat>>>,
    pub presses: Sender<(ProcessId, Frame)>,
    pub waker: UnixStream,
    pub consoles: Vec<Console>,
    /// The MPs that can be asked, the uppermost one first.
    pub sessions: Vec<MpSession>,
    pub ids: u64,
    /// Users whose consoles were refused; each is reported once.
    pub strangers: BTreeSet<u32>,
    /// Where commands are recorded.
    pub record: Option<Box<dyn CommandRecord>>,
    /// When the cell's time began, on the machine's clock \[ns\]; 0 before it is known.
    pub origin: Arc<AtomicU64>,
    /// When the last round began.
    pub round: Instant,
}

impl Service {
    /// Serves until the handle of the console server is dropped.
    pub fn run(mut self) {
        while self.wait() {
            self.sessions.iter_mut().for_each(|session| session.drawn = None);
            self.accept();
            self.give_places();
            for i in 0..self.consoles.len() {
                self.serve(i);
            }
            for session in 0..self.sessions.len() {
                self.look_after_presses(session);
                self.press(session);
            }
            self.show();
            self.record_commands();
            self.consoles.retain(|console| !console.is_over());
            let there = |id| self.consoles.iter().any(|console| console.id == id);
            self.sessions
                .iter_mut()
                .for_each(|session| session.holder = session.holder.filter(|&id| there(id)));
        }
        // Nobody answers any more what has not been answered yet.
        self.consoles.iter_mut().for_each(|console| console.gone = true);
        self.record_commands();
    }

    /// Records what was asked for, by the cell's time. Before that has begun it is kept.
    fn record_commands(&mut self) {
        let origin = self.origin.load(Ordering::Acquire);
        if self.record.is_some() && (origin == 0 || monotonic() < origin) {
            return;
        }
        for command in self.consoles.iter_mut().flat_map(Console::take_commands) {
            let Some(record) = &self.record else { continue };
            let since = |time: Nanos| time.saturating_sub(origin);
            record.put(Command { asked: since(command.asked), answered: since(command.answered), ..command });
        }
    }

    /// Waits until something is to be done; returns whether the console server is still open.
    fn wait(&mut self) -> bool {
        let time = self.next_round();
        let mut all = vec![PollFd::new(&self.end, PollFlags::IN)];
        let accepts = if self.waiting() < WAITING { PollFlags::IN } else { PollFlags::empty() };
        all.extend(self.listeners.iter().map(|listener| PollFd::new(listener, accepts)));
        let others = all.len();
        all.extend(self.consoles.iter().map(|console| {
            let mut flags = PollFlags::empty();
            flags.set(PollFlags::IN, console.is_listened_to());
            flags.set(PollFlags::OUT, console.is_written_to());
            PollFd::from_borrowed_fd(console.descriptor(), flags)
        }));
        let time = time.and_then(|time| Timespec::try_from(time).ok());
        if poll(&mut all, time.as_ref()).is_err() {
            return true;
        }
        std::thread::sleep(ROUND.saturating_sub(self.round.elapsed()));
        self.round = Instant::now();
        let came: Vec<_> = all.iter().map(PollFd::revents).collect();
        for (console, came) in self.consoles.iter_mut().zip(&came[others..]) {
            console.gone |= came.intersects(PollFlags::ERR | PollFlags::NVAL)
                || (came.contains(PollFlags::HUP) && !came.contains(PollFlags::IN));
            if came.contains(PollFlags::OUT) {
                console.flush();
            }
            if came.contains(PollFlags::IN) {
                console.read();
            }
        }
        came[0].is_empty()
    }

    /// How long to wait if nothing comes meanwhile.
    fn next_round(&self) -> Option<Duration> {
        let ready = |console: &Console| console.has_line() && console.asked == PendingRequest::Nothing;
        if self.consoles.iter().any(|console| ready(console) && !console.is_written_to()) {
            return Some(Duration::ZERO);
        }
        let waits = |console: &Console| console.asked != PendingRequest::Nothing;
        let look = self.consoles.iter().any(waits).then_some(LOOK);
        let due = self.consoles.iter().filter_map(|console| console.watches).min();
        let due = due.map(|due| due.saturating_duration_since(Instant::now()));
        // Those that wait for a place are looked at from time to time.
        let turn = (self.waiting() > 0).then_some(TURN / 5);
        look.into_iter().chain(due).chain(turn).min()
    }

    /// How many consoles wait for a place.
    fn waiting(&self) -> usize {
        self.consoles.iter().filter(|console| !console.is_served).count()
    }

    /// Accepts new consoles of the user to whom the cell belongs, and refuses those of other users; one of each listener in
    /// turn, so that nobody who connects to one of them keeps others from another one.
    fn accept(&mut self) {
        for _ in 0..WAITING {
            // From the listener after the last one that had its turn.
            for _ in 0..self.listeners.len() {
                if self.waiting() >= WAITING {
                    return;
                }
                self.listeners.rotate_left(1);
                let accepted = self.listeners.last().map(UnixListener::accept);
                if let Some(Ok((stream, _))) = accepted {
                    self.welcome(stream);
                }
            }
        }
    }

    fn welcome(&mut self, stream: UnixStream) {
        let Ok(peer) = socket_peercred(&stream) else { return };
        let user = peer.uid.as_raw();
        let pid = peer.pid.as_raw_nonzero().get().unsigned_abs();
        self.ids += 1;
        let Ok(mut console) = Console::new(self.ids, pid, stream) else { return };
        if user == rustix::process::getuid().as_raw() {
            self.consoles.push(console);
            return;
        }
        console.write(&format!("refused the cell belongs to another user than {user}\n"));
        if self.strangers.len() < STRANGERS && self.strangers.insert(user) {
            complain(&format!("note: operator: process {pid} of user {user} was refused"));
        }
    }

    /// Gives free places to the consoles that wait, in the order in which they came; if there are too few, those that have
    /// connected without asking for anything lose theirs.
    fn give_places(&mut self) {
        let free = CONSOLES.saturating_sub(self.consoles.len() - self.waiting());
        for console in self.consoles.iter_mut().filter(|console| !console.is_served).take(free) {
            console.is_served = true;
        }
        if self.waiting() == 0 {
            return;
        }
        let refused = Answer::Refused(TOO_MANY.to_owned());
        for console in &mut self.consoles {
            let (timeout, may_stay) = match console.is_served {
                true => (IDLE, console.has_asked),
                false => (TURN, console.asked != PendingRequest::Nothing),
            };
            if !may_stay && !console.has_line() && console.since.elapsed() > timeout {
                console.dismiss(&refused);
            }
        }
    }

    /// Answers a console's request, or notes the press that it waits for.
    fn serve(&mut self, i: usize) {
        let Some(line) = self.consoles[i].line() else { return };
        let (session, request) = match Addressed::read(&line) {
            Ok(addressed @ Addressed { cell, request, .. }) => {
                self.consoles[i].gives(&addressed);
                match self.sessions.iter().position(|session| session.mp.name == cell) {
                    Some(session) => (session, Ok(request)),
                    None => (0, Err(self.no_cell(cell))),
                }
            }
            Err(refused) => (0, Err(refused.in_a_line())),
        };
        self.consoles[i].session = session;
        let is_for_all = matches!(request, Ok(Request::Press(button)) if button.is_for_all());
        if !self.consoles[i].is_served && !is_for_all {
            return self.consoles[i].dismiss(&Answer::Refused(TOO_MANY.to_owned()));
        }
        let answer = match request {
            Err(refused) => Some(Answer::Refused(refused)),
            Ok(Request::Status) => {
                let picture = self.drawn(session);
                return self.consoles[i].write(&picture);
            }
            Ok(Request::Watch) => {
                self.consoles[i].watches = Some(Instant::now());
                self.consoles[i].watched = session;
                None
            }
            Ok(Request::Take) => Some(
                self.take(i, session)
                    .err()
                    .unwrap_or_else(|| Answer::Done("this console holds the control token".to_owned())),
            ),
            Ok(Request::Release) if self.sessions[session].holder == Some(self.consoles[i].id) => {
                self.sessions[session].holder = None;
                Some(Answer::Done("nobody holds the control token".to_owned()))
            }
            Ok(Request::Release) => {
                Some(Answer::Refused("this console does not hold the control token".to_owned()))
            }
            Ok(Request::Press(button)) => self.may_press(i, session, button).err(),
        };
        if let Some(answer) = answer {
            self.consoles[i].answer(&answer);
        }
    }

    /// Gives a console the control token, unless another one holds it.
    fn take(&mut self, i: usize, session: usize) -> Result<(), Answer> {
        let id = self.consoles[i].id;
        let holder = self.sessions[session].holder;
        let holds = |console: &&Console| Some(console.id) == holder && console.id != id && !console.is_over();
        match self.consoles.iter().find(holds) {
            Some(holder) => {
                let text = format!("the console of process {} holds the control token", holder.pid);
                Err(Answer::Refused(text))
            }
            None => {
                self.sessions[session].holder = Some(id);
                Ok(())
            }
        }
    }

    fn may_press(&mut self, i: usize, session: usize, button: Button) -> Result<(), Answer> {
        if !button.is_for_all() {
            self.take(i, session)?;
        }
        // An abort that is kept until the next instruction begins would abort an instruction that the operator did not
        // mean.
        if button == Button::Abort && self.mp(session).is_some_and(|mp| mp.state == CellState::Idle) {
            return Err(Answer::Refused(button.reason(CellState::Idle).to_owned()));
        }
        self.consoles[i].asked = PendingRequest::Press(button);
        Ok(())
    }

    /// Sends pictures to the consoles that watch and have read the earlier ones.
    fn show(&mut self) {
        let now = Instant::now();
        let due = |console: &Console| console.watches.is_some_and(|due| due <= now);
        if !self.consoles.iter().any(due) {
            return;
        }
        for i in 0..self.consoles.len() {
            if due(&self.consoles[i]) {
                let picture = self.drawn(self.consoles[i].watched);
                let console = &mut self.consoles[i];
                console.watches = Some(now + PICTURE);
                if !console.is_written_to() {
                    console.write(&picture);
                }
            }
        }
    }

    fn seats(&self) -> MutexGuard<'_, Vec<Seat>> {
        // A seat is valid even if a thread panicked while it held the lock.
        self.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn mp_runs(&self, session: usize) -> bool {
        let mp = self.sessions[session].mp;
        self.seats().iter().any(|seat| seat.id == mp && seat.runs)
    }

    /// What the MP shows on the state board.
    pub fn mp(&self, session: usize) -> Option<MpPanel> {
        let mp = self.sessions[session].mp;
        let place = self.seats().iter().position(|seat| seat.id == mp)?;
        self.board.read(place).map(|words| MpPanel::read(&words))
    }

    /// Why no cell of this name can be asked.
    fn no_cell(&self, cell: Option<Name>) -> String {
        let cell = cell.map_or_else(String::new, |cell| cell.to_string());
        let names: Vec<_> =
            self.sessions.iter().filter_map(|session| Some(session.mp.name?.to_string())).collect();
        match names.is_empty() {
            true => format!("there is no lower cell `{cell}` here, nor any other"),
            false => format!("there is no lower cell `{cell}`: there are {}", names.join(", ")),
        }
    }

    /// The picture as text, drawn once a round however many consoles ask for it.
    fn drawn(&mut self, session: usize) -> Arc<str> {
        let drawn =
            self.sessions[session].drawn.take().unwrap_or_else(|| self.picture(session).to_string().into());
        self.sessions[session].drawn.insert(drawn).clone()
    }

    /// What the program of a robot's ECP shows on the state board: what it does, by which generator or condition, and why the
    /// robot stands though it is jogged.
    fn program_of(&self, seats: &[Seat], robot: Name) -> (InstructionKind, String, JogStop) {
        let id = ProcessId::new(Role::Ecp, robot);
        let place = seats.iter().position(|seat| seat.id == id);
        let shown = place.and_then(|place| self.board.read(place));
        shown.map(|words| ecp(&words)).unwrap_or_default()
    }

    /// What the lower cells of a cell do.
    fn cells(&self, of: &MpSession) -> Vec<CellPicture> {
        let lower = |(place, session): (usize, &MpSession)| {
            let name = session.mp.name.filter(|_| session.mp != of.mp && of.has(session.mp))?;
            let mp = self.mp(place).unwrap_or_default();
            Some(CellPicture {
                name: name.to_string(),
                state: mp.state,
                step: mp.step,
                period: mp.period,
                rate: mp.rate,
                speed: mp.speed,
                doing: mp.doing,
                by: mp.by,
                fault: mp.fault.as_ref().map(one_line),
            })
        };
        self.sessions.iter().enumerate().filter_map(lower).collect()
    }

    fn picture(&self, session: usize) -> Picture {
        let mp = self.mp(session).unwrap_or_default();
        let session = &self.sessions[session];
        let holder = self.consoles.iter().find(|console| Some(console.id) == session.holder);
        let mut picture = Picture {
            state: mp.state,
            step: mp.step,
            period: mp.period,
            epoch: mp.epoch,
            rate: mp.rate,
            speed: mp.speed,
            reduced: mp.reduced,
            held: mp.held,
            instructions: mp.instructions,
            doing: mp.doing,
            by: mp.by,
            holder: holder.map(|console| console.pid),
            help: mp.fault.as_ref().and_then(Fault::help).map(str::to_owned),
            fault: mp.fault.as_ref().map(one_line),
            persisting: mp.persisting.as_ref().map(one_line),
            cells: self.cells(session),
            ..Picture::default()
        };
        let seats = self.seats();
        let mut own = 0;
        for (place, seat) in seats.iter().enumerate().filter(|(_, seat)| session.has(seat.id)) {
            let name = seat.id.to_string();
            picture.processes.push(ProcessPicture {
                name,
                pid: seat.pid,
                runs: seat.runs,
                figures: seat.figures,
            });
            let shown = self.board.read(place);
            match (seat.id.role, seat.id.name, &shown) {
                (Role::Vsp, Some(sensor), Some(words)) => {
                    picture.readings.extend(entry::reading(words).map(|(step, words)| ReadingPicture {
                        sensor: sensor.to_string(),
                        step,
                        words,
                    }))
                }
                (Role::Plant, _, Some(words)) => {
                    let body = |place| Some(BodyPicture { place, pose: entry::body_at(words, place)? });
                    picture.bodies.extend((0..entry::BODIES).filter_map(body));
                }
                _ => {}
            }
            let Some(name) = seat.id.name.filter(|_| seat.id.role == Role::Edp) else { continue };
            // Its place among the robots of its own cell: the MP goes by that.
            let nth = (session.mp.name == name.cell()).then_some(own);
            own += usize::from(nth.is_some());
            let carried = shown.as_ref().and_then(entry::carried);
            picture.carried.extend(carried.map(|(tool, load, signals)| CarriedPicture {
                robot: name.to_string(),
                tool,
                load,
                signals,
            }));
            let robot = shown.as_ref().and_then(RobotEntry::read);
            if let Some(RobotEntry { time, demanded, measured, tool }) = robot {
                let (doing, by, stop) = self.program_of(&seats, name);
                let jogs = nth
                    .is_some_and(|nth| mp.jogs.get(nth / 64).is_some_and(|word| word & 1 << (nth % 64) != 0));
                let stop = mp.jogged.filter(|(place, _)| Some(*place) == nth).map_or(stop, |(_, stop)| stop);
                picture.robots.push(RobotPicture {
                    name: name.to_string(),
                    time,
                    demanded,
                    measured,
                    tool,
                    doing,
                    by,
                    jogs,
                    stop,
                });
            }
        }
        picture
    }
}

/// A fault in one line: a program's text of it may have several.
fn one_line(fault: &Fault) -> String {
    fault.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
