//! The driver and the controller over sockets on loopback, in real time. No test depends on how long something takes.

use core::time::Duration;
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};

use mrroc::robot::{ClearedBy, DriveFault, Driver, Recovery, RobotStop, StopCause};
use mrroc_robots::{Serial, Six};
use mrroc_ur::{
    Calibration, Connected, Ended, Job, JobState, Ports, SetPoint, Sockets, Ur, UrModel, UrSettings, Wire,
};
use mrroc_ur_controller::{Press, Server};

/// How long either end waits for the other one.
const PATIENCE: Duration = Duration::from_secs(5);

/// Drives for the arm of a UR5e.
type Drives = Ur;
/// The drives as an EDP sees them.
type Edp = dyn Driver<Serial<6>>;

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

fn bench() -> (Server, Drives) {
    let (server, settings) = served();
    (server, Ur::new(settings))
}

fn served() -> (Server, UrSettings) {
    let free = Ports { dashboard: 0, primary: 0, secondary: 0, rtde: 0 };
    let address = "127.0.0.1".parse().expect("an address");
    let server = Server::start(UrModel::Ur5e, start(), address, free).expect("free ports");
    let mut settings = UrSettings::new(UrModel::Ur5e, address, SocketAddr::new(address, 0));
    settings.ports = server.listening().ports;
    // A busy machine may let either end wait: that is no case of these tests.
    settings.read_timeout = PATIENCE;
    settings.patience = PATIENCE;
    (server, settings)
}

/// The next period; the fault of drives that have stopped.
#[expect(clippy::disallowed_methods, reason = "the driver does not wait for its robot by itself")]
fn period(drives: &mut Edp, demanded: &Six) -> Result<u64, DriveFault> {
    loop {
        if let Some(pulse) = drives.pulse(Duration::ZERO)? {
            drives.tick(demanded)?;
            return Ok(pulse.count);
        }
        std::thread::sleep(Duration::from_micros(100));
    }
}

