//! The drives against a robot that a test plays, over loopback.

use std::io::{Read, Write};
use std::net::{IpAddr, TcpListener, TcpStream, UdpSocket};

use super::*;
use crate::arm::Fr3;
use crate::behaviour::{Collision, Stiffness};
use crate::message::testing::{bytes, standing};
use crate::message::{COMMAND, COMMUNICATION, JOINTS};
use crate::stops::stop;

const START: [f64; JOINTS] = [0.0, 0.25, 0.0, -1.5, 0.0, 1.5, 0.5];

/// A robot on loopback, and the drives that are connected to it.
struct Bench {
    requests: TcpStream,
    states: UdpSocket,
    to: SocketAddr,
    drives: Box<dyn Driver<Fr3>>,
    state: State,
}

impl Bench {
    fn opened() -> Bench {
        Bench::connected(10).expect("opened")
    }

    /// A robot with this version of the interface.
    fn connected(version: u16) -> Result<Bench, DriveFault> {
        Bench::with(version, |settings| settings)
    }

    fn with(version: u16, change: impl FnOnce(FciSettings) -> FciSettings) -> Result<Bench, DriveFault> {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("bound").port();
        let states = UdpSocket::bind("127.0.0.1:0").expect("a port");
        states.set_read_timeout(Some(Duration::from_millis(20))).expect("set");
        let settings = FciSettings { port, ..FciSettings::new(IpAddr::from([127, 0, 0, 1])) };
        let mut drives: Box<dyn Driver<Fr3>> = Box::new(Fci::new(change(settings)));
        assert!(drives.measured().is_err(), "nothing is open yet");
        let says = states.try_clone().expect("the same socket");
        let robot = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("somebody");
            let asked = request(&mut stream);
            assert_eq!((asked[0], u16::from_le_bytes([asked[12], asked[13]])), (0, 10));
            let status = u8::from(version != 10);
            let to = SocketAddr::from(([127, 0, 0, 1], u16::from_le_bytes([asked[14], asked[15]])));
            answer(&mut stream, &asked, &[[status].as_slice(), &version.to_le_bytes()].concat());
            // A stranger's state is not looked at.
            let stranger = UdpSocket::bind("127.0.0.2:0").expect("a port");
            stranger.send_to(&bytes(&standing(7, [0.75; JOINTS], Mode::Idle), 0), to).expect("sent");
            says.send_to(&bytes(&standing(1, START, Mode::Idle), 0), to).expect("sent");
            (stream, to)
        });
        let opened = drives.open();
        let (requests, to) = robot.join().expect("the robot");
        opened?;
        Ok(Bench { requests, states, to, drives, state: standing(1, START, Mode::Idle) })
    }

    /// The robot's next state, and what the drives say to it.
    fn says(&mut self, change: impl FnOnce(&mut State)) -> Result<Pulse, DriveFault> {
        self.state.count += 1;
        change(&mut self.state);
        self.states
            .send_to(&bytes(&self.state, u8::from(self.state.follows_positions)), self.to)
            .expect("sent");
        loop {
            if let Some(pulse) = self.drives.pulse(Duration::ZERO)? {
                return Ok(pulse);
            }
            std::thread::yield_now();
        }
    }

    /// What the robot is told: the count that is answered, the positions, and whether they are the last.
    fn told(&self) -> Option<(u64, Joints, bool)> {
        let mut bytes = [0; COMMAND + 1];
        let len = self.states.recv(&mut bytes).ok()?;
        assert_eq!(len, COMMAND);
        let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight"));
        let count = u64::from_le_bytes(bytes[..8].try_into().expect("eight"));
        Some((count, Joints::from_fn(|i, _| number(8 + 8 * i)), bytes[313] == 1))
    }

    /// The same for the robot's last state.
    fn told_now(&self) -> Option<(u64, Joints, bool)> {
        loop {
            let told = self.told();
            if told.is_none_or(|(count, ..)| count == self.state.count) {
                return told;
            }
        }
    }

    /// The robot follows what it is told from the next state on.
    fn follows(&mut self, told: &Joints) {
        let now = Joints::from(self.state.q_d);
        self.state.dq_d = ((told - now) / 1e-3).into();
        self.state.q_d = (*told).into();
        self.state.q = self.state.q_d;
    }

    /// Until a motion runs, with the arm held where it stands but for a little that is demanded.
    fn moving() -> Bench {
        let mut bench = Bench::opened();
        bench.says(|_| {}).expect("it says something");
        bench.drives.tick(&Joints::from(START)).expect("held");
        // Where it is held anyway it holds by itself.
        let aside = Joints::from(START) + Joints::repeat(1e-6);
        bench.drives.tick(&aside).expect("a motion is asked for");
        let asked = request(&mut bench.requests);
        assert_eq!((asked[0], asked.len()), (1, 125));
        // The state that shows it may come before the answer.
        bench.says(|state| (state.mode, state.follows_positions) = (Mode::Move, true)).expect("it moves");
        answer(&mut bench.requests, &asked, &[STARTED]);
        bench.says(|_| {}).expect("it moves");
        bench
    }
}

