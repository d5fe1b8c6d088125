//! This process's own entry on the state board.
//!
//! In: what the process does, by whatever shows it in its steps. Out: words in the entry, written without waiting or allocating.

use core::cell::OnceCell;
use std::io;
use std::rc::Rc;
use std::sync::atomic::Ordering;

use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::{Nanos, StopBoard};
use mrroc_core::observe::Observation;
use mrroc_core::observe::layout::BodyLayout;
use mrroc_core::observe::step_observer::{StepEvent, StepObserver};
use mrroc_core::payload::Wire;
use mrroc_core::pose::Pose;

use crate::board::StateBoard;
use crate::board::entry;
use crate::board::heartbeat::Silence;
use crate::link::{Fabric, Seal, Shows, Slew, Supervised};

/// This process's entry on the state board; empty until the cell is put together and the place of the process is known.
#[derive(Default)]
pub(super) struct OwnEntry(Rc<OnceCell<(StateBoard, usize)>>);

impl OwnEntry {
    pub fn open(&self, fabric: &Fabric, me: ProcessId, seal: Seal) -> io::Result<()> {
        let places = fabric.places();
        let board = StateBoard::open(seal.session, places.len())?;
        if let Some(place) = places.iter().position(|&place| place == me) {
            // The entry is opened once, so it is still empty here.
            drop(self.0.set((board, place)));
        }
        Ok(())
    }

    /// An observer that shows every servo period of this process's robot on the board.
    pub fn of_robot(&self) -> impl FnMut(&Observation<'_>) + 'static {
        let entry = Rc::clone(&self.0);
        move |seen| {
            if let Some((board, place)) = entry.get() {
                board.write(*place, &entry::of_robot(seen));
            }
        }
    }

    /// What shows every step of an MP, the instructions of an ECP, what the robot of an EDP carries, or the readings of a VSP on the
    /// board; `None` in any other process.
    pub fn of(&self, me: ProcessId) -> Option<Shows> {
        let entry = Rc::clone(&self.0);
        let write = move |from: usize, words: &[u64]| {
            if let Some((board, place)) = entry.get() {
                board.write_from(*place, from, words);
            }
        };
        match me.role {
            Role::Mp => Some(Shows::Mp(Box::new(move |state| write(0, &entry::of_mp(state))))),
            Role::Ecp => Some(Shows::Ecp(Box::new(move |state| write(0, &entry::of_ecp(state))))),
            Role::Edp => {
                Some(Shows::Edp(Box::new(move |state| write(entry::CARRIED, &entry::of_edp(state)))))
            }
            Role::Vsp => Some(Shows::Vsp(Box::new(move |state| write(0, &entry::of_vsp(state))))),
            Role::Plant | Role::Node => None,
        }
    }

    /// An observer that shows on the board where these bodies are, as far as there is room for them.
    pub fn of_bodies(&self, bodies: &[BodyLayout]) -> Rc<dyn StepObserver> {
        let names = bodies.iter().take(entry::BODIES).map(|body| body.name.clone()).collect();
        Rc::new(ShowsBodies { entry: Rc::clone(&self.0), names })
    }

    /// What tells by how much the cell's time has moved on this machine.
    pub fn slew(&self) -> Option<Slew> {
        let entry = Rc::clone(&self.0);
        entry.get()?;
        Some(Box::new(move || entry.get().map_or(0, |(board, _)| board.slew().load(Ordering::Relaxed))))
    }

    /// The stops that consoles ask for, as the uppermost MP and all EDPs see them; `None` in any other process.
    pub fn stops(&self, me: ProcessId) -> Option<Rc<dyn StopBoard>> {
        let looks = me == ProcessId::MP || me.role == Role::Edp;
        looks.then(|| Rc::new(StopsOnBoard(Rc::clone(&self.0))) as Rc<dyn StopBoard>)
    }

    /// What tells an MP whether its launcher supervises the cell; `None` in any other process.
    pub fn supervised(&self, me: ProcessId) -> Option<Supervised> {
        let (entry, silence) = (Rc::clone(&self.0), Silence::default());
        let supervised = move |now| {
            let board = entry.get().map(|(board, _)| board);
            board.is_none_or(|board| !silence.look(board.heartbeat().read(), now))
        };
        (me == ProcessId::MP).then(|| -> Supervised { Box::new(supervised) })
    }
}

/// The stops on the board.
struct StopsOnBoard(Rc<OnceCell<(StateBoard, usize)>>);

impl StopBoard for StopsOnBoard {
    fn asked(&self) -> u64 {
        self.0.get().map_or(0, |(board, _)| board.stops_asked().load(Ordering::Acquire))
    }

    fn begun(&self) -> u64 {
        self.0.get().map_or(0, |(board, _)| board.stops_begun().load(Ordering::Acquire))
    }

    fn show_begun(&self, stops: u64, step: Option<u64>) {
        if let Some((board, _)) = self.0.get() {
            board.stop_step().store(step.unwrap_or(u64::MAX), Ordering::Relaxed);
            board.stops_begun().store(stops, Ordering::Release);
        }
    }
}

/// Shows on the board where bodies are.
struct ShowsBodies {
    entry: Rc<OnceCell<(StateBoard, usize)>>,
    /// The bodies, in the order of the layout.
    names: Vec<String>,
}

impl StepObserver for ShowsBodies {
    fn see(&self, _: Nanos, _: ProcessId, what: &StepEvent, words: &[u64]) {
        let StepEvent::Body { body, .. } = what else { return };
        let known = self.names.iter().position(|name| name == body.as_str());
        if let (Some(nth), Some((board, place))) = (known, self.entry.get()) {
            let mut shown = [1; 1 + Pose::LEN];
            shown[1..].iter_mut().zip(words).for_each(|(word, of)| *word = *of);
            board.write_from(*place, entry::body(nth), &shown);
        }
    }
}