/// Goes on with periods until the drives stop.
fn stopped(drives: &mut Edp, demanded: &Six) -> RobotStop {
    loop {
        match period(drives, demanded) {
            Ok(_) => {}
            Err(DriveFault::Stopped(stop)) => return stop,
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn the_arm_follows_over_sockets_and_the_drives_see_inputs_and_outputs() {
    let (server, mut ur) = bench();
    let drives: &mut Edp = &mut ur;
    assert!(drives.measured().is_err(), "nothing is open yet");
    drives.open().expect("the controller answers, and its script calls");
    assert!(server.with(|controller| controller.runs()).expect("it serves"));
    server.with(|controller| controller.set_digital_inputs(0b1010));
    let first = period(drives, &start()).expect("it goes on");
    // 0.1 rad within a second, at any pace of the machine.
    let mut goal = start();
    for k in 1..=500 {
        goal[0] = 2e-4 * f64::from(k);
        period(drives, &goal).expect("it goes on");
    }
    for _ in 0..200 {
        period(drives, &goal).expect("it goes on");
    }
    let count = period(drives, &goal).expect("it goes on");
    assert!(count >= first + 700, "{first} {count}");
    let (target, measured) = server.with(|c| (c.target(), c.measured().position)).expect("it serves");
    assert!((target - goal).amax() <= 0.5e-6 && (measured - goal).amax() < 1e-3, "{target} {measured}");
    assert_eq!(ur.state().map(|state| state.digital_inputs), Some(0b1010));
    let drives: &mut Edp = &mut ur;
    drives.close();
    while server.with(|controller| controller.runs()).expect("it serves") {}
}

/// Drives whose program was stopped at the pendant, and how they told it.
fn stopped_at_the_pendant() -> (Server, Drives, RobotStop) {
    let (server, mut ur) = bench();
    let drives: &mut Edp = &mut ur;
    drives.open().expect("it opens");
    period(drives, &start()).expect("it goes on");
    server.with(|controller| controller.press(Press::StopProgram));
    let stop = stopped(drives, &start());
    (server, ur, stop)
}

#[test]
fn fault_90_a_line_that_is_cut_is_told_and_a_reset_sends_the_script_again() {
    let (server, mut ur, stop) = stopped_at_the_pendant();
    assert_eq!((stop.cause(), stop.cleared_by()), (StopCause::ProgramNotRunning, ClearedBy::Operator));
    let drives: &mut Edp = &mut ur;
    assert!(drives.switch_on().is_err(), "nobody has asked for a reset");
    while drives.recover().expect("it is in remote control") == Recovery::GoesOn {
        let _ = drives.pulse(Duration::ZERO);
    }
    drives.switch_on().expect("the script has called");
    assert_eq!(drives.held(), Some(start()));
    period(drives, &start()).expect("it goes on");
    // In local control nobody sends anything.
    server.with(|controller| {
        controller.press(Press::StopProgram);
        controller.press(Press::TakeOver);
    });
    stopped(drives, &start());
    let refused = loop {
        match drives.recover() {
            Ok(Recovery::GoesOn) => {}
            Ok(Recovery::Over) => panic!("it was sent all the same"),
            Err(DriveFault::Stopped(stop)) => break stop,
            Err(other) => panic!("{other}"),
        }
    };
    assert_eq!((refused.cause(), refused.cleared_by()), (StopCause::PendantInControl, ClearedBy::Pendant));
}

#[test]
fn fault_94_others_that_call_the_port_of_the_script_are_not_read_and_counted() {
    let (_server, mut ur) = bench();
    let drives: &mut Edp = &mut ur;
    drives.open().expect("it opens");
    let listen = mrroc_ur::Wire::reverse(ur.wire());
    // From the robot's address, while its script is connected; others are tested in the driver kit.
    let _second = TcpStream::connect(listen).expect("the port is open");
    while ur.wire().refused().is_some_and(|refused| refused.second == 0) {}
    let drives: &mut Edp = &mut ur;
    period(drives, &start()).expect("it goes on");
}

/// The nominal dimensions of a UR5e, but for one.
fn calibration(d6: f64) -> Calibration {
    let mut calibration = Calibration::nominal(UrModel::Ur5e);
    calibration.d[5] += d6;
    calibration
}

#[test]
fn the_calibration_is_read_from_the_primary_interface_before_anything_is_open() {
    let (server, mut ur) = bench();
    let told = |ur: &mut Drives| {
        let drives: &mut Edp = ur;
        let text = drives.calibration().expect("it answers").expect("it tells one");
        Calibration::parse(&text).expect("the text of a file")
    };
    assert_eq!(told(&mut ur), (UrModel::Ur5e, calibration(0.0)));
    server.with(|controller| controller.calibrate(&calibration(1e-3)).expect("a UR5e"));
    assert_eq!(told(&mut ur), (UrModel::Ur5e, calibration(1e-3)));
    drop(server);
    let drives: &mut Edp = &mut ur;
    let lost = drives.calibration().expect_err("nobody is there");
    assert!(lost.to_string().contains("nobody answers at its primary interface"), "{lost}");
}

#[test]
fn fault_110_an_arm_with_another_calibration_than_its_cell_is_not_opened() {
    let (server, settings) = served();
    server.with(|controller| controller.calibrate(&calibration(1e-3)).expect("a UR5e"));
    let with = |calibration| UrSettings { calibration: Some(calibration), ..settings };
    let mut other = Ur::new(with(calibration(0.9e-3)));
    let drives: &mut Edp = &mut other;
    let refused = drives.open().expect_err("another arm");
    assert!(refused.to_string().contains("is not that of this arm"), "{refused}");
    assert_eq!(server.with(|controller| controller.runs()), Some(false), "no script was sent");
    let mut same = Ur::new(with(calibration(1e-3)));
    let drives: &mut Edp = &mut same;
    drives.open().expect("the same arm");
}

#[test]
fn a_controller_that_is_not_there_is_told() {
    let (server, mut ur) = bench();
    drop(server);
    let drives: &mut Edp = &mut ur;
    let lost = drives.open().expect_err("nobody is there");
    assert!(lost.to_string().contains("nobody answers at its address"), "{lost}");
}

#[test]
fn fault_90_a_network_that_takes_no_more_set_points_is_told_as_communication_lost() {
    let (_server, settings) = served();
    let mut wire = Sockets::new(settings.robot, settings.listen, settings.ports);
    wire.connect(mrroc_ur::outputs::Groups::NONE).expect("it answers");
    // A script that the controller does not know; in its place this test calls, and reads nothing.
    wire.begin(Job::Start("def other():\nend\n".to_owned()));
    let deaf = TcpStream::connect(wire.reverse()).expect("the port is open");
    while wire.job() == JobState::Busy {}
    assert_eq!(wire.script(), Connected::Yes);
    let message = SetPoint::to(&start().into(), Duration::from_millis(20));
    while wire.tell(&message) {}
    assert_eq!(wire.script(), Connected::Ended(Some(Ended::Timeout)));
    drop(deaf);
}

/// Drives whose script a person starts at the pendant, over and over until they are open: before they listen it ends at once. The pendant
/// must know their port before; nothing, if somebody else has taken it meanwhile.
#[expect(clippy::disallowed_methods, reason = "who takes a lock again at once leaves it to nobody else")]
fn opened_from_the_pendant() -> Option<(Server, Drives)> {
    let (server, settings) = served();
    let free = std::net::TcpListener::bind(SocketAddr::new(settings.robot, 0)).expect("a port");
    let at = free.local_addr().expect("it has an address");
    drop(free);
    let mut ur = Ur::new(UrSettings { external_control: Some(at), ..settings });
    server.with(move |controller| {
        controller.press(Press::TakeOver);
        controller.set_external_control(at);
    });
    let ends = AtomicBool::new(false);
    let opened = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !ends.load(Ordering::Acquire) {
                server.with(|controller| {
                    if !controller.runs() {
                        controller.press(Press::Play);
                    }
                });
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let drives: &mut Edp = &mut ur;
        let opened = drives.open();
        ends.store(true, Ordering::Release);
        opened
    });
    match opened {
        Ok(()) => Some((server, ur)),
        Err(why) => {
            println!("{why}");
            None
        }
    }
}

#[test]
fn a_program_node_of_the_pendant_asks_for_the_script_in_local_control() {
    let opened = (0..5).find_map(|_| opened_from_the_pendant());
    let (server, mut ur) = opened.expect("the program is started");
    let drives: &mut Edp = &mut ur;
    let mut goal = start();
    for k in 1..=100 {
        goal[0] = 2e-4 * f64::from(k);
        period(drives, &goal).expect("it goes on");
    }
    // It is stopped at the pendant, and started again there: a reset finds it.
    server.with(|controller| controller.press(Press::StopProgram));
    let stop = stopped(drives, &start());
    assert_eq!((stop.cause(), stop.cleared_by()), (StopCause::ProgramNotRunning, ClearedBy::Operator));
    server.with(|controller| controller.press(Press::Play));
    while drives.recover().expect("it is started") == Recovery::GoesOn {
        let _ = drives.pulse(Duration::ZERO);
    }
    drives.switch_on().expect("the script has called");
    let held = drives.held().expect("a state");
    period(drives, &held).expect("it goes on");
}
