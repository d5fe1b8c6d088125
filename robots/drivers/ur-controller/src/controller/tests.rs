//! What the script does with the arm, step by step, against the equations of uniform motion and of uniform deceleration.

use core::time::Duration;

use mrroc_robots::Six;
use mrroc_ur::{Ask, Ended, Script, SetPoint, UrModel};

use super::{Controller, Press};

const T: f64 = 0.002;
const TIMEOUT: Duration = Duration::from_millis(20);

/// Half a µrad, to which set-points are rounded.
const ROUNDED: f64 = 0.5e-6;

fn start() -> Six {
    Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0)
}

/// A motion of all joints at once [rad/s].
fn speed() -> Six {
    Six::new(1.0, -0.5, 0.5, 0.0, 0.25, 0.1)
}

/// Steps in which [`speed`] is reached: 5 rad/s².
const RISE: u32 = 100;

/// Where the arm is told to be in a step, from rest on.
fn goal(step: u32) -> Six {
    let steps = f64::from(step);
    let rise = f64::from(RISE);
    let travelled = if step < RISE { steps * steps / (2.0 * rise) } else { steps - rise / 2.0 };
    start() + speed() * (T * travelled)
}

/// A controller whose script was told to go to this [`goal`] for so many steps.
fn moving(steps: u32, deceleration: f64) -> Controller {
    let mut controller = Controller::new(UrModel::Ur5e, &start()).expect("an arm");
    let script = Script::new("127.0.0.1:50001".parse().expect("an address"), deceleration);
    assert!(controller.take_script(&script.text()));
    assert_eq!(controller.calls(), Some(script.reverse));
    controller.connected(true);
    for k in 1..=steps {
        tell(&mut controller, &goal(k));
        controller.step();
    }
    controller
}

fn tell(controller: &mut Controller, q: &Six) {
    controller.take_set_point(&SetPoint::to(&(*q).into(), TIMEOUT).bytes());
}

#[test]
fn steps_without_a_set_point_go_on_at_the_same_speed() {
    let mut controller = moving(200, 9.0);
    (0..9).for_each(|_| controller.step());
    let expected = goal(209);
    // The speed is that of two set-points, each rounded to a µrad.
    assert!((controller.target() - expected).amax() <= ROUNDED + 9.0 * 2.0 * ROUNDED);
    assert_eq!((controller.longest_gap(), controller.says()), (9, None));
    // The next one is where it would have been.
    tell(&mut controller, &goal(210));
    controller.step();
    assert_eq!(controller.dashboard("safetymode"), "Safetymode: NORMAL");
    assert!(controller.runs());
}

#[test]
fn after_the_read_timeout_the_script_says_so_brakes_all_joints_together_and_is_gone() {
    let deceleration = 5.0;
    let mut controller = moving(200, deceleration);
    // Ten periods are the read timeout; in the eleventh it is over.
    (0..10).for_each(|_| controller.step());
    assert_eq!(controller.says(), None);
    let (from, at) = (controller.target(), controller.target_speed());
    controller.step();
    assert_eq!(controller.says(), Some(Ended::Timeout));
    assert!(controller.is_connected());
    let mut steps = 1;
    while controller.target_speed() != Six::zeros() {
        controller.step();
        steps += 1;
    }
    // v / a = 0.2 s for the fastest joint, and v² / 2a for its distance; one step more or less.
    let fastest = at.amax();
    assert!((f64::from(steps) * T - fastest / deceleration).abs() <= 1.5 * T, "{steps} steps");
    let gone = controller.target() - from;
    assert!((gone[0] - fastest * fastest / (2.0 * deceleration)).abs() <= fastest * T, "{gone}");
    // The others are braked in proportion: the joints stay on their line.
    for i in 1..6 {
        assert!((gone[i] - gone[0] * at[i] / at[0]).abs() < 1e-9, "{gone}");
    }
    controller.step();
    assert!(!controller.runs() && !controller.is_connected());
    assert_eq!(controller.dashboard("running"), "Program running: false");
    // The motors have come to rest there, within a thousandth of a radian.
    (0..250).for_each(|_| controller.step());
    assert!((controller.measured().position - controller.target()).amax() < 1e-3);
}

#[test]
fn the_first_set_point_is_waited_for_as_long_as_it_takes_and_the_end_is_done_when_asked() {
    let mut controller = moving(0, 9.0);
    (0..5000).for_each(|_| controller.step());
    assert!(controller.runs());
    assert_eq!(controller.target(), start());
    controller.take_set_point(&SetPoint::only(Ask::End, TIMEOUT).bytes());
    controller.step();
    assert_eq!(controller.says(), Some(Ended::Asked));
    controller.step();
    assert!(!controller.runs());
}

