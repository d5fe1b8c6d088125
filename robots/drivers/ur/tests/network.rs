//! The driver and all interfaces of a controller in one process, under a virtual clock: how it is connected, started, released and
//! lost, to the period.

use core::time::Duration;
use std::net::{Ipv4Addr, SocketAddr};

use mrroc::robot::{ClearedBy, DriveFault, Driver, Recovery, RobotStop, StopCause};
use mrroc_robots::{Serial, Six};
use mrroc_ur::outputs::Groups;
use mrroc_ur::{
    Calibration, Connected, ConnectionLost, Connections, Ended, Job, JobState, Network, PERIOD, Ports,
    Script, SetPoint, Ur, UrModel, UrSettings, Wire,
};
use mrroc_ur_controller::{Controller, Interface, OnCall, Press, VirtualNetwork};

/// Drives for the arm of a UR5e.
type Drives = Ur<Connections<VirtualNetwork>>;
/// The drives as an EDP sees them.
type Edp = dyn Driver<Serial<6>>;

/// How often the drives look for what they wait for, and how long they wait for a job, when they are opened.
const LOOK: Duration = Duration::from_micros(200);
const STEP: Duration = Duration::from_millis(1);

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

fn network() -> VirtualNetwork {
    VirtualNetwork::new(Controller::new(UrModel::Ur5e, &start()).expect("an arm"))
}

fn settings() -> UrSettings {
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    UrSettings::new(UrModel::Ur5e, VirtualNetwork::ROBOT, listen)
}

fn connections(network: &VirtualNetwork, settings: &UrSettings) -> Connections<VirtualNetwork> {
    let wire = Connections::over(network.clone(), settings.robot, settings.listen, Ports::default());
    wire.asked_at(settings.external_control)
}

fn drives(network: &VirtualNetwork, settings: UrSettings) -> Drives {
    Ur::over(connections(network, &settings), settings)
}

/// A controller, and drives that are open.
fn opened() -> (VirtualNetwork, Drives) {
    let network = network();
    let mut drives = drives(&network, settings());
    edp(&mut drives).open().expect("the controller answers, and its script calls");
    (network, drives)
}

fn edp(drives: &mut Drives) -> &mut Edp {
    drives
}

/// The next period; the fault of drives that have stopped.
fn period(network: &VirtualNetwork, drives: &mut Drives, demanded: &Six) -> Result<u64, DriveFault> {
    network.pass(PERIOD);
    let pulse = edp(drives).pulse(Duration::ZERO)?.expect("a state comes in every period");
    edp(drives).tick(demanded)?;
    Ok(pulse.count)
}

/// The stop that is told in the next period.
fn stopped(network: &VirtualNetwork, drives: &mut Drives, demanded: &Six) -> RobotStop {
    match period(network, drives, demanded) {
        Err(DriveFault::Stopped(stop)) => stop,
        other => panic!("{other:?}"),
    }
}

/// Goes on with a reset in every period, until it is over or refused, and says how long that took.
fn recovered(network: &VirtualNetwork, drives: &mut Drives) -> (Result<(), RobotStop>, Duration) {
    let before = network.now();
    loop {
        match edp(drives).recover() {
            Ok(Recovery::Over) => return (Ok(()), network.now() - before),
            Ok(Recovery::GoesOn) => {}
            Err(DriveFault::Stopped(stop)) => return (Err(stop), network.now() - before),
            Err(other) => panic!("{other}"),
        }
        network.pass(PERIOD);
        let _ = edp(drives).pulse(Duration::ZERO);
    }
}

#[test]
fn the_arm_follows_over_all_interfaces_and_the_drives_see_inputs_and_outputs() {
    let network = network();
    let mut ur = drives(&network, settings());
    assert!(edp(&mut ur).measured().is_err(), "nothing is open yet");
    edp(&mut ur).open().expect("the controller answers, and its script calls");
    assert!(network.with(|controller| controller.runs()));
    network.with(|controller| controller.set_digital_inputs(0b1010));
    let first = period(&network, &mut ur, &start()).expect("it goes on");
    // 0.1 rad within a second.
    let mut goal = start();
    for k in 1..=500 {
        goal[0] = 2e-4 * f64::from(k);
        assert_eq!(period(&network, &mut ur, &goal), Ok(first + u64::from(k as u32)));
    }
    for _ in 0..200 {
        period(&network, &mut ur, &goal).expect("it goes on");
    }
    assert_eq!(period(&network, &mut ur, &goal), Ok(first + 701));
    let (target, measured) = network.with(|c| (c.target(), c.measured().position));
    assert!((target - goal).amax() <= 0.5e-6 && (measured - goal).amax() < 1e-3, "{target} {measured}");
    assert_eq!(network.with(|controller| controller.longest_gap()), 0, "no set-point was missing");
    assert_eq!(ur.state().map(|state| state.digital_inputs), Some(0b1010));
    edp(&mut ur).close();
    network.pass(2 * PERIOD);
    assert!(!network.with(|controller| controller.runs()));
}

