//! The drives over sockets on loopback, in real time.

#![expect(clippy::disallowed_methods, reason = "what goes over a real socket takes its time")]

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};

use super::*;

/// A robot on loopback, and the drives that are connected to it.
struct Robot {
    requests: TcpStream,
    states: UdpSocket,
    to: SocketAddr,
    drives: Box<dyn Driver<Fr3>>,
    state: State,
}

impl Robot {
    fn opened() -> Robot {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("bound").port();
        let states = UdpSocket::bind("127.0.0.1:0").expect("a port");
        let settings = FciSettings { port, ..FciSettings::new(IpAddr::from([127, 0, 0, 1])) };
        let mut drives: Box<dyn Driver<Fr3>> = Box::new(Fci::new(settings));
        let says = states.try_clone().expect("the same socket");
        let state = standing(1, START, Mode::Idle);
        let robot = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("somebody");
            let mut asked = [0; 16];
            stream.read_exact(&mut asked).expect("a request");
            assert_eq!((asked[0], u16::from_le_bytes([asked[12], asked[13]])), (0, 10));
            let to = SocketAddr::from(([127, 0, 0, 1], u16::from_le_bytes([asked[14], asked[15]])));
            stream.write_all(&[&asked[..8], &[15, 0, 0, 0, 0, 10, 0]].concat()).expect("sent");
            // A stranger's state is not looked at.
            let stranger = UdpSocket::bind("127.0.0.2:0").expect("a port");
            stranger.send_to(&bytes(&standing(7, [0.75; JOINTS], Mode::Idle), 0), to).expect("sent");
            says.send_to(&bytes(&state, 0), to).expect("sent");
            (stream, to)
        });
        let opened = drives.open();
        let (requests, to) = robot.join().expect("the robot");
        opened.expect("the robot answers");
        Robot { requests, states, to, drives, state }
    }

    /// The robot's next state, and what the drives say to it.
    fn says(&mut self, change: impl FnOnce(&mut State)) -> Result<Pulse, DriveFault> {
        self.state.count += 1;
        change(&mut self.state);
        let bytes = bytes(&self.state, u8::from(self.state.follows_positions));
        self.states.send_to(&bytes, self.to).expect("sent");
        loop {
            if let Some(pulse) = self.drives.pulse(Duration::ZERO)? {
                return Ok(pulse);
            }
            std::thread::sleep(Duration::from_micros(100));
        }
    }
}

#[test]
fn a_robot_on_a_network_is_connected_asked_for_a_motion_and_let_go() {
    let mut robot = Robot::opened();
    let measured = robot.drives.measured().expect("it has said where it is");
    assert!((measured.position - Joints::from(START)).amax() < 1e-6, "not where a stranger is");
    assert_eq!(robot.says(|_| {}).expect("it says something").count, 2);
    robot.drives.tick(&aside()).expect("a motion is asked for");
    let mut asked = [0; 125];
    robot.requests.read_exact(&mut asked).expect("a request");
    assert_eq!(asked[0], 1);
    robot.requests.write_all(&[&asked[..8], &[13, 0, 0, 0, STARTED]].concat()).expect("sent");
    robot.says(|state| (state.mode, state.follows_positions) = (Mode::Move, true)).expect("it moves");
    // On a busy machine an answer may be too late to be sent, and is then left out.
    let (mut answered, mut bytes) = (0, [0; 512]);
    robot.states.set_nonblocking(true).expect("set");
    while answered == 0 {
        robot.says(|_| {}).expect("it goes on");
        robot.drives.tick(&Joints::from(robot.state.q_d)).expect("told");
        answered += u32::from(robot.states.recv(&mut bytes).is_ok());
    }
    robot.says(|state| (state.mode, state.follows_positions) = (Mode::Idle, false)).expect("it stands");
    drop(robot.requests);
    robot.drives.close();
    assert_eq!(robot.drives.measured(), Err(CLOSED));
}

#[test]
fn fault_99_a_connection_that_the_robot_closes_is_told() {
    let mut robot = Robot::opened();
    robot.says(|_| {}).expect("it says something");
    robot.requests.shutdown(std::net::Shutdown::Both).expect("open");
    let cut_off = loop {
        match robot.drives.pulse(Duration::ZERO) {
            Ok(_) => std::thread::sleep(Duration::from_micros(100)),
            Err(fault) => break fault,
        }
    };
    assert_eq!(cut_off, CUT_OFF);
}

#[test]
fn fault_96_a_robot_that_is_not_there_is_told() {
    // Nobody listens at a port that was free a moment ago.
    let port = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port").port();
    let settings = FciSettings { port, ..FciSettings::new(IpAddr::from([127, 0, 0, 1])) };
    let mut drives: Box<dyn Driver<Fr3>> = Box::new(Fci::new(settings));
    assert_eq!(drives.open(), Err(ABSENT));
}
