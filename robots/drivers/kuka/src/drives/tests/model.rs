//! A controller under a virtual clock, and the network between it and the drives. Nothing here waits.

use core::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;

use super::*;
use mrroc_driver_kit::Arrived;

/// The controller's period.
pub const PERIOD: Duration = Duration::from_millis(4);

/// How much time passes when the drives wait: as much as with real sockets.
const WAIT: Duration = Duration::from_micros(200);

/// When a controller counts an answer that did not come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counting {
    AtOnce,
    WhenHeard,
    Never,
}

/// What the controller says at the beginnings of its periods, while the drives wait for it.
#[derive(Clone, Debug)]
pub enum Says {
    Nothing,
    /// The same every time.
    Same(Vec<u8>),
    /// Where its axis 1 is, with a clock that goes on, and how many answers it has not taken so far.
    Counts {
        counting: Counting,
        ipoc: u64,
        late: u64,
        missed: u64,
    },
}

/// The controller, the messages that are on their way, and the time.
#[derive(Debug)]
pub struct Simulation {
    pub now: Duration,
    pub says: Says,
    /// When its next period begins.
    pub next: Duration,
    /// From when on it says nothing.
    pub ends: Option<Duration>,
    pub is_open: bool,
    waiting: VecDeque<(Duration, Vec<u8>)>,
    /// What the drives have sent, and the test has not looked at.
    sent: Vec<String>,
    /// The clocks of the messages that were answered.
    answered: Vec<u64>,
}

impl Simulation {
    pub fn new(says: Says) -> Simulation {
        Simulation {
            now: Duration::ZERO,
            says,
            next: PERIOD,
            ends: None,
            is_open: false,
            waiting: VecDeque::new(),
            sent: Vec::new(),
            answered: Vec::new(),
        }
    }

    /// A message comes in now.
    pub fn deliver(&mut self, message: Vec<u8>) {
        if self.is_open {
            self.waiting.push_back((self.now, message));
        }
    }

    /// What was sent since this was asked last.
    pub fn sent(&mut self) -> Vec<String> {
        core::mem::take(&mut self.sent)
    }

    /// Time passes, and the controller speaks in its periods.
    pub fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while self.next <= until {
            self.now = self.next;
            self.next += PERIOD;
            self.speak();
        }
        self.now = until;
    }

    fn speak(&mut self) {
        if self.ends.is_some_and(|ends| self.now >= ends) {
            return;
        }
        let message = match &mut self.says {
            Says::Nothing => return,
            Says::Same(message) => message.clone(),
            Says::Counts { counting, ipoc, late, missed } => {
                let in_time = self.answered.contains(ipoc) || *ipoc == FIRST;
                match counting {
                    Counting::AtOnce => *late += u64::from(!in_time),
                    Counting::WhenHeard if in_time => *late += core::mem::take(missed),
                    Counting::WhenHeard => *missed += 1,
                    Counting::Never => {}
                }
                *ipoc += 4;
                said_late(*ipoc, 10.0, *late)
            }
        };
        self.deliver(message);
    }
}

/// The clock of a controller that counts, before its first message.
pub const FIRST: u64 = 4000;

/// The drives' end of the network.
#[derive(Debug)]
pub struct VirtualNetwork {
    pub simulation: Rc<RefCell<Simulation>>,
    last: Vec<u8>,
}

impl VirtualNetwork {
    pub fn new(simulation: &Rc<RefCell<Simulation>>) -> VirtualNetwork {
        VirtualNetwork { simulation: Rc::clone(simulation), last: Vec::new() }
    }
}

impl Network for VirtualNetwork {
    fn now(&self) -> Duration {
        self.simulation.borrow().now
    }

    fn listen(&mut self) -> io::Result<()> {
        let mut simulation = self.simulation.borrow_mut();
        simulation.waiting.clear();
        simulation.is_open = true;
        Ok(())
    }

