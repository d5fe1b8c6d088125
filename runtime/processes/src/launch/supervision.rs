//! The supervision of a cell in real time, from GO until all of its processes have ended.
//!
//! In: what processes send, signals from the terminal, buttons that consoles press, what the MP shows on the state board.
//! Out: frames to the processes, the launcher's heartbeat, and how the run ended. Nothing here waits for a terminal, a
//! console or a process: each round ends within the time between two beats.

use std::rc::Rc;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::ABORTING;
use super::ending::{Run, note};
use super::latch_notes::LatchNotes;
use super::mp_watch::{MpProgress, MpWatch, Still};
use super::process_set::{Member, Over, ProcessSet};
use crate::board::StateBoard;
use crate::board::entry::MpPanel;
use crate::board::heartbeat::BEAT;
use crate::consoles::ConsoleServer;
use crate::control::Frame;
use crate::link::monotonic;
use crate::machine::signals::{Signals, stop_until_continued};
use crate::session::is_stopped;
use mrroc_core::console::{complain, wait_until_written};
use mrroc_core::fault::{Fault, FaultKind, Name, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::operator::CellState;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::state::InstructionKind;

/// Time from GO to the beginning of step 0, long enough for all processes to receive GO.
const HEAD_START: Duration = Duration::from_millis(20);

/// The same where processes of other machines receive it, too.
const HEAD_START_OF_NODES: Duration = Duration::from_millis(300);

/// Time that a cell has to come to a standstill before its launcher stops, in addition to the time that its robots take.
const SUSPENDING: Duration = Duration::from_secs(5);

/// Time for the last messages before the launcher stops.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// The number of presses of the launcher itself, which no console waits for.
const OWN_PRESS: u64 = u64::MAX;

/// How long a cell may take for what its launcher waits for.
#[derive(Clone, Copy)]
pub(super) struct Timeouts {
    /// For a stop of its robots.
    pub stop: Duration,
    /// For the MP's program between two steps.
    pub computing: Duration,
}

/// The launcher while its cell runs.
pub(super) struct Supervision<'a> {
    process_set: &'a ProcessSet,
    signals: &'a Signals,
    console_server: &'a ConsoleServer,
    board: &'a StateBoard,
    mp: Option<usize>,
    timeout: Timeouts,
    /// The first process that died.
    death: Option<Fault>,
    /// Until when the MP's program has to end after an abort.
    aborting: Option<Instant>,
    /// Until when all processes have to end.
    closing: Option<Instant>,
    /// Until when the cell has to stand before the launcher stops.
    suspending: Option<Instant>,
    /// In how many rounds in a row the cell has stood since then.
    rounds_at_rest: u32,
    mp_watch: MpWatch,
    latch_notes: LatchNotes,
    /// Those of lower cells, with the places of their MPs.
    lower_notes: Vec<(usize, LatchNotes)>,
    /// Whether the cell is ended because its MP stands still.
    mp_is_still: bool,
    /// When the launcher last showed that it supervises.
    beat: Instant,
}

impl<'a> Supervision<'a> {
    /// Of processes that are ready to run.
    pub fn new(
        process_set: &'a ProcessSet,
        signals: &'a Signals,
        console_server: &'a ConsoleServer,
        board: &'a StateBoard,
        timeout: Timeouts,
        (latch_notes, lower_notes): (LatchNotes, Vec<LatchNotes>),
    ) -> Self {
        let at = |cell: Option<Name>| {
            process_set
                .members
                .iter()
                .position(|member| member.id == ProcessId { name: cell, ..ProcessId::MP })
        };
        let lower_notes =
            lower_notes.into_iter().filter_map(|notes| Some((at(notes.cell())?, notes))).collect();
        Supervision {
            process_set,
            signals,
            console_server,
            board,
            mp: process_set.members.iter().position(|member| member.id == ProcessId::MP),
            timeout,
            death: None,
            aborting: None,
            closing: None,
            suspending: None,
            rounds_at_rest: 0,
            mp_watch: MpWatch::new(timeout.computing),
            latch_notes,
            lower_notes,
            mp_is_still: false,
            beat: Instant::now(),
        }
    }

    /// Lets the processes run, and returns when all of them have ended or died; a plant that is `watched` waits for the
    /// result of the run instead.
    pub fn run(mut self, watched: bool) -> Run {
        self.board.heartbeat().beat();
        let has_nodes = self.process_set.members.iter().any(|member| member.id.role == Role::Node);
        let head_start = if has_nodes { HEAD_START_OF_NODES } else { HEAD_START };
        let origin = monotonic() + head_start.as_nanos() as Nanos;
        self.console_server.begins(origin);
        self.process_set.go(origin);
        loop {
            let waits = |member: &Member| watched && member.id.role == Role::Plant && member.is_over();
            let members = self.process_set.members.iter();
            let left: Vec<_> = members.filter(|member| !member.gone.get() && !waits(member)).collect();
            if left.is_empty() {
                return Run::of(self.process_set, self.death, None);
            }
            let came = self.wait(&left);
            self.hear_signals();
            self.pass_presses_on();
            for member in came {
                self.hear(member);
            }
            if self.beat.elapsed() >= BEAT {
                self.beat = Instant::now();
                self.board.heartbeat().beat();
                self.look_at_mp();
                self.suspend();
            }
            self.end_what_is_late(&left);
        }
    }

