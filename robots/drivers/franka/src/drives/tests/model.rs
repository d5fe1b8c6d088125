//! A robot under a virtual clock, and the network between it and the drives. Nothing here waits.

use core::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::rc::Rc;

use super::*;
use crate::message::COMMAND;
use mrroc_driver_kit::Arrived;

/// How much time passes when the drives wait: as much as with real sockets.
const WAIT: Duration = Duration::from_micros(100);

/// Where the robot's states come from, and the port to which they go.
pub const ROBOT: SocketAddr = SocketAddr::new(IpAddr::V4(core::net::Ipv4Addr::LOCALHOST), 40001);
const PORT: u16 = 40002;

/// An answer to a state: its count, the positions, and whether they are the last.
pub type Told = (u64, Joints, bool);

/// The robot, what is on its way, and the time.
#[derive(Debug)]
pub struct Simulation {
    pub now: Duration,
    /// The version that it speaks; `None`: nobody is there.
    pub version: Option<u16>,
    /// How long it takes to answer to a connection, and from then to its first state.
    pub answers_after: Option<Duration>,
    pub says_after: Option<Duration>,
    pub state: State,
    /// Its period goes on by itself, and it follows what it is told; it ends a motion that is told to end.
    plays: bool,
    is_connected: bool,
    connections: u32,
    /// When it answers the connection, when it says its first state.
    due: (Option<Duration>, Option<Duration>),
    next: Duration,
    connect: Vec<u8>,
    requests: VecDeque<u8>,
    answers: VecDeque<u8>,
    states: VecDeque<(Duration, Vec<u8>)>,
    told: Vec<Told>,
}

impl Simulation {
    fn new(version: Option<u16>) -> Simulation {
        Simulation {
            now: Duration::ZERO,
            version,
            answers_after: Some(Duration::from_millis(3)),
            says_after: Some(Duration::from_millis(1)),
            state: standing(1, START, Mode::Idle),
            plays: false,
            is_connected: false,
            connections: 0,
            due: (None, None),
            next: Duration::ZERO,
            connect: Vec::new(),
            requests: VecDeque::new(),
            answers: VecDeque::new(),
            states: VecDeque::new(),
            told: Vec::new(),
        }
    }

    /// Its state comes in now.
    fn say(&mut self) {
        let bytes = bytes(&self.state, u8::from(self.state.follows_positions));
        self.states.push_back((self.now, bytes.to_vec()));
    }

    /// From now on its periods go on by themselves.
    pub fn play(&mut self) {
        (self.plays, self.next) = (true, self.now + PERIOD);
    }

    /// Time passes, and the robot does what is due.
    pub fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        loop {
            let (answers, says) = self.due;
            let period = self.plays.then_some(self.next);
            let Some(due) = [answers, says, period].into_iter().flatten().min().filter(|due| *due <= until)
            else {
                break;
            };
            self.now = due;
            if answers == Some(due) {
                let version = self.version.expect("somebody answers");
                let asked = core::mem::take(&mut self.connect);
                let says = [[u8::from(version != 10)].as_slice(), &version.to_le_bytes()].concat();
                self.answer(&asked, &says);
                self.due = (None, self.says_after.map(|after| due + after));
            } else if says == Some(due) {
                self.say();
                self.due.1 = None;
            } else {
                self.next += PERIOD;
                self.period();
            }
        }
        self.now = until;
    }

    fn period(&mut self) {
        let told = self.told.last().filter(|(count, ..)| *count == self.state.count).copied();
        if let Some((_, q, is_last)) = told {
            self.follow(&q);
            if is_last {
                (self.state.mode, self.state.follows_positions) = (Mode::Idle, false);
            }
        }
        self.state.count += 1;
        self.say();
    }

    /// It follows what it is told from the next state on.
    pub fn follow(&mut self, told: &Joints) {
        let now = Joints::from(self.state.q_d);
        self.state.dq_d = ((told - now) / 1e-3).into();
        self.state.q_d = (*told).into();
        self.state.q = self.state.q_d;
    }

    pub fn answer(&mut self, asked: &[u8], says: &[u8]) {
        let size = (12 + says.len() as u32).to_le_bytes();
        self.answers.extend([&asked[..8], &size, says].concat());
    }

    /// The next request, if one has come.
    pub fn request(&mut self) -> Option<Vec<u8>> {
        let size = self.requests.iter().skip(8).take(4).copied().collect::<Vec<_>>().try_into().ok()?;
        let size = u32::from_le_bytes(size) as usize;
        Some(self.requests.drain(..size).collect())
    }

    /// It closes the connection.
    pub fn cut(&mut self) {
        self.is_connected = false;
    }
}

/// The drives' end of the network.
#[derive(Debug)]
pub struct VirtualNetwork {
    simulation: Rc<RefCell<Simulation>>,
    last: Vec<u8>,
}

impl Network for VirtualNetwork {
    fn now(&self) -> Duration {
        self.simulation.borrow().now
    }

    fn connect(&mut self, timeout: Duration) -> Result<u16, DriveFault> {
        self.close();
        let mut simulation = self.simulation.borrow_mut();
        assert_eq!(timeout, TIMEOUT);
        if simulation.version.is_none() {
            return Err(ABSENT);
        }
        simulation.is_connected = true;
        simulation.connections += 1;
        simulation.due = (simulation.answers_after.map(|after| simulation.now + after), None);
        Ok(PORT)
    }

    fn close(&mut self) {
        let mut simulation = self.simulation.borrow_mut();
        simulation.is_connected = false;
        simulation.answers.clear();
        simulation.requests.clear();
        simulation.states.clear();
    }

