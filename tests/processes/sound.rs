//! What holds of every launch in real time, also of one that its machine was late for.
//!
//! In: the file of its outcome, the records of its demands and of its drives. Out: how it ended; or a failed assertion. A cell whose
//! machine is late stops for it, with a fault that says so; no demand beyond a limit belongs to that.

use std::time::Duration;

use mrroc::robot::Robot;
use mrroc::testing::first_beyond_limits;
use mrroc_robots::Irp6;
use serde_json::Value;

use crate::launch::{Launch, Period, Process, demanded, periods_at_rest};
use crate::runs::ROBOTS;

/// How a launch in real time ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Its programs ended well.
    Well,
    /// It was stopped for what the test did to it.
    Stopped,
    /// It was stopped because its machine was late.
    Late,
}

/// What a late machine makes of a cell, and nothing else: messages that do not come in time, steps that are left out.
const LATE: [&str; 2] = ["PeerLost", "Overrun"];

/// The kind of the fault that a launch ended with, and its text.
fn fault(outcome: &Value) -> Option<(&str, &str)> {
    Some((outcome["fault"]["kind"].as_str()?, outcome["fault"]["text"].as_str()?))
}

/// Asserts that a launch that has ended kept all that it must keep, and ended well, as `is_expected` says of the kind and the text of
/// its fault, or because its machine was late; says which. Robots of [`ROBOTS`] stand, but for what was `killed`.
pub fn assert_sound(
    launch: &Launch,
    status: Option<i32>,
    killed: Option<&Process>,
    is_expected: impl Fn(&str, &str) -> bool,
) -> Ended {
    let (outcome, said) = (launch.outcome(), launch.said());
    let ended = match (status, fault(&outcome)) {
        (Some(0), None) => Ended::Well,
        (Some(1), Some((kind, text))) if is_expected(kind, text) => Ended::Stopped,
        (Some(1), Some((kind, _))) if LATE.contains(&kind) => Ended::Late,
        (_, fault) => panic!("status {status:?}, {fault:?}: {outcome}: {said}"),
    };
    assert_robots_stand(launch, killed);
    ROBOTS.iter().for_each(|robot| assert_within_limits(launch, robot));
    ended
}

/// Nothing but its end and a late machine is expected.
pub fn nothing(_: &str, _: &str) -> bool {
    false
}

/// A robot stands when its EDP ends; and its drives stand when the plant ends, whatever was killed. A robot whose EDP
/// was killed gets no further demands, and without the plant there is no robot.
pub fn assert_robots_stand(launch: &Launch, killed: Option<&Process>) {
    let is_killed = |role: &str| killed.is_some_and(|killed| killed.role == role);
    if is_killed("plant") {
        return;
    }
    for robot in ROBOTS {
        let record = launch.record(robot);
        assert!(
            is_killed(&format!("edp {robot}")) || rests(launch, robot),
            "{robot}, {killed:?}: {:?}: {}",
            &record[record.len().saturating_sub(8)..],
            launch.said()
        );
        let drives = launch.drives(robot);
        let stands = |last: &Period| last.stands() || last.switched_off;
        assert!(drives.last().is_none_or(stands), "{robot}: {:?}", drives.last());
    }
}

/// Whether a robot's demands do not change, or its drives have no power: they were switched off by their EDP, or their
/// brakes were applied because demands were missing. If the machine stood still, a robot may have had only one period:
/// it has not been demanded to move.
pub fn rests(launch: &Launch, robot: &str) -> bool {
    let record = launch.record(robot);
    periods_at_rest(&record) >= record.len().min(2)
        || launch.drives(robot).last().is_some_and(|last| !last.powered)
}

/// A period of the drives of [`ROBOTS`].
const PERIOD: Duration = Duration::from_millis(2);

/// Asserts that what an IRp-6 was demanded keeps its limits of position, velocity and acceleration, in all that its EDP carried out.
pub fn assert_within_limits(launch: &Launch, robot: &str) {
    let (arm, rows) = (Irp6::nominal(), rows(launch, robot));
    let demands = rows.iter().map(|(end, demanded)| (*end, demanded.as_slice()));
    assert_eq!(first_beyond_limits(robot, arm.limits(), PERIOD, demands), None, "{}", launch.said());
}

/// Asserts that an IRp-6 that was moving was demanded to stand at last, whoever kept its EDP from demanding more: its last change is one
/// after which a period within its limits of acceleration is left to none.
pub fn assert_comes_to_rest(launch: &Launch, robot: &str) {
    let (arm, rows) = (Irp6::nominal(), rows(launch, robot));
    let [.., (_, before), (_, last)] = &rows[..] else { panic!("{robot} has not moved") };
    assert!(rows.iter().any(|(_, row)| row != last), "{robot} has not moved");
    for (joint, (a, b)) in before.iter().zip(last).enumerate() {
        let most = arm.limits().acceleration[joint] * PERIOD.as_secs_f64().powi(2);
        assert!(
            (b - a).abs() <= most,
            "{robot} joint {}: {} of {most} rad: {}",
            joint + 1,
            b - a,
            launch.said()
        );
    }
}

/// The lines of a robot's record: the end of the servo period \[ns\] and the joints \[rad\] of each.
fn rows(launch: &Launch, robot: &str) -> Vec<(u64, Vec<f64>)> {
    launch.record(robot).iter().map(|line| read(line)).collect()
}

fn read(line: &str) -> (u64, Vec<f64>) {
    let seconds: f64 = line.split(' ').next().and_then(|time| time.parse().ok()).expect("a time");
    let bits = demanded(line).split(' ').map(|bits| u64::from_str_radix(bits, 16).expect("bits"));
    ((seconds * 1e9).round() as u64, bits.map(f64::from_bits).collect())
}