#[test]
fn a_state_is_as_old_as_it_has_waited() {
    let (network, mut ur) = opened();
    network.pass(PERIOD);
    edp(&mut ur).pulse(Duration::ZERO).expect("it goes on");
    let into_period = Duration::from_nanos(network.now().as_nanos() as u64 % PERIOD.as_nanos() as u64);
    network.pass(PERIOD - into_period);
    network.pass(Duration::from_micros(700));
    let pulse = edp(&mut ur).pulse(Duration::ZERO).expect("it goes on").expect("a state");
    assert_eq!(pulse.age, Duration::from_micros(700));
}

#[test]
fn fault_90_a_line_that_is_cut_is_told_and_a_reset_sends_the_script_again() {
    let (network, mut ur) = opened();
    period(&network, &mut ur, &start()).expect("it goes on");
    network.with(|controller| controller.press(Press::StopProgram));
    let stop = stopped(&network, &mut ur, &start());
    assert_eq!((stop.cause(), stop.cleared_by()), (StopCause::ProgramNotRunning, ClearedBy::Operator));
    assert!(edp(&mut ur).switch_on().is_err(), "nobody has asked for a reset");
    let (over, took) = recovered(&network, &mut ur);
    assert_eq!((over, took), (Ok(()), STARTS));
    edp(&mut ur).switch_on().expect("the script has called");
    assert_eq!(edp(&mut ur).held(), Some(start()));
    period(&network, &mut ur, &start()).expect("it goes on");
    // In local control nobody sends anything.
    network.with(|controller| {
        controller.press(Press::StopProgram);
        controller.press(Press::TakeOver);
    });
    stopped(&network, &mut ur, &start());
    let (refused, took) = recovered(&network, &mut ur);
    let refused = refused.expect_err("it was sent all the same");
    assert_eq!((refused.cause(), refused.cleared_by()), (StopCause::PendantInControl, ClearedBy::Pendant));
    assert_eq!(took, 2 * PERIOD, "a greeting, and an answer");
}

/// A greeting and an answer of the dashboard, and the script's call.
const STARTS: Duration = Duration::from_millis(6);

#[test]
fn fault_90_a_controller_that_closes_its_connections_is_told_by_the_next_look() {
    let (network, mut ur) = opened();
    period(&network, &mut ur, &start()).expect("it goes on");
    network.cut();
    let lost = edp(&mut ur).pulse(Duration::ZERO).expect_err("nobody is there");
    assert!(lost.to_string().contains("the controller has closed its RTDE"), "{lost}");
}

#[test]
fn fault_94_others_that_call_the_port_of_the_script_are_not_read_and_counted() {
    let (network, mut ur) = opened();
    // From the robot's address, while its script is connected; others are tested in the driver kit.
    let second = network.call_from_robot(ur.wire().reverse()).expect("the port is open");
    assert_eq!(ur.wire().refused().map(|refused| refused.second), Some(1));
    drop(second);
    period(&network, &mut ur, &start()).expect("it goes on");
}

/// The nominal dimensions of a UR5e, but for one.
fn calibration(d6: f64) -> Calibration {
    let mut calibration = Calibration::nominal(UrModel::Ur5e);
    calibration.d[5] += d6;
    calibration
}

#[test]
fn the_calibration_is_read_from_the_primary_interface_before_anything_is_open() {
    let network = network();
    let mut ur = drives(&network, settings());
    let told = |ur: &mut Drives| {
        let text = edp(ur).calibration().expect("it answers").expect("it tells one");
        Calibration::parse(&text).expect("the text of a file")
    };
    assert_eq!(told(&mut ur), (UrModel::Ur5e, calibration(0.0)));
    network.with(|controller| controller.calibrate(&calibration(1e-3)).expect("a UR5e"));
    assert_eq!(told(&mut ur), (UrModel::Ur5e, calibration(1e-3)));
    for (on_call, says, time) in [
        (OnCall::Refuse, "nobody answers at its primary interface", Duration::ZERO),
        (OnCall::StaySilent, "does not tell its calibration", Duration::from_secs(2) + LOOK),
    ] {
        network.set(Interface::Primary, on_call);
        let before = network.now();
        let lost = edp(&mut ur).calibration().expect_err("it does not tell it");
        assert!(lost.to_string().contains(says), "{lost}");
        assert_eq!(network.now() - before, time);
    }
}