    fn close(&mut self) {
        self.simulation.borrow_mut().is_open = false;
    }

    fn newest(&mut self) -> Option<Arrived<'_>> {
        let (came, message) = self.simulation.borrow_mut().waiting.drain(..).next_back()?;
        self.last = message;
        Some(Arrived { bytes: &self.last, from: CONTROLLER, came })
    }

    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()> {
        assert_eq!(to, CONTROLLER);
        let text = String::from_utf8(bytes.to_vec()).expect("text");
        let mut simulation = self.simulation.borrow_mut();
        simulation.answered.push(told(&text).0);
        simulation.sent.push(text);
        Ok(())
    }

    fn wait(&mut self) {
        self.simulation.borrow_mut().pass(WAIT);
    }
}

/// Drives, and the controller behind them.
pub struct Fixture {
    pub simulation: Rc<RefCell<Simulation>>,
    pub drives: Box<dyn Driver<Arm>>,
}

impl Fixture {
    /// Drives for a controller that says this while they are opened; nothing is open yet.
    pub fn new(corrections: Corrections, says: Says) -> Fixture {
        let simulation = Rc::new(RefCell::new(Simulation::new(says)));
        let listen = SocketAddr::from(([10, 0, 0, 1], 49152));
        let settings = RsiSettings { corrections, ..RsiSettings::new(listen, CONTROLLER.ip()) };
        let drives: Box<dyn Driver<Arm>> = Box::new(Rsi::over(VirtualNetwork::new(&simulation), settings));
        Fixture { simulation, drives }
    }

    /// Opens the drives. From then on the controller says only what a test has it say.
    pub fn open(&mut self) -> Result<(), DriveFault> {
        let opened = self.drives.open();
        self.simulation.borrow_mut().says = Says::Nothing;
        opened
    }

    /// Drives that are open, with an arm at 10 degrees of axis 1, and the first message answered.
    pub fn opened() -> Fixture {
        let mut fixture = Fixture::new(Corrections::Absolute, Says::Same(said(4000, 10.0)));
        fixture.open().expect("the controller speaks");
        assert_eq!(fixture.told(), [(4000, 0.0)]);
        fixture
    }

    pub fn now(&self) -> Duration {
        self.simulation.borrow().now
    }

    /// The controller says this now.
    pub fn says(&self, message: Vec<u8>) {
        self.simulation.borrow_mut().deliver(message);
    }

    /// What the drives make of a message.
    pub fn pulse(&mut self, message: Vec<u8>) -> Result<u64, DriveFault> {
        self.says(message);
        self.drives.pulse(Duration::ZERO).map(|pulse| pulse.expect("a message has come").count)
    }

    /// What was sent since this was asked last: the clock of each answer, and its correction of axis 1 \[deg\].
    pub fn told(&self) -> Vec<(u64, f64)> {
        self.simulation.borrow_mut().sent().iter().map(|answer| told(answer)).collect()
    }

    /// The correction of axis 1 in the answer to a message that says how many answers were late so far, with axis 1 demanded there.
    pub fn answers(&mut self, ipoc: u64, late: u64, a1: f64) -> f64 {
        assert_eq!(self.pulse(said_late(ipoc, a1, late)), Ok(ipoc / 4));
        self.drives.tick(&at(a1)).expect("sent");
        let told = self.told();
        let [(clock, correction)] = told[..] else { panic!("not one answer: {told:?}") };
        assert_eq!(clock, ipoc);
        correction
    }
}

/// The clock and the correction of axis 1 of an answer.
fn told(answer: &str) -> (u64, f64) {
    let between = |before: &str, after: &str| {
        let (_, rest) = answer.split_once(before).expect("it is there");
        rest.split_once(after).expect("it ends").0.to_owned()
    };
    let ipoc = between("<IPOC>", "</IPOC>").parse().expect("a number");
    (ipoc, between("A1=\"", "\"").parse().expect("a number"))
}