/// The next request.
fn request(stream: &mut TcpStream) -> Vec<u8> {
    let mut header = [0; 12];
    stream.read_exact(&mut header).expect("a request");
    let size = u32::from_le_bytes([header[8], header[9], header[10], header[11]]);
    let mut rest = vec![0; size as usize - 12];
    stream.read_exact(&mut rest).expect("the rest of it");
    [header.as_slice(), &rest].concat()
}

fn answer(stream: &mut TcpStream, asked: &[u8], says: &[u8]) {
    let size = (12 + says.len() as u32).to_le_bytes();
    stream.write_all(&[&asked[..8], &size, says].concat()).expect("sent");
}

#[test]
fn a_motion_begins_where_the_robot_is_held_and_every_state_gets_one_answer() {
    let mut bench = Bench::moving();
    let held = bench.drives.held().expect("known");
    assert_eq!(held, Joints::from(START));
    let mut last = held;
    for _ in 0..50 {
        let demanded = last + Joints::repeat(1e-8);
        bench.drives.tick(&demanded).expect("told");
        let Some((count, told, is_last)) = bench.told_now() else {
            // This machine was later than the robot waits; it goes on by itself.
            bench.says(|_| {}).expect("it goes on");
            continue;
        };
        assert_eq!((count, is_last), (bench.state.count, false));
        assert!((told - last).amax() < 1e-6, "a jump of {} rad", (told - last).amax());
        bench.follows(&told);
        let pulse = bench.says(|_| {}).expect("it goes on");
        assert_eq!(pulse.count, bench.state.count);
        last = told;
    }
    let measured = bench.drives.measured().expect("read");
    assert!((measured.position - last).amax() < 1e-6);
}

#[test]
fn the_wrench_that_the_robot_estimates_is_told_at_its_flange_and_none_where_it_is_none() {
    let mut bench = Bench::opened();
    assert_eq!(bench.drives.wrench(), Some(Wrench::default()));
    // The robot pushes by 4 N along z and 1 N along x, 0.25 m before its flange: (0, 0, 0.25) x (-1, 0, -4) = (0, -0.25, 0).
    bench
        .says(|state| {
            state.external.F_T_EE[14] = 0.25;
            state.external.K_F_ext_hat_K = [1.0, 0.0, 4.0, 0.0, 0.0, 0.0];
        })
        .expect("it says something");
    let expected = Wrench::new([-1.0, 0.0, -4.0].into(), [0.0, -0.25, 0.0].into());
    assert_eq!(bench.drives.wrench(), Some(expected));
    bench.says(|state| state.external.K_F_ext_hat_K[5] = f64::NAN).expect("it says where it is");
    assert_eq!(bench.drives.wrench(), None);
    bench.drives.close();
    assert_eq!(bench.drives.wrench(), None);
}