#[test]
fn fault_110_an_arm_with_another_calibration_than_its_cell_is_not_opened() {
    let network = network();
    network.with(|controller| controller.calibrate(&calibration(1e-3)).expect("a UR5e"));
    let with = |calibration| UrSettings { calibration: Some(calibration), ..settings() };
    let mut other = drives(&network, with(calibration(0.9e-3)));
    let refused = edp(&mut other).open().expect_err("another arm");
    assert!(refused.to_string().contains("is not that of this arm"), "{refused}");
    assert!(!network.with(|controller| controller.runs()), "no script was sent");
    let mut same = drives(&network, with(calibration(1e-3)));
    edp(&mut same).open().expect("the same arm");
}

#[test]
fn a_controller_that_is_not_there_or_says_nothing_is_told() {
    for (on_call, says, time) in [
        (OnCall::Refuse, "nobody answers at its address", Duration::ZERO),
        (OnCall::StaySilent, "the controller does not answer on RTDE", Duration::from_secs(2) + LOOK),
    ] {
        let network = network();
        network.set(Interface::Rtde, on_call);
        let lost = edp(&mut drives(&network, settings())).open().expect_err("nobody is there");
        assert!(lost.to_string().contains(says), "{lost}");
        assert_eq!(network.now(), time);
    }
}

/// Connections for which only RTDE is connected.
fn connected() -> (VirtualNetwork, Connections<VirtualNetwork>) {
    let network = network();
    let mut wire = connections(&network, &settings());
    wire.connect(Groups::NONE).expect("it answers");
    (network, wire)
}

/// What becomes of a job, and how long that takes; it is asked for in every period.
fn done(network: &VirtualNetwork, wire: &mut Connections<VirtualNetwork>, job: Job) -> (JobState, Duration) {
    let before = network.now();
    wire.begin(job);
    loop {
        match wire.job() {
            JobState::Busy => network.pass(PERIOD),
            state => {
                assert_eq!(wire.job(), JobState::None, "it is said once");
                return (state, network.now() - before);
            }
        }
    }
}

fn script(wire: &Connections<VirtualNetwork>) -> Job {
    Job::Start(Script::new(wire.reverse(), 9.0).text())
}

#[test]
fn fault_90_a_network_that_takes_no_more_set_points_is_told_as_communication_lost() {
    let (network, mut wire) = connected();
    // A script that the controller does not know; in its place this test calls, and reads nothing.
    wire.begin(Job::Start("def other():\nend\n".to_owned()));
    let deaf = network.call_from_robot(wire.reverse()).expect("the port is open");
    assert_eq!((wire.job(), wire.script()), (JobState::Done, Connected::Yes));
    let message = SetPoint::to(&start().into(), Duration::from_millis(20));
    let told = (0..).take_while(|_| wire.tell(&message)).count();
    assert_eq!(told, 256 * 1024 / mrroc_ur::SET_POINT_BYTES);
    assert_eq!(wire.script(), Connected::Ended(Some(Ended::Timeout)));
    drop(deaf);
}

#[test]
fn a_script_is_sent_whatever_becomes_of_the_dashboard_and_waited_for_for_5_s() {
    for (on_call, time) in [
        (OnCall::Serve, STARTS),
        // PolyScope X has none.
        (OnCall::Refuse, PERIOD),
        (OnCall::StaySilent, Duration::from_secs(2) + PERIOD),
    ] {
        let (network, mut wire) = connected();
        network.set(Interface::Dashboard, on_call);
        let job = script(&wire);
        assert_eq!(done(&network, &mut wire, job), (JobState::Done, time), "{on_call:?}");
        assert_eq!(wire.script(), Connected::Yes);
    }
    let (network, mut wire) = connected();
    network.set(Interface::Secondary, OnCall::Refuse);
    let job = script(&wire);
    let refused = JobState::Refused("the controller takes no script at its secondary interface");
    assert_eq!(done(&network, &mut wire, job), (refused, 2 * PERIOD));
    network.set(Interface::Secondary, OnCall::StaySilent);
    let job = script(&wire);
    let late = JobState::Refused("the script was sent, and does not call this machine");
    assert_eq!(done(&network, &mut wire, job), (late, Duration::from_secs(5) + PERIOD));
    assert_eq!(wire.script(), Connected::NotYet);
}

