//! The drives against a gripper on loopback that is a model of its registers, and against what is no gripper.

#![expect(clippy::disallowed_methods, reason = "the exchange has a thread of its own, which tests wait for")]

use core::time::Duration;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::robot::{DriveFault, Driver, Homing, Recovery, Regulators, Search, StopCause};
use mrroc_counting_allocator::{Counting, count};
use mrroc_robots::{One, TwoFingers};

use crate::registers::INACTIVE;
use crate::{Activation, Openings, Robotiq, RobotiqSettings};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A gripper: its registers, and fingers that go on by some numbers whenever its status is read.
#[derive(Debug)]
struct Gripper {
    request: [u16; 3],
    is_active: bool,
    /// Readings that an activation takes, and those until it is over.
    takes: u8,
    activation: u8,
    position: u8,
    told: u8,
    goes: bool,
    /// Where something stops fingers that close.
    object: u8,
    held: bool,
    fault: u8,
    /// Where somebody else tells the fingers to go, after each of our requests.
    others: Option<u8>,
    /// What was written, in order.
    written: Vec<[u16; 3]>,
    connections: usize,
    /// Bytes in place of the next answer.
    instead: Option<Vec<u8>>,
    /// Whether it says nothing any more.
    is_silent: bool,
}

impl Gripper {
    const ACTIVE: Gripper = Gripper {
        request: [0x0900, 40, 0],
        is_active: true,
        takes: 5,
        activation: 0,
        position: 40,
        told: 40,
        goes: true,
        object: 255,
        held: false,
        fault: 0,
        others: None,
        written: Vec::new(),
        connections: 0,
        instead: None,
        is_silent: false,
    };

    fn write(&mut self, request: [u16; 3]) {
        self.written.push(request);
        self.request = request;
        let activates = request[0] & 0x0100 != 0;
        if !activates {
            (self.is_active, self.activation, self.fault, self.goes) = (false, 0, 0, false);
        } else if !self.is_active && self.activation == 0 {
            self.activation = self.takes;
        }
        if self.is_active && request[0] & 0x0800 != 0 {
            (self.goes, self.told) = (true, request[1] as u8);
        }
    }

    fn read(&mut self) -> [u16; 3] {
        self.told = self.others.unwrap_or(self.told);
        if self.activation > 0 {
            self.activation -= 1;
            (self.is_active, self.position) = (self.activation == 0, 3);
        }
        if self.is_active && self.goes {
            let way = i16::from(self.told) - i16::from(self.position);
            let next = i16::from(self.position) + way.clamp(-8, 8);
            self.held = way > 0 && next > i16::from(self.object);
            self.position = if self.held { self.object } else { next as u8 };
        }
        let fingers = match self.told == self.position {
            _ if self.held => 2,
            true => 3,
            false => 0,
        };
        let state = match (self.is_active, self.request[0] & 0x0100 != 0) {
            (true, _) => 0x31,
            (false, true) => 0x11,
            (false, false) => 0,
        };
        let status = state | u16::from(self.goes) << 3 | fingers << 6;
        let fault = u16::from(self.fault) << 8;
        [status << 8, fault | u16::from(self.told), u16::from(self.position) << 8 | 12]
    }
}

/// It, served on loopback. It lives as long as the listener's thread has connections to wait for.
#[derive(Clone)]
struct Bench {
    gripper: Arc<Mutex<Gripper>>,
    address: SocketAddr,
}

impl Bench {
    fn new(gripper: Gripper) -> Bench {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("bound");
        let bench = Bench { gripper: Arc::new(Mutex::new(gripper)), address };
        let of_thread = bench.clone();
        std::thread::spawn(move || {
            for socket in listener.incoming() {
                of_thread.look(|gripper| gripper.connections += 1);
                // The other end hangs up when it likes.
                drop(socket.and_then(|socket| of_thread.serve(socket)));
            }
        });
        bench
    }

