//! The driver and the controller over sockets on loopback, in real time. No test depends on how long something takes.

#![expect(clippy::disallowed_methods, reason = "the driver does not wait for its robot by itself")]

use core::time::Duration;
use std::net::{SocketAddr, TcpStream};

use mrroc::robot::{DriveFault, Driver};
use mrroc_robots::{Serial, Six};
use mrroc_ur::outputs::Groups;
use mrroc_ur::{
    Calibration, Connected, Ended, Job, JobState, Ports, Script, SetPoint, Sockets, Ur, UrModel, UrSettings,
    Wire,
};
use mrroc_ur_controller::{Press, Server};

/// How long either end waits for the other one.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Between two looks.
const LOOK: Duration = Duration::from_micros(100);

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

fn served() -> (Server, UrSettings) {
    let free = Ports { dashboard: 0, primary: 0, secondary: 0, rtde: 0 };
    let address = "127.0.0.1".parse().expect("an address");
    let server = Server::start(UrModel::Ur5e, start(), address, free).expect("free ports");
    let mut settings = UrSettings::new(UrModel::Ur5e, address, SocketAddr::new(address, 0));
    settings.ports = server.listening().ports;
    // A busy machine may let either end wait: that is no case of these tests.
    settings.read_timeout = TIMEOUT;
    settings.timeout = TIMEOUT;
    (server, settings)
}

/// The next period; the fault of drives that have stopped.
fn period(drives: &mut dyn Driver<Serial<6>>, demanded: &Six) -> Result<u64, DriveFault> {
    loop {
        if let Some(pulse) = drives.pulse(Duration::ZERO)? {
            drives.tick(demanded)?;
            return Ok(pulse.count);
        }
        std::thread::sleep(LOOK);
    }
}

#[test]
fn the_arm_follows_over_sockets_and_a_controller_that_goes_away_is_told() {
    let (server, settings) = served();
    let mut ur = Ur::new(settings);
    let drives: &mut dyn Driver<Serial<6>> = &mut ur;
    let told = drives.calibration().expect("it answers").expect("it tells one");
    let nominal = Calibration::nominal(UrModel::Ur5e);
    assert_eq!(Calibration::parse(&told), Ok((UrModel::Ur5e, nominal)));
    drives.open().expect("the controller answers, and its script calls");
    let first = period(drives, &start()).expect("it goes on");
    let mut goal = start();
    for k in 1..=50 {
        goal[0] = 2e-4 * f64::from(k);
        period(drives, &goal).expect("it goes on");
    }
    assert!(period(drives, &goal).expect("it goes on") > first + 50);
    // The last set-points are on their way.
    while server.with(move |controller| (controller.target() - goal).amax() > 0.5e-6).expect("it serves") {
        period(drives, &goal).expect("it goes on");
    }
    drop(server);
    // The script's connection may be the first that is seen to have ended.
    let is_lost = |fault: &DriveFault| fault.to_string().contains("the controller has closed its RTDE");
    while !drives.pulse(Duration::ZERO).is_err_and(|fault| is_lost(&fault)) {
        std::thread::sleep(LOOK);
    }
    drives.close();
    let absent = drives.open().expect_err("nobody is there");
    assert!(absent.to_string().contains("nobody answers at its address"), "{absent}");
}

#[test]
fn fault_90_a_socket_that_takes_no_more_set_points_is_told_as_communication_lost() {
    let (_server, settings) = served();
    let mut wire = Sockets::new(settings.robot, settings.listen, settings.ports);
    wire.connect(Groups::NONE).expect("it answers");
    // A script that the controller does not know; in its place this test calls, and reads nothing.
    wire.begin(Job::Start("def other():\nend\n".to_owned()));
    let deaf = TcpStream::connect(wire.reverse()).expect("the port is open");
    while wire.job() == JobState::Busy {
        std::thread::sleep(LOOK);
    }
    assert_eq!(wire.script(), Connected::Yes);
    let message = SetPoint::to(&start().into(), Duration::from_millis(20));
    while wire.tell(&message) {}
    assert_eq!(wire.script(), Connected::Ended(Some(Ended::Timeout)));
    drop(deaf);
}

#[test]
fn a_program_node_asks_for_the_script_over_sockets() {
    let (server, settings) = served();
    let any = SocketAddr::new(settings.robot, 0);
    let mut wire = Sockets::new(settings.robot, settings.listen, settings.ports).asked_at(Some(any));
    wire.connect(Groups::NONE).expect("it answers");
    let node = wire.node().expect("it listens");
    wire.begin(Job::Offer(Script::new(wire.reverse(), 9.0).node_text()));
    server.with(move |controller| {
        controller.press(Press::TakeOver);
        controller.set_external_control(node);
        controller.press(Press::Play);
    });
    let state = loop {
        while wire.heard(Duration::ZERO).expect("it is connected").is_some() {}
        match wire.job() {
            JobState::Busy => std::thread::sleep(LOOK),
            state => break state,
        }
    };
    assert_eq!((state, wire.script()), (JobState::Done, Connected::Yes));
    assert_eq!(server.with(|controller| controller.runs()), Some(true));
}