    /// Waits until a signal comes, a button is pressed, a process sends a frame or ends, or the next beat is due. Returns
    /// the processes of which something came.
    fn wait(&self, left: &[&'a Rc<Member>]) -> Vec<&'a Rc<Member>> {
        let mut all: Vec<_> = left
            .iter()
            .map(|member| PollFd::from_borrowed_fd(member.control.descriptor(), PollFlags::IN))
            .collect();
        all.push(PollFd::from_borrowed_fd(self.console_server.descriptor(), PollFlags::IN));
        all.push(PollFd::from_borrowed_fd(self.signals.descriptor(), PollFlags::IN));
        let time = Timespec::try_from(BEAT.saturating_sub(self.beat.elapsed())).ok();
        if poll(&mut all, time.as_ref()).is_err() {
            // A signal interrupted the call; the next wait sees it.
            return Vec::new();
        }
        let came = all.iter().map(|descriptor| !descriptor.revents().is_empty());
        left.iter().zip(came).filter(|(_, came)| *came).map(|(member, _)| *member).collect()
    }

    fn hear_signals(&mut self) {
        self.signals.clear();
        if self.signals.ends() && self.aborting.is_none() {
            self.process_set.tell_mp(&Frame::Abort);
            self.aborting = Some(Instant::now() + self.timeout.stop + ABORTING);
        }
        if self.signals.take_stop() && self.suspending.is_none() {
            self.suspending = Some(Instant::now() + self.timeout.stop + SUSPENDING);
            self.rounds_at_rest = 0;
            self.press_suspend();
        }
    }

    fn pass_presses_on(&mut self) {
        self.console_server.clear();
        for (mp, press) in self.console_server.presses() {
            if mp != ProcessId::MP {
                self.process_set.tell_mp_of(mp, &press);
                continue;
            }
            if let Frame::Press { button: Button::Stop, number } = press {
                self.mp_watch.note_stop(number);
            }
            self.process_set.tell_mp(&press);
        }
    }

    /// Takes what a process has sent, or notes its end.
    fn hear(&mut self, member: &Member) {
        match member.control.receive() {
            Ok(Frame::Over { steps, time, outcome }) => {
                member.over.replace(Some(Over { steps, time, outcome }));
                self.console_server.ended(member.id);
                if member.id == ProcessId::MP {
                    self.close();
                }
            }
            Ok(Frame::Gone(how)) => drop(member.ended.replace(Some(how))),
            Ok(Frame::Rested(rest)) => member.rests.borrow_mut().push(rest),
            Ok(Frame::Figures(figures)) => {
                member.figures.set(Some(figures));
                self.console_server.measured(member.id, figures);
            }
            Ok(_) => {}
            Err(_) => {
                let how = member.reap();
                self.console_server.ended(member.id);
                if member.over.borrow().is_some() {
                    return;
                }
                match member.id.role {
                    // Processes that read this sensor notice its loss; all others go on.
                    Role::Vsp => note(member, &how),
                    // The MP above it notices its loss, and decides what becomes of the other cells.
                    Role::Mp if member.id.is_of_lower_cell() => note(member, &how),
                    Role::Ecp | Role::Edp if member.id.is_of_lower_cell() => {
                        note(member, &how);
                        self.process_set.tell_mp_of(member.id, &Frame::Lost(member.id));
                    }
                    Role::Mp => {
                        self.death.get_or_insert(member.death(&how));
                        self.close();
                    }
                    // Without it, its far processes are gone, too, each by itself.
                    Role::Node => drop(self.death.get_or_insert(member.death(&how))),
                    Role::Ecp | Role::Edp | Role::Plant => {
                        self.death.get_or_insert(member.death(&how));
                        self.process_set.tell_mp(&Frame::Lost(member.id));
                    }
                }
            }
        }
    }

    fn close(&mut self) {
        if self.closing.is_none() {
            self.process_set.tell(&Frame::Close);
            self.closing = Some(Instant::now() + self.timeout.stop + self.process_set.closing());
        }
    }

    /// Closes the cell if the MP's program goes on although it was aborted, and kills what goes on after that.
    fn end_what_is_late(&mut self, left: &[&'a Rc<Member>]) {
        let now = Instant::now();
        if let [mp] = left
            && self.mp_is_still
            && mp.id == ProcessId::MP
        {
            // It does not hear that the cell closes, and there is no robot left that it could disturb.
            mp.kill();
        }
        match (self.closing, self.aborting) {
            (Some(until), _) if now > until => left.iter().for_each(|member| {
                member.kill();
                if member.over.borrow().is_none() {
                    self.death.get_or_insert(member.death("it did not end when the cell closed"));
                }
            }),
            (None, Some(until)) if now > until => self.close(),
            (Some(_) | None, _) => {}
        }
    }

    fn panel(&self) -> Option<MpPanel> {
        self.board.read(self.mp?).map(|words| MpPanel::read(&words))
    }

    /// Tells of a cell that awaits its reset, and of an MP that begins no step; ends the cell if that lasts.
    fn look_at_mp(&mut self) {
        if self.closing.is_some() || self.suspending.is_some() {
            return;
        }
        let mp = self.panel().unwrap_or_default();
        if let Some(told) = self.latch_notes.look(&mp) {
            complain(&told);
        }
        for (place, notes) in &mut self.lower_notes {
            let lower = self.board.read(*place).map(|words| MpPanel::read(&words)).unwrap_or_default();
            // One that was stopped from above is reset from there, and told of there.
            let is_of_above =
                lower.persisting.as_ref().is_some_and(|why| why.kind() == FaultKind::StoppedByCell);
            if let Some(told) = notes.look(&lower).filter(|_| !is_of_above) {
                complain(&told);
            }
        }
        let stopped = mp.answers[Button::Stop.kind()].number;
        let progress = MpProgress { step: mp.step, instructions: mp.instructions };
        match self.mp_watch.look(progress, stopped, Instant::now()) {
            Still::Moves | Still::Tolerated => {}
            Still::ToBeTold(seconds) => complain(&format!(
                "note: mp: it has begun no step for {seconds} s: {}; its robots stand; after {} s in all the cell is ended",
                self.what_mp_does(),
                self.timeout.computing.as_secs_f64()
            )),
            Still::ToBeEnded(seconds) => {
                let kind =
                    if self.mp_watch.is_stopping() { FaultKind::ProtectiveStop } else { FaultKind::PeerLost };
                let by = if self.mp_watch.is_stopping() { "by the operator: " } else { "" };
                let text = format!("{by}the MP has begun no step for {seconds} s: {}", self.what_mp_does());
                self.death.get_or_insert(Fault::new(kind).in_process(ProcessId::MP).text(&text));
                self.mp_is_still = true;
                self.close();
            }
        }
    }

    /// Why the MP begins no step.
    fn what_mp_does(&self) -> &'static str {
        let mp = self.mp.and_then(|place| self.process_set.members.get(place));
        match mp {
            Some(mp) if is_stopped(mp.pid()) => "it was stopped by a signal",
            Some(_) | None => "its program computes",
        }
    }

    fn press_suspend(&self) {
        self.process_set.tell_mp(&Frame::Press { number: OWN_PRESS, button: Button::Suspend });
    }

    /// Whether no robot moves, and none will before the operator resumes the cell.
    fn stands(&self) -> bool {
        self.panel().is_none_or(|mp| match (mp.state, mp.doing) {
            (CellState::Latched | CellState::Acknowledged, _) => true,
            // Its next instruction begins suspended.
            (CellState::Idle | CellState::Suspended, InstructionKind::Nothing) => true,
            (CellState::Suspended, InstructionKind::Move | InstructionKind::Wait) => mp.rate == 0.0,
            (..) => false,
        })
    }

    /// Before the launcher stops: suspends the cell, and stops when the cell stands.
    fn suspend(&mut self) {
        let Some(until) = self.suspending else { return };
        if self.closing.is_some() || self.aborting.is_some() {
            // The cell ends, and its launcher with it.
            self.suspending = None;
            return;
        }
        self.rounds_at_rest = if self.stands() { self.rounds_at_rest + 1 } else { 0 };
        // In the second round the drives have come to the last demand, too.
        if self.rounds_at_rest > 1 {
            self.suspending = None;
            self.sleep();
        } else if Instant::now() > until {
            self.suspending = None;
            complain("note: the launcher does not stop, because the cell does not come to a standstill");
        } else {
            // Again, because one that comes between two instructions is refused.
            self.press_suspend();
        }
    }

    /// Stops this process until its user continues it; the cell stays suspended.
    fn sleep(&mut self) {
        complain(
            "note: the cell is suspended, and the launcher stops; until it is continued (fg), no console is answered",
        );
        wait_until_written(LAST_WORDS);
        self.board.heartbeat().sleep();
        stop_until_continued();
        self.board.heartbeat().beat();
        self.mp_watch.begin_again();
        complain(
            "note: the launcher goes on; the cell stays suspended until it is resumed from another terminal",
        );
    }
}