    fn look<T>(&self, look: impl FnOnce(&mut Gripper) -> T) -> T {
        look(&mut self.gripper.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn serve(&self, mut socket: TcpStream) -> std::io::Result<()> {
        socket.set_nodelay(true)?;
        loop {
            let mut head = [0; 8];
            socket.read_exact(&mut head)?;
            let mut body = vec![0; usize::from(u16::from_be_bytes([head[4], head[5]])) - 2];
            socket.read_exact(&mut body)?;
            if self.look(|gripper| gripper.is_silent) {
                continue;
            }
            if let Some(instead) = self.look(|gripper| gripper.instead.take()) {
                socket.write_all(&instead)?;
                continue;
            }
            let word = |at: usize| u16::from_be_bytes([body[at], body[at + 1]]);
            let message = match head[7] {
                0x10 => {
                    assert_eq!((word(0), word(2), body[4]), (0x03e8, 3, 6));
                    self.look(|gripper| gripper.write([word(5), word(7), word(9)]));
                    body[..4].to_vec()
                }
                0x04 => {
                    assert_eq!((word(0), word(2)), (0x07d0, 3));
                    let words = self.look(Gripper::read);
                    [6].into_iter().chain(words.into_iter().flat_map(u16::to_be_bytes)).collect()
                }
                other => panic!("function {other}"),
            };
            let mut answer = head.to_vec();
            answer[4..6].copy_from_slice(&(2 + message.len() as u16).to_be_bytes());
            answer.extend(message);
            // In pieces, as TCP may bring it.
            for piece in answer.chunks(5) {
                socket.write_all(piece)?;
            }
        }
    }

    fn settings(&self) -> RobotiqSettings {
        RobotiqSettings::new(self.address)
    }

    fn drives(&self) -> Box<dyn Driver<TwoFingers>> {
        Box::new(Robotiq::new(self.settings()))
    }

    fn opened(&self) -> Box<dyn Driver<TwoFingers>> {
        let mut drives = self.drives();
        drives.open().expect("it is active");
        drives
    }
}

fn opening(number: u8) -> One {
    One::new(Openings::OF_85.opening(number))
}

fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
    loop {
        if let Some(found) = look() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Demands this until the fingers are there.
fn go(drives: &mut dyn Driver<TwoFingers>, demanded: One, there: One) {
    until(|| {
        let measured = drives.tick(&demanded).expect("it goes on");
        ((measured.position - there).amax() < 1e-9).then_some(())
    });
}

/// The fault that the next ticks end with.
fn fault(drives: &mut dyn Driver<TwoFingers>, demanded: One) -> DriveFault {
    until(|| drives.tick(&demanded).err())
}

fn cause(fault: DriveFault) -> StopCause {
    let DriveFault::Stopped(stop) = fault else { panic!("{fault}") };
    stop.cause()
}

/// 85 mm at 3, closed at 230.
#[test]
fn openings_are_those_of_the_grippers_numbers() {
    let openings = Openings::OF_85;
    assert!((openings.opening(3) - 0.085).abs() < 1e-15 && openings.opening(230).abs() < 1e-15);
    for number in 0..=255 {
        assert_eq!(openings.number(openings.opening(number)), Ok(number));
    }
    assert_eq!(openings.number(0.0425), Ok(117), "half-way: 116.5");
    assert!(openings.number(0.1).is_err() && openings.number(-0.02).is_err());
    assert!(openings.number(f64::NAN).is_err());
}

#[test]
fn fingers_go_where_they_are_told_and_stop_at_what_they_hold_without_a_fault() {
    let bench = Bench::new(Gripper { object: 120, ..Gripper::ACTIVE });
    let mut drives = bench.opened();
    assert_eq!(drives.held(), Some(opening(40)));
    assert_eq!(drives.measured().map(|measured| measured.position), Ok(opening(40)));
    go(&mut *drives, opening(100), opening(100));
    // Closed on an object: the demand goes on, the fingers stay.
    go(&mut *drives, opening(200), opening(120));
    until(|| bench.look(|gripper| gripper.held).then_some(()));
    let standing = until(|| drives.tick(&opening(200)).ok().filter(|now| now.velocity[0].abs() < 1e-12));
    assert_eq!(standing.position, opening(120));
    assert_eq!(drives.motor_currents(), Some(One::new(0.12)));
    go(&mut *drives, opening(10), opening(10));
    let written = bench.look(|gripper| gripper.written.clone());
    assert!(written.contains(&[0x0900, 200, 0xff40]), "{written:x?}");
}

/// Also while the gripper says nothing, and after its connection is lost.
#[test]
fn a_servo_period_allocates_nothing() {
    let bench = Bench::new(Gripper::ACTIVE);
    let mut drives = bench.opened();
    go(&mut *drives, opening(100), opening(100));
    bench.look(|gripper| gripper.is_silent = true);
    let mut is_lost = false;
    while !is_lost {
        let (ticked, allocations) = count(|| (drives.tick(&opening(120)), drives.motor_currents()).0);
        assert_eq!(allocations, 0);
        is_lost = ticked.is_err();
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn parameter_sets_are_forces() {
    let bench = Bench::new(Gripper::ACTIVE);
    let mut drives = bench.opened();
    assert!(drives.has_regulator(0, 2) && !drives.has_regulator(0, 3));
    for (set, force) in [(1, 0), (2, 255), (0, 64)] {
        drives.choose_regulators(&Regulators::uniform(set));
        drives.tick(&opening(100)).expect("it goes on");
        until(|| (bench.look(|gripper| gripper.request[2]) == 0xff00 | force).then_some(()));
    }
}

#[test]
fn what_is_held_keeps_its_grip_until_something_else_is_demanded() {
    // Somebody has closed it on an object, with a force of their own.
    let holds = Gripper { object: 90, position: 90, told: 255, held: true, ..Gripper::ACTIVE };
    let bench = Bench::new(holds);
    let mut drives = bench.opened();
    let held = drives.held().expect("it is open");
    assert_eq!(held, opening(255), "where it presses to, not where the object is");
    for _ in 0..50 {
        drives.tick(&held).expect("it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(bench.look(|gripper| gripper.written.is_empty()));
    // The cell ends.
    drives.close();
    assert!(bench.look(|gripper| gripper.written.is_empty() && gripper.held));
}

#[test]
fn fault_103_a_gripper_that_is_not_activated_keeps_its_cell_from_beginning_and_is_not_touched() {
    let bench = Bench::new(Gripper { is_active: false, request: [0; 3], goes: false, ..Gripper::ACTIVE });
    let mut drives = bench.drives();
    // A reset opens drives again that could not be opened, and does not activate either.
    for _ in 0..2 {
        assert_eq!(drives.open(), Err(INACTIVE.into()));
    }
    assert!(drives.measured().is_err());
    assert!(bench.look(|gripper| gripper.written.is_empty()));
}

fn search(activation: Activation) -> Result<Search<Activation, Robotiq>, DriveFault> {
    Homing::<TwoFingers>::search(activation)
}

#[test]
fn fault_103_homing_activates_a_gripper_that_is_not_active_and_no_other() {
    for (is_active, request) in [(false, [0; 3]), (true, [0x0900, 40, 0])] {
        let bench = Bench::new(Gripper { is_active, request, goes: is_active, ..Gripper::ACTIVE });
        let mut activation = Some(Activation::new(bench.settings()));
        let mut drives: Box<dyn Driver<TwoFingers>> =
            until(|| match search(activation.take()?).expect("nothing is in its way") {
                Search::Found(drives) => Some(Box::new(drives) as Box<dyn Driver<TwoFingers>>),
                Search::Searching(on) => {
                    activation = Some(on);
                    None
                }
            });
        let written = bench.look(|gripper| gripper.written.clone());
        assert_eq!(written, if is_active { vec![] } else { vec![[0; 3], [0x0100, 0, 0]] });
        go(&mut *drives, opening(100), opening(100));
    }
}

#[test]
fn fault_103_an_activation_that_is_asked_for_no_more_is_stopped() {
    let inactive = Gripper { is_active: false, request: [0; 3], goes: false, ..Gripper::ACTIVE };
    let bench = Bench::new(Gripper { takes: u8::MAX, ..inactive });
    let Ok(Search::Searching(activation)) = search(Activation::new(bench.settings())) else {
        panic!("it takes longer than a period")
    };
    until(|| bench.look(|gripper| (gripper.written.len() == 3).then_some(())));
    assert_eq!(bench.look(|gripper| gripper.written.clone()), [[0; 3], [0x0100, 0, 0], [0; 3]]);
    drop(activation);
}

#[test]
fn fault_103_a_fault_of_the_gripper_is_told_by_its_name_and_stays_until_it_is_gone() {
    let bench = Bench::new(Gripper::ACTIVE);
    let mut drives = bench.opened();
    bench.look(|gripper| gripper.fault = 0x08);
    let told = fault(&mut *drives, opening(40));
    assert_eq!(told.to_string(), "protective stop: fault 8: it is too hot, let it cool down");
    assert_eq!(recovered(&mut *drives), Err(told));
    assert_eq!(drives.switch_on(), Err(told));
    bench.look(|gripper| gripper.fault = 0);
    assert_eq!(recovered(&mut *drives), Ok(()));
    drives.switch_on().expect("it has cooled down");
    go(&mut *drives, opening(100), opening(100));
}

/// Somebody took its activation away, or its power.
#[test]
fn fault_103_a_gripper_that_is_activated_no_more_stops_and_no_reset_moves_its_fingers() {
    let bench = Bench::new(Gripper::ACTIVE);
    let mut drives = bench.opened();
    bench.look(|gripper| gripper.write([0; 3]));
    assert_eq!(fault(&mut *drives, opening(40)), INACTIVE.into());
    let before = bench.look(|gripper| gripper.written.len());
    assert_eq!(recovered(&mut *drives), Err(INACTIVE.into()));
    assert_eq!(bench.look(|gripper| gripper.written.len()), before);
}

fn recovered(drives: &mut dyn Driver<TwoFingers>) -> Result<(), DriveFault> {
    loop {
        match drives.recover()? {
            Recovery::Over => return Ok(()),
            Recovery::GoesOn => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

#[test]
fn fault_102_a_gripper_that_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let bench = Bench::new(Gripper { object: 120, ..Gripper::ACTIVE });
    let mut drives = bench.opened();
    go(&mut *drives, opening(200), opening(120));
    bench.look(|gripper| gripper.is_silent = true);
    assert_eq!(cause(fault(&mut *drives, opening(200))), StopCause::CommunicationLost);
    assert!(drives.tick(&opening(200)).is_err() && drives.measured().is_err());
    bench.look(|gripper| gripper.is_silent = false);
    std::thread::sleep(Duration::from_millis(50));
    assert!(drives.switch_on().is_err(), "it does not connect by itself");
    assert_eq!(bench.look(|gripper| gripper.connections), 1);
    let before = bench.look(|gripper| gripper.written.len());
    assert_eq!(recovered(&mut *drives), Ok(()));
    drives.switch_on().expect("it answers");
    assert_eq!(bench.look(|gripper| gripper.connections), 2);
    // Demands begin where it presses to: it keeps its grip.
    assert_eq!(drives.held(), Some(opening(200)));
    drives.tick(&opening(200)).expect("it goes on");
    assert!(bench.look(|gripper| gripper.held && gripper.written.len() == before));
}

#[test]
fn fault_102_a_gripper_that_is_not_there_is_told_as_such() {
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
    let mut drives: Box<dyn Driver<TwoFingers>> = Box::new(Robotiq::new(RobotiqSettings::new(free)));
    let told = drives.open().expect_err("nobody listens");
    assert_eq!(told.to_string(), "communication lost: nothing accepts a connection at its address");
    assert_eq!(recovered(&mut *drives), Err(told));
}

#[test]
fn fault_102_what_is_no_answer_ends_the_exchange_with_its_reason() {
    // Transaction 1 is the first question, of unit 9.
    let cases: [(&[u8], &str); 5] = [
        (&[0, 7, 0, 0, 0, 9, 9, 4, 6, 0xf9, 0, 0, 0, 0, 0], "another transaction's number"),
        (&[0, 1, 0, 0, 0xff, 0xff, 9, 4, 6], "a length that cannot be"),
        (&[0, 1, 0, 0, 0, 9, 4, 4, 6, 0xf9, 0, 0, 0, 0, 0], "of another unit"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "of another protocol"),
        (&[0, 1, 0, 0, 0, 3, 9, 0x84, 2], "exception 2: the device has no such bits or registers"),
    ];
    for (instead, reason) in cases {
        let bench = Bench::new(Gripper { instead: Some(instead.to_vec()), ..Gripper::ACTIVE });
        let told = bench.drives().open().expect_err("it is no answer").to_string();
        assert!(told.contains(reason), "{told}");
    }
    // A whole message that never ends.
    let bench = Bench::new(Gripper { instead: Some(vec![0, 1, 0, 0]), ..Gripper::ACTIVE });
    let told = bench.drives().open().expect_err("it is cut").to_string();
    assert!(told.contains("no answer came in time"), "{told}");
}

#[test]
fn fault_102_a_gateway_that_is_busy_is_asked_again() {
    let busy = vec![0, 1, 0, 0, 0, 3, 9, 0x84, 0x0b];
    let bench = Bench::new(Gripper { instead: Some(busy), ..Gripper::ACTIVE });
    bench.drives().open().expect("the second time it answers");
}

#[test]
fn fault_102_a_position_that_does_not_arrive_is_told() {
    let bench = Bench::new(Gripper::ACTIVE);
    let mut drives = bench.opened();
    go(&mut *drives, opening(100), opening(100));
    // Somebody else writes to it all the time.
    bench.look(|gripper| gripper.others = Some(7));
    assert_eq!(cause(fault(&mut *drives, opening(100))), StopCause::PendantInControl);
}