#[test]
fn a_slider_lowers_the_speed_that_joints_may_use() {
    let mut controller = moving(200, 9.0);
    // 0.1 of pi rad/s: joint 1 is told to go at 1 rad/s, and is behind by 2 mrad more in each step.
    controller.set_speed_fraction(0.1);
    for k in 201..=220 {
        tell(&mut controller, &goal(k));
        controller.step();
    }
    let limit = 0.1 * core::f64::consts::PI;
    assert!((controller.target_speed()[0] - limit).abs() < 1e-9, "{}", controller.target_speed());
    assert!(goal(220)[0] - controller.target()[0] > 20.0 * T * (1.0 - limit) / 2.0);
    assert_eq!(controller.output("speed_scaling"), Some(mrroc_ur::rtde::Value::Double(0.1)));
}

#[test]
fn a_set_point_that_is_ahead_is_reached_within_the_limits_and_not_overshot() {
    let mut controller = moving(0, 9.0);
    let goal = start() + Six::repeat(0.03);
    let (mut speed, most) = (Six::zeros(), 3.0 * UrModel::Ur5e.accelerations());
    for _ in 0..100 {
        tell(&mut controller, &goal);
        controller.step();
        let now = controller.target_speed();
        assert!((0..6).all(|i| (now[i] - speed[i]).abs() <= most[i] * T * (1.0 + 1e-9)), "{now}");
        assert!((0..6).all(|i| controller.target()[i] <= goal[i] + 1e-4), "{}", controller.target());
        speed = now;
    }
    assert!((controller.target() - goal).amax() < 1e-5, "{}", controller.target() - goal);
    assert_eq!(controller.dashboard("safetymode"), "Safetymode: NORMAL");
}

#[test]
fn an_emergency_stop_brakes_takes_the_power_away_and_ends_the_script() {
    let mut controller = moving(200, 9.0);
    controller.press(Press::EmergencyStop);
    controller.step();
    assert!(!controller.runs());
    assert_eq!(controller.dashboard("robotmode"), "Robotmode: RUNNING", "it brakes with power");
    let mut steps = 1;
    while controller.dashboard("robotmode") != "Robotmode: POWER_OFF" {
        controller.step();
        steps += 1;
        assert!(steps < 1000);
    }
    // 1 rad/s at pi / 0.35 rad/s².
    let expected = 0.35 / core::f64::consts::PI;
    assert!((f64::from(steps) * T - expected).abs() <= 2.0 * T, "{steps} steps");
    assert!(!controller.take_script(&Script::new("127.0.0.1:1".parse().expect("one"), 9.0).text()));
}

#[test]
fn scripts_of_others_are_counted_and_do_nothing() {
    let mut controller = moving(0, 9.0);
    assert!(!controller.take_script("def other():\n  movej([0,0,0,0,0,0])\nend\n"));
    assert_eq!(controller.unknown_scripts(), 1);
    assert!(controller.runs(), "the one that runs goes on");
}

/// The lines of UR's own script by which it is known, within the program that its client library sends.
const OF_UR: &str = "def externalControl():\n\tSTOPJ_ACCELERATION = 4.0\n\
    \tservoj(q, t=steptime, lookahead_time=0.03, gain=2000)\n\
    \tf = connect_socket_with_retry(\"127.0.0.1\", 50003, \"trajectory_socket\")\n\
    \tg = connect_socket_with_retry(\"127.0.0.1\", 50004, \"script_command_socket\")\n\
    \th = connect_socket_with_retry(\"127.0.0.1\", 50001, \"reverse_socket\")\nend\n";

#[test]
fn urs_own_script_follows_set_points_brakes_as_it_says_and_ends_without_a_word() {
    let mut controller = Controller::new(UrModel::Ur5e, &start()).expect("an arm");
    assert!(controller.take_script(OF_UR));
    let address = |port: u16| std::net::SocketAddr::new([127, 0, 0, 1].into(), port);
    assert_eq!(controller.others(), [address(50003), address(50004)]);
    assert_eq!(controller.calls(), Some(address(50001)));
    controller.connected(true);
    for k in 1..=200 {
        tell(&mut controller, &goal(k));
        controller.step();
    }
    assert!((controller.target() - goal(200)).amax() <= ROUNDED);
    // Eleven periods until it notices; then 1 rad/s at 4 rad/s².
    let mut steps = 0;
    while controller.target_speed() != Six::zeros() {
        controller.step();
        assert_eq!(controller.says(), None);
        steps += 1;
    }
    assert!((f64::from(steps - 10) * T - 1.0 / 4.0).abs() <= 1.5 * T, "{steps} steps");
    controller.step();
    assert!(!controller.runs());
}

#[test]
fn a_program_that_is_played_asks_once_for_its_script_and_takes_it_in_local_control() {
    let mut controller = Controller::new(UrModel::Ur5e, &start()).expect("an arm");
    let at = "127.0.0.1:50002".parse().expect("an address");
    controller.set_external_control(at);
    controller.press(Press::TakeOver);
    assert_eq!(controller.asks(), None);
    controller.press(Press::Play);
    assert_eq!((controller.asks(), controller.asks()), (Some(at), None));
    let script = Script::new("127.0.0.1:50001".parse().expect("an address"), 9.0);
    assert!(!controller.take_script(&script.text()), "not in remote control");
    assert!(controller.take_answer(&script.node_text()));
    assert_eq!(controller.calls(), Some(script.reverse));
}
