//! What goes wrong with a base is told, and its wheels stop.

use core::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_generators::rehearsal::rehearse_with;
use mrroc_map::{Goal, Knowledge, Layout, Walls};
use mrroc_wheels::generators::BaseLimits;
use mrroc_wheels::sensing::infrared::SENSORS;
use mrroc_wheels::sensing::{
    DeadReckoning, Gyro, GyroFault, Infrared, Located, LookingOut, Lookout, Sight, WallMemory, Watch,
};
use mrroc_wheels::simulation::{Floor, Ground};
use mrroc_wheels::{DiffDrive, FollowPath, Path, Planar, Rolling, Two};
use nalgebra::Vector2;

/// A hall of ten cells by ten, whose goal is all but the lowest row: no posts stand in it.
fn hall() -> Walls {
    let goal = Goal { lower: (0, 1), upper: (9, 9) };
    Walls::of(&Layout::open(10, 10, (0, 0), goal), 0.18, 0.012)
}

/// What happens to the base on its path.
type Event = Box<dyn FnMut(f64, &Floor, &mut LookingOut)>;

/// The sensor, and what happens.
struct Eventful {
    inner: LookingOut,
    floor: Floor,
    event: Event,
}

impl VirtualSensor for Eventful {
    type Kind = Lookout;