#[test]
fn fault_96_a_robot_of_another_version_or_none_at_all_is_told_and_nothing_moves() {
    assert_eq!(Bench::connected(5).map(|_| ()), Err(OTHER_VERSION));
    // Nobody listens at a port that was free a moment ago.
    let port = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port").port();
    let settings = FciSettings { port, ..FciSettings::new(IpAddr::from([127, 0, 0, 1])) };
    let mut drives: Box<dyn Driver<Fr3>> = Box::new(Fci::new(settings));
    assert_eq!(drives.open(), Err(ABSENT));
}

#[test]
fn fault_97_a_reflex_is_told_by_its_name_and_a_reset_recovers_without_a_motion() {
    let mut bench = Bench::moving();
    let reflex = |state: &mut State| {
        (state.mode, state.follows_positions) = (Mode::Reflex, false);
        state.reason = Some("cartesian_reflex");
    };
    assert_eq!(bench.says(reflex).map(|_| ()), Err(stop(StopCause::Reflex, "cartesian_reflex")));
    assert_eq!(bench.drives.recover(), Ok(Recovery::GoesOn));
    let asked = request(&mut bench.requests);
    assert_eq!((asked[0], asked.len()), (10, 12));
    assert_eq!(bench.drives.recover(), Ok(Recovery::GoesOn));
    assert!(bench.drives.switch_on().is_err(), "the reflex holds still");
    // It has recovered. Its answer comes before the state that shows it.
    answer(&mut bench.requests, &asked, &[0]);
    let recovered = bench.says(|state| (state.mode, state.reason) = (Mode::Idle, None));
    assert!(recovered.is_ok());
    assert_eq!(bench.drives.recover(), Ok(Recovery::Over));
    assert_eq!(bench.drives.switch_on(), Ok(()));
    while bench.told().is_some() {}
    bench.drives.tick(&Joints::from(START)).expect("held");
    assert_eq!(bench.told(), None, "a reset moves nothing");
}

#[test]
fn fault_97_stops_at_the_robot_are_told_and_who_may_clear_them() {
    use mrroc::robot::ClearedBy;

    for (mode, reason, cause, cleared_by) in [
        (Mode::Reflex, Some(COMMUNICATION), StopCause::CommunicationLost, ClearedBy::Operator),
        (Mode::UserStopped, None, StopCause::Safeguard, ClearedBy::PersonAtRobot),
        (Mode::Guiding, None, StopCause::HandGuiding, ClearedBy::PersonAtRobot),
        (Mode::Other, None, StopCause::PowerOff, ClearedBy::Pendant),
    ] {
        let mut bench = Bench::moving();
        let said = bench.says(|state| (state.mode, state.reason) = (mode, reason));
        let Err(DriveFault::Stopped(stop)) = said else { panic!("{mode:?}: {said:?}") };
        assert_eq!((stop.cause(), stop.cleared_by()), (cause, cleared_by));
        // Only a reflex is what a reset may clear.
        assert_eq!(
            bench.drives.recover().is_ok_and(|recovery| recovery == Recovery::GoesOn),
            mode == Mode::Reflex
        );
        assert!(bench.drives.switch_on().is_err(), "{mode:?}");
    }
}

#[test]
fn fault_98_where_nobody_demands_anything_the_robot_is_brought_to_rest_and_held_and_its_motion_ends() {
    let mut bench = Bench::moving();
    // On its way at 0.1 rad/s, by its own word.
    bench.says(|state| state.dq_d = [0.1; JOINTS]).expect("it goes on");
    let (mut last, mut told) = (Joints::from(START), 0);
    bench.drives.switch_off();
    for states in 1..=2000 {
        bench.says(|_| {}).expect("it goes on");
        // What comes later than the robot waits, as on a late machine, is not told.
        let Some((_, position, is_last)) = bench.told() else { continue };
        assert!((position - last).amax() < 2e-4, "a jump");
        told += 1;
        if is_last {
            assert_eq!(position, last, "it ends at rest");
            bench
                .says(|state| (state.mode, state.follows_positions) = (Mode::Idle, false))
                .expect("it stands");
            assert!(states > 1, "it takes time to come to rest");
            assert_eq!(bench.drives.switch_on(), Ok(()));
            return;
        }
        bench.follows(&position);
        last = position;
    }
    panic!("the motion does not end after {told} answers");
}