    fn ask(&mut self, request: &[u8]) -> io::Result<()> {
        let mut simulation = self.simulation.borrow_mut();
        if !simulation.is_connected {
            return Err(ErrorKind::BrokenPipe.into());
        }
        if request[0] == 0 {
            let own = [&10_u16.to_le_bytes()[..], &PORT.to_le_bytes()].concat();
            assert_eq!(request[12..], own, "the version, and where states go");
            simulation.connect = request.to_vec();
        } else {
            simulation.requests.extend(request);
        }
        Ok(())
    }

    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut simulation = self.simulation.borrow_mut();
        if simulation.answers.is_empty() && !simulation.is_connected {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let len = into.len().min(simulation.answers.len());
        for (place, byte) in into.iter_mut().zip(simulation.answers.drain(..len)) {
            *place = byte;
        }
        Ok(len)
    }

    fn newest(&mut self) -> Option<Arrived<'_>> {
        let (came, state) = self.simulation.borrow_mut().states.drain(..).next_back()?;
        self.last = state;
        Some(Arrived { bytes: &self.last, from: ROBOT, came })
    }

    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()> {
        assert_eq!((to, bytes.len()), (ROBOT, COMMAND));
        let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight"));
        let count = u64::from_le_bytes(bytes[..8].try_into().expect("eight"));
        let told = (count, Joints::from_fn(|i, _| number(8 + 8 * i)), bytes[313] == 1);
        self.simulation.borrow_mut().told.push(told);
        Ok(())
    }

    fn wait(&mut self) {
        self.simulation.borrow_mut().pass(WAIT);
    }
}

/// Drives, and the robot behind them.
pub struct Fixture {
    pub simulation: Rc<RefCell<Simulation>>,
    fci: Fci<VirtualNetwork>,
}

impl Fixture {
    /// Drives that are not open, for a robot with this version of the interface.
    pub fn new(version: Option<u16>, change: impl FnOnce(FciSettings) -> FciSettings) -> Fixture {
        let simulation = Rc::new(RefCell::new(Simulation::new(version)));
        let network = VirtualNetwork { simulation: Rc::clone(&simulation), last: Vec::new() };
        let fci = Fci::over(network, change(FciSettings::new(ROBOT.ip())));
        Fixture { simulation, fci }
    }

    pub fn opened() -> Fixture {
        Fixture::opened_with(|settings| settings)
    }

    pub fn opened_with(change: impl FnOnce(FciSettings) -> FciSettings) -> Fixture {
        let mut fixture = Fixture::new(Some(10), change);
        assert_eq!(fixture.drives().measured(), Err(CLOSED), "nothing is open yet");
        fixture.drives().open().expect("opened");
        fixture
    }

    /// Until a motion runs, with the arm held where it stands but for a little that is demanded.
    pub fn moving() -> Fixture {
        let mut fixture = Fixture::opened();
        fixture.says(|_| {}).expect("it says something");
        fixture.drives().tick(&Joints::from(START)).expect("held");
        // Where it is held anyway it holds by itself.
        assert_eq!(fixture.request(), None);
        fixture.drives().tick(&aside()).expect("a motion is asked for");
        let asked = fixture.request().expect("a request");
        assert_eq!((asked[0], asked.len()), (1, 125));
        // The state that shows it may come before the answer.
        fixture.says(|state| (state.mode, state.follows_positions) = (Mode::Move, true)).expect("it moves");
        fixture.answer(&asked, &[STARTED]);
        fixture.says(|_| {}).expect("it moves");
        // Until something is demanded the drives answer by themselves; from then on each state waits for a demand.
        fixture.drives().tick(&aside()).expect("told");
        fixture.simulation.borrow_mut().told.clear();
        fixture.says(|_| {}).expect("it moves");
        assert_eq!(fixture.told(), None);
        fixture
    }

    pub fn drives(&mut self) -> &mut dyn Driver<Fr3> {
        &mut self.fci
    }

    pub fn answers(&self) -> Answers {
        self.fci.answers()
    }

    pub fn now(&self) -> Duration {
        self.simulation.borrow().now
    }

    pub fn connections(&self) -> u32 {
        self.simulation.borrow().connections
    }

    pub fn pass(&self, time: Duration) {
        self.simulation.borrow_mut().pass(time);
    }

    /// The robot's next state, a period after the one before, and what the drives say to it.
    pub fn says(&mut self, change: impl FnOnce(&mut State)) -> Result<Pulse, DriveFault> {
        {
            let mut simulation = self.simulation.borrow_mut();
            simulation.now += PERIOD;
            simulation.state.count += 1;
            change(&mut simulation.state);
            simulation.say();
        }
        let pulse = self.drives().pulse(Duration::ZERO)?;
        Ok(pulse.expect("a state has come"))
    }

    /// What the robot was told since this was asked last: one thing, for its last state, or nothing.
    pub fn told(&self) -> Option<(Joints, bool)> {
        let mut simulation = self.simulation.borrow_mut();
        let told = core::mem::take(&mut simulation.told);
        match told[..] {
            [] => None,
            [(count, q, is_last)] => {
                assert_eq!(count, simulation.state.count);
                Some((q, is_last))
            }
            _ => panic!("more than one answer: {told:?}"),
        }
    }

    /// What it was told so far is not looked at.
    pub fn forget_told(&self) {
        self.simulation.borrow_mut().told.clear();
    }

    /// The robot follows what it is told from the next state on.
    pub fn follows(&self, told: &Joints) {
        self.simulation.borrow_mut().follow(told);
    }

    pub fn count(&self) -> u64 {
        self.simulation.borrow().state.count
    }

    /// The next request, if one has come.
    pub fn request(&self) -> Option<Vec<u8>> {
        self.simulation.borrow_mut().request()
    }

    pub fn answer(&self, asked: &[u8], says: &[u8]) {
        self.simulation.borrow_mut().answer(asked, says);
    }
}