#[test]
fn fault_91_a_protective_stop_is_released_5_s_after_it_or_refused_after_10_s() {
    let (network, mut wire) = connected();
    network.with(|controller| controller.press(Press::Collide));
    // A greeting, two answers, and then every 250 ms a trial with a period for its answer: the 21st is the first after 5 s.
    let trials = 20 * (Duration::from_millis(250) + PERIOD) + PERIOD;
    assert_eq!(done(&network, &mut wire, Job::Unlock), (JobState::Done, 3 * PERIOD + trials));
    // What needs a person is not released.
    network.with(|controller| {
        controller.press(Press::Collide);
        controller.press(Press::Violate);
    });
    let held = JobState::Refused("the controller does not release it");
    assert_eq!(done(&network, &mut wire, Job::Unlock), (held, Duration::from_secs(10) + PERIOD));
    network.set(Interface::Dashboard, OnCall::Refuse);
    let silent = JobState::Refused("its dashboard does not answer");
    assert_eq!(done(&network, &mut wire, Job::Unlock), (silent, Duration::ZERO));
    network.set(Interface::Dashboard, OnCall::StaySilent);
    assert_eq!(done(&network, &mut wire, Job::Unlock), (silent, Duration::from_secs(2)));
}

#[test]
fn a_job_in_place_of_another_ends_that_one() {
    let (network, mut wire) = connected();
    network.set(Interface::Secondary, OnCall::StaySilent);
    let job = script(&wire);
    wire.begin(job);
    network.pass(PERIOD);
    assert_eq!(wire.job(), JobState::Busy);
    network.set(Interface::Secondary, OnCall::Serve);
    let job = script(&wire);
    assert_eq!(done(&network, &mut wire, job), (JobState::Done, STARTS));
    wire.disconnect();
    assert_eq!(
        (wire.job(), wire.heard(Duration::ZERO)),
        (JobState::None, Err(ConnectionLost("RTDE is not connected")))
    );
}

/// Where a program node asks for the script.
const NODE: SocketAddr = SocketAddr::new(VirtualNetwork::ROBOT, 50002);

#[test]
fn a_program_node_of_the_pendant_asks_for_the_script_in_local_control() {
    let network = network();
    network.with(|controller| {
        controller.press(Press::TakeOver);
        controller.set_external_control(NODE);
        // The node asks when its program is started, and is answered as soon as the drives listen.
        controller.press(Press::Play);
    });
    let settings = UrSettings { external_control: Some(NODE), ..settings() };
    let mut ur = drives(&network, settings);
    edp(&mut ur).open().expect("the program is started");
    assert_eq!(ur.wire().node(), Some(NODE));
    let mut goal = start();
    for k in 1..=100 {
        goal[0] = 2e-4 * f64::from(k);
        period(&network, &mut ur, &goal).expect("it goes on");
    }
    // It is stopped at the pendant, and started again there: a reset finds it.
    network.with(|controller| controller.press(Press::StopProgram));
    let stop = stopped(&network, &mut ur, &start());
    assert_eq!((stop.cause(), stop.cleared_by()), (StopCause::ProgramNotRunning, ClearedBy::Operator));
    network.with(|controller| controller.press(Press::Play));
    let (over, took) = recovered(&network, &mut ur);
    assert_eq!((over, took), (Ok(()), 2 * PERIOD), "the node asks, and the script calls");
    edp(&mut ur).switch_on().expect("the script has called");
    let held = edp(&mut ur).held().expect("a state");
    period(&network, &mut ur, &held).expect("it goes on");
    // Nobody starts it.
    network.with(|controller| controller.press(Press::StopProgram));
    stopped(&network, &mut ur, &start());
    let (refused, took) = recovered(&network, &mut ur);
    let named = refused.expect_err("nobody starts it").to_string();
    assert!(named.contains("start the program with the External Control node at the pendant"), "{named}");
    assert_eq!(took, Duration::from_secs(18) + PERIOD);
}

#[test]
fn drives_whose_program_nobody_starts_are_not_opened_after_18_s() {
    let network = network();
    let mut ur = drives(&network, UrSettings { external_control: Some(NODE), ..settings() });
    let refused = edp(&mut ur).open().expect_err("nobody starts it").to_string();
    assert!(refused.contains("start the program with the External Control node at the pendant"), "{refused}");
    let connected = network.now() - Duration::from_secs(18);
    assert!((STEP..20 * STEP).contains(&connected), "{connected:?}");
    assert_eq!(ur.wire().node(), None, "the port is let go");
}