#[test]
fn fault_99_a_demand_that_the_robot_would_not_take_is_refused_and_the_robot_is_held() {
    let mut bench = Bench::moving();
    assert_eq!(bench.drives.tick(&(Joints::from(START) + Joints::repeat(0.2))), Err(TOO_FAR));
    let mut bench = Bench::moving();
    assert!(bench.drives.tick(&Joints::repeat(f64::NAN)).is_err());
    // It is told to stay, not where it cannot go.
    if let Some((_, told, _)) = bench.told() {
        assert!((told - Joints::from(START)).amax() < 1e-6);
    }
    let mut bench = Bench::moving();
    drop(bench.requests);
    let cut_off = loop {
        bench.state.count += 1;
        bench.states.send_to(&bytes(&bench.state, 1), bench.to).expect("sent");
        if let Err(fault) = bench.drives.pulse(Duration::ZERO) {
            break fault;
        }
    };
    assert_eq!(cut_off, CUT_OFF);
}

const COLLISION: Collision = Collision {
    contact_torques: [10.0; JOINTS],
    collision_torques: [20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0],
    contact_forces: [5.0; 6],
    collision_forces: [25.0; 6],
};
const USUAL: Stiffness = [3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0];
const SOFT: Stiffness = [300.0; JOINTS];

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().expect("eight"))).collect()
}

#[test]
fn fault_111_thresholds_and_stiffness_are_told_while_the_robot_stands_and_other_sets_when_it_comes_to_rest() {
    let mut bench = Bench::with(10, |settings| FciSettings {
        collision: Some(COLLISION),
        stiffness: [Some(USUAL), Some(SOFT), None],
        ..settings
    })
    .expect("opened");
    assert!(bench.drives.has_regulator(0, 1) && !bench.drives.has_regulator(0, 2));
    let start = Joints::from(START);
    let aside = start + Joints::repeat(1e-6);
    // Something is demanded already; it waits.
    bench.says(|_| {}).expect("it says something");
    bench.drives.tick(&aside).expect("told");
    let asked = request(&mut bench.requests);
    assert_eq!((asked[0], asked.len()), (3, 428));
    let told = doubles(&asked[12..]);
    assert_eq!(
        (&told[..7], &told[7..14]),
        (&COLLISION.contact_torques[..], &COLLISION.collision_torques[..])
    );
    assert_eq!((&told[14..28], told[28], told[34]), (&told[..14], 5.0, 25.0));
    answer(&mut bench.requests, &asked, &[0]);
    let next = |bench: &mut Bench, demanded: &Joints| loop {
        bench.says(|_| {}).expect("it goes on");
        bench.drives.tick(demanded).expect("told");
        bench.requests.set_nonblocking(true).expect("set");
        let came = bench.requests.peek(&mut [0]).is_ok();
        bench.requests.set_nonblocking(false).expect("set");
        if came {
            break request(&mut bench.requests);
        }
    };
    let asked = next(&mut bench, &aside);
    assert_eq!((asked[0], doubles(&asked[12..])), (4, USUAL.to_vec()));
    answer(&mut bench.requests, &asked, &[0]);
    let asked = next(&mut bench, &aside);
    assert_eq!(asked[0], 1, "now it moves");
    bench.says(|state| (state.mode, state.follows_positions) = (Mode::Move, true)).expect("it moves");
    answer(&mut bench.requests, &asked, &[STARTED]);
    bench.says(|_| {}).expect("it moves");
    // Joint 4 alone is softer. The motion, which is at rest, ends.
    bench.drives.choose_regulators(&Regulators::uniform(0).with(3, 1));
    let is_last = loop {
        let held = bench.drives.held().expect("known");
        bench.drives.tick(&held).expect("held");
        let told = bench.told_now();
        bench.says(|_| {}).expect("it goes on");
        if let Some((.., true)) = told {
            break true;
        }
    };
    assert!(is_last);
    bench.says(|state| (state.mode, state.follows_positions) = (Mode::Idle, false)).expect("it stands");
    let asked = next(&mut bench, &start);
    let mut softer = USUAL;
    softer[3] = SOFT[3];
    assert_eq!((asked[0], doubles(&asked[12..])), (4, softer.to_vec()));
    // It refuses that.
    answer(&mut bench.requests, &asked, &[2]);
    let refused = loop {
        if let Err(fault) = bench.says(|_| {}) {
            break fault;
        }
    };
    assert!(refused.to_string().contains("the robot refuses the stiffness"), "{refused}");
}