    fn aggregate(&mut self, order: &ReadingOrder<Watch>) -> Result<Sight, Fault> {
        (self.event)(self.floor.time(), &self.floor, &mut self.inner);
        self.inner.aggregate(order)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

#[condition(ecp)]
fn stands(v: &Reading<(Lookout,)>) -> bool {
    v.0.reading().is_some_and(|read| read.stands)
}

/// A base in the hall that goes these paths: what ended it, and its floor.
fn ended(paths: Vec<Path>, event: Event) -> (Option<Fault>, Floor) {
    let start = paths[0].at(0.0).pose;
    let floor = Floor::new(Ground { walls: Some(hall()), ..Ground::default() }, start);
    let located = Located::by(Gyro::new(floor.clone(), 1), DeadReckoning::from(start));
    let told =
        Knowledge { size: [1.8, 1.8], radius: DiffDrive::BODY, thickness: 0.012, passage: 0.15, wall: 0.18 };
    let memory = WallMemory::of_frame(told, SENSORS);
    let inner = LookingOut::new(floor.clone(), located, Infrared::new(floor.clone(), 1), memory);
    let sensor = SensorSetup::new("lookout", Eventful { inner, floor: floor.clone(), event }).of("base");
    let drives = Rolling::new(DiffDrive::new(), floor.clone());
    let robot = RobotSetup::new("base", DiffDrive::new(), drives).program(move |ecp| {
        let mut lookout = ecp.sensor::<Lookout>("lookout")?;
        ecp.wait_until((&mut lookout,), stands {})?;
        for path in &paths {
            let limits = BaseLimits { speed: 0.3, lateral: 1.5, turning: 6.0, off: 0.05 };
            let follow = FollowPath::<Lookout>::along(path.clone(), limits, |read| Some(read.pose), 2.0, 2);
            ecp.move_robot((&mut lookout,), follow)?;
        }
        Ok(())
    });
    let report = Cell::new(Duration::from_millis(2))
        .stop_time(Duration::from_millis(250))
        .robot(robot)
        .sensor(sensor)
        .run();
    let fault = match report {
        Ok(_) => None,
        Err(CellError::Fault(first)) => Some(first),
        Err(other) => panic!("{other}"),
    };
    (fault, floor)
}

/// From the middle of the hall to its right side and through it.
fn into_the_wall() -> Vec<Path> {
    vec![Path::through(&[Vector2::new(0.9, 0.9), Vector2::new(1.9, 0.9)], 0.01).expect("a path")]
}

/// A quarter turn in the middle of the hall, after a piece straight on.
fn there_and_round() -> Vec<Path> {
    let straight = Path::through(&[Vector2::new(0.6, 0.9), Vector2::new(0.9, 0.9)], 0.01).expect("a path");
    vec![straight, Path::turn(Planar { x: 0.9, y: 0.9, heading: 0.0 }, 1.5)]
}

/// The cell ends as soon as its wheels are demanded to stand. The body, which lags behind them and rocks against a wall, is then slower than
/// a tenth of how it went: 0.3 m/s, or turning at 3 rad/s.
fn is_at_rest(floor: &Floor) -> bool {
    let motion = floor.motion();
    motion.ahead.abs() < 0.03 && motion.turning.abs() < 0.3
}

#[test]
fn nothing_is_told_of_a_base_that_nothing_happens_to() {
    let (fault, floor) = ended(there_and_round(), Box::new(|_, _, _| {}));
    assert_eq!(fault, None);
    assert!((floor.motion().pose.heading - 1.5).abs() < 0.02, "{:?}", floor.motion());
}

#[test]
fn fault_178_a_wall_that_is_touched_stops_the_wheels_with_a_named_fault() {
    // All sensors are blind, so that nothing but the bumper tells of the wall.
    let (fault, floor) = ended(
        into_the_wall(),
        Box::new(|_, _, looking| (0..SENSORS).for_each(|sensor| looking.infrared_mut().blind(sensor))),
    );
    let fault = fault.expect("the wall is touched");
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    assert!(fault.to_string().contains("bumper"), "{fault}");
    assert!(is_at_rest(&floor), "{:?}", floor.motion());
    assert!(floor.touched().times >= 1);
    // It stood in front of the wall, which yielded by no more than its stiffness allows at 0.3 m/s.
    assert!(floor.motion().pose.x < 1.794 - DiffDrive::BODY + 2e-3, "{:?}", floor.motion());
}

#[test]
fn fault_179_a_gyro_that_does_not_answer_is_told_at_once() {
    let silent = |time: f64, _: &Floor, looking: &mut LookingOut| {
        if time > 0.5 {
            looking.located_mut().gyro_mut().fail(GyroFault::Silent);
        }
    };
    let (fault, floor) = ended(there_and_round(), Box::new(silent));
    let fault = fault.expect("it is told");
    assert!(
        fault.kind() == FaultKind::SensorFailed && fault.to_string().contains("gyro does not answer"),
        "{fault}"
    );
    assert!(is_at_rest(&floor), "{:?}", floor.motion());
}

#[test]
fn fault_179_a_gyro_that_says_nothing_of_a_turn_is_told_before_the_heading_is_off_by_more_than_it_may() {
    let dead =
        |_: f64, _: &Floor, looking: &mut LookingOut| looking.located_mut().gyro_mut().fail(GyroFault::Dead);
    let (fault, floor) = ended(there_and_round(), Box::new(dead));
    let fault = fault.expect("it is told");
    assert!(fault.kind() == FaultKind::SensorFailed && fault.to_string().contains("disagree"), "{fault}");
    assert!(is_at_rest(&floor), "{:?}", floor.motion());
    // It is told when the turn is a little more than what both may differ by, and then it stops.
    assert!(floor.motion().pose.heading < 2.5 * DeadReckoning::MOST, "{:?}", floor.motion());
}

#[test]
fn fault_187_wheels_that_slip_more_in_a_turn_than_odometry_can_bear_are_told() {
    // Oil where it is to turn.
    let oil = |time: f64, floor: &Floor, _: &mut LookingOut| {
        if time > 1.0 && floor.motion().ahead.abs() < 0.01 {
            floor.change(|ground| ground.friction = 0.01);
        }
    };
    let (fault, floor) = ended(there_and_round(), Box::new(oil));
    let fault = fault.expect("it is told");
    assert!(fault.kind() == FaultKind::SensorFailed && fault.to_string().contains("disagree"), "{fault}");
    assert!(floor.motion().pose.heading.abs() < 1.3, "the turn was not finished: {:?}", floor.motion());
}

#[test]
fn fault_237_a_path_is_not_followed_by_a_place_that_is_older_than_it_may_be() {
    let path = || Path::through(&[Vector2::zeros(), Vector2::new(0.3, 0.0)], 0.01).expect("a path");
    let limits = BaseLimits { speed: 0.3, lateral: 1.5, turning: 6.0, off: 0.05 };
    // What the sensor told first gets older by a step in every step after the fifth.
    let followed = |oldest: u32| {
        let follow = FollowPath::<Lookout>::along(path(), limits, |read| Some(read.pose), 2.0, oldest);
        let (mut base, mut before, mut step) = (Planar::default(), Two::zeros(), 0_u32);
        rehearse_with(follow, &DiffDrive::new(), Two::zeros(), 0.004, |image| {
            let q = image.demanded().joints;
            let (distance, turn) = DiffDrive::rolled(&(q - core::mem::replace(&mut before, q)));
            base = base.moved(distance, turn);
            step += 1;
            let sight = Sight { pose: base, ..Sight::default() };
            (Order::new(()), Reading::new((SensorImage::new(sight, step.saturating_sub(5)),)))
        })
        .map(drop)
        .map_err(|fault| (fault.kind(), step))
    };
    assert_eq!(followed(2), Err((FaultKind::SensorStale, 8)));
    assert_eq!(followed(u32::MAX), Ok(()));
}

#[test]
fn a_path_that_is_over_before_its_end_is_braked_on() {
    let path = Path::through(&[Vector2::zeros(), Vector2::new(0.3, 0.0)], 0.01).expect("a path");
    let limits = BaseLimits { speed: 0.3, lateral: 1.5, turning: 6.0, off: 0.05 };
    let follow = FollowPath::<Lookout>::along(path, limits, |read| Some(read.pose), 2.0, 2)
        .until(|read| read.is_blocked);
    let (mut base, mut before) = (Planar::default(), Two::zeros());
    rehearse_with(follow, &DiffDrive::new(), Two::zeros(), 0.004, |image| {
        let q = image.demanded().joints;
        let (distance, turn) = DiffDrive::rolled(&(q - core::mem::replace(&mut before, q)));
        base = base.moved(distance, turn);
        let sight = Sight { pose: base, is_blocked: base.x > 0.1, ..Sight::default() };
        (Order::new(()), Reading::new((SensorImage::new(sight, 0),)))
    })
    .expect("no fault");
    assert!(base.x > 0.1 && base.x < 0.11, "{base:?}");
}