#[test]
fn fault_117_a_load_is_told_while_the_robot_stands_and_one_that_it_refuses_is_a_fault() {
    let mut bench = Bench::opened();
    let start = Joints::from(START);
    // Nothing was said of it: the robot is told nothing.
    bench.says(|_| {}).expect("it says something");
    bench.drives.tick(&start).expect("held");
    let nothing = |bench: &Bench| {
        bench.requests.set_nonblocking(true).expect("set");
        let came = bench.requests.peek(&mut [0]).is_ok();
        bench.requests.set_nonblocking(false).expect("set");
        !came
    };
    assert!(nothing(&bench));
    // kg, m in the flange, kg m² about the centre; a matrix that is told column by column.
    let mut inertia = nalgebra::Matrix3::from_diagonal(&[1e-3, 2e-3, 3e-3].into());
    (inertia[(0, 1)], inertia[(1, 0)]) = (1e-4, 1e-4);
    let load = Load { mass: 1.5, centre: [0.01, 0.02, 0.03].into(), inertia };
    bench.drives.carry(&load);
    bench.drives.tick(&start).expect("told");
    let asked = request(&mut bench.requests);
    // 12 bytes of a header and 13 numbers of 64 bits: libfranka's `SetLoad`.
    assert_eq!((asked[0], asked.len()), (9, 116));
    let told = doubles(&asked[12..]);
    assert_eq!(told, [1.5, 0.01, 0.02, 0.03, 1e-3, 1e-4, 0.0, 1e-4, 2e-3, 0.0, 0.0, 0.0, 3e-3]);
    answer(&mut bench.requests, &asked, &[0]);
    for _ in 0..3 {
        bench.says(|_| {}).expect("it goes on");
        bench.drives.tick(&start).expect("held");
    }
    assert!(nothing(&bench), "it knows that now");
    // An end effector of Desk, which the robot adds by itself: half a kilogram at the origin of the flange.
    bench.says(|state| state.end_effector = Load::point(0.5, [0.0; 3].into())).expect("it goes on");
    bench.drives.carry(&Load::point(1.5, [0.0, 0.0, 0.03].into()));
    bench.drives.tick(&start).expect("told");
    let asked = request(&mut bench.requests);
    assert_eq!(doubles(&asked[12..])[..4], [1.0, 0.0, 0.0, 0.045], "1.5 times 0.03 is 1.0 times 0.045");
    answer(&mut bench.requests, &asked, &[0]);
    bench.says(|state| state.end_effector = Load::NONE).expect("it goes on");
    bench.drives.carry(&Load { mass: 30.0, ..load });
    bench.drives.tick(&start).expect("told");
    let asked = request(&mut bench.requests);
    assert_eq!(doubles(&asked[12..])[0], 30.0);
    answer(&mut bench.requests, &asked, &[2]);
    let refused = loop {
        if let Err(refused) = bench.says(|_| {}) {
            break refused;
        }
    };
    assert!(refused.to_string().contains("the robot refuses the load"), "{refused}");
}
