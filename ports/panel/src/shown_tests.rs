//! What a page is shown of readings, signals, tools and bodies: of a cell that runs, and of a run that is over.

use core::time::Duration;

use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_core::nalgebra::Vector3;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::StepRecord;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::Wire;
use mrroc_core::robot::{Load, Signals, Tool, Values};
use mrroc_processes::{BodyPicture, CarriedPicture, Picture, ReadingPicture, RobotPicture};
use mrroc_robots::sensors::{WristForce, WristOrder};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use serde_json::json;

use crate::console_session::now;
use crate::now::Appearance;
use crate::run_history::RunHistory;

const START: Six = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);

/// A sensor that reads nothing.
struct Wrist;

impl VirtualSensor for Wrist {
    type Kind = WristForce;
    fn aggregate(&mut self, _: &ReadingOrder<WristOrder>) -> Result<Wrench, Fault> {
        Ok(Wrench::default())
    }
}

/// A cell with an arm, a sensor at its wrist, a tool with a name, and two bodies.
fn layout() -> Layout {
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &START));
    Cell::new(Duration::from_millis(2))
        .robot(arm)
        .sensor(SensorSetup::new("wrist", Wrist).of("arm"))
        .tool("drill", Tool { frame: Pose::translation(0.0, 0.0, 0.1), load: Load::NONE })
        .shows_body("bar", [0.1; 3], Pose::identity)
        .shows_body("table", [1.0; 3], Pose::identity)
        .layout()
}

fn words() -> Vec<u64> {
    let mut words = vec![0; Wrench::LEN];
    Wrench::new(Vector3::new(1.0, 2.0, -3.0), Vector3::new(0.1, 0.2, 0.3)).put(&mut words);
    words
}

fn picture(step: u64) -> Picture {
    let joints = START.as_slice().to_vec();
    let robot = RobotPicture {
        name: "arm".to_owned(),
        time: 1.0,
        demanded: joints.clone(),
        measured: joints,
        tool: mrroc::robot::Robot::forward(&Irp6::nominal(), &START),
        doing: mrroc_core::operator::state::InstructionKind::Nothing,
        by: String::new(),
        jogs: false,
        stop: mrroc_core::operator::jog::JogStop::None,
    };
    let carried = CarriedPicture {
        robot: "arm".to_owned(),
        tool: Pose::translation(0.0, 0.0, 0.1),
        load: Some(Load::point(1.25, Vector3::new(0.0, 0.0, 0.05))),
        signals: Signals { inputs: Values::OFF, outputs: Values::OFF },
    };
    Picture {
        step,
        period: 2_000_000,
        robots: vec![robot],
        carried: vec![carried],
        readings: vec![ReadingPicture { sensor: "wrist".to_owned(), step: 1000, words: Some(words()) }],
        bodies: vec![BodyPicture { place: 1, pose: Pose::translation(0.5, 0.0, 0.0) }],
        ..Picture::default()
    }
}

#[test]
fn a_page_is_shown_the_reading_the_tool_by_its_name_the_payload_and_the_bodies_that_are_known() {
    let looks = Appearance::of(&layout());
    let shown = looks.state(&now(picture(1010), &looks));
    assert_eq!(shown["readings"], json!([[1.0, 2.0, -3.0, 0.1, 0.2, 0.3]]));
    let carried = &shown["robots"][0]["carried"];
    assert_eq!((&carried["name"], &carried["mass"]), (&json!("drill"), &json!(1.25)));
    assert_eq!(shown["bodies"], json!([null, [0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]));
    let said = looks.layout(None);
    assert_eq!(said["sensors"][0]["wrench"], json!(true));
    assert_eq!(said["sensors"][0]["of"], json!("arm"));
    // A place that the layout does not have, and a sensor that it does not know, are passed over.
    let mut strange = picture(1010);
    strange.bodies[0].place = 7;
    strange.readings[0].sensor = "other".to_owned();
    let shown = looks.state(&now(strange, &looks));
    assert_eq!((&shown["bodies"], &shown["readings"]), (&json!([null, null]), &json!([null])));
}

#[test]
fn fault_241_a_reading_that_is_old_or_a_fault_is_not_shown_of_a_cell_that_runs() {
    let looks = Appearance::of(&layout());
    let readings = |picture| looks.state(&now(picture, &looks))["readings"].clone();
    // A step has 2 ms: a second are 500 of them.
    assert!(readings(picture(1500))[0].is_array());
    assert_eq!(readings(picture(1501)), json!([null]));
    let mut fault = picture(1000);
    fault.readings[0].words = None;
    assert_eq!(readings(fault), json!([null]));
}

/// Lets a run go on to a step, of 20 ms.
fn pass(history: &mut RunHistory, step: u64, resetting: bool) {
    let (time, tool, six) = (20_000_000 * step, Pose::identity(), START.as_slice());
    history.robot(time, "arm", [six, six], [tool, tool]);
    history.step(time, &StepRecord { step, dt: 0.02, duration: 0.02, resetting, ..StepRecord::default() });
}

#[test]
fn fault_241_a_reading_that_is_old_or_a_fault_is_not_shown_by_a_run_that_is_over() {
    const MS: u64 = 1_000_000;
    let layout = layout();
    let mut history = RunHistory::of(&layout);
    for k in 0..200 {
        let time = 20 * MS * k;
        match k {
            10 => history.reading(time, 0, Some(vec![Some(1.5)])),
            100 => history.reading(time, 0, Some(vec![Some(2.5)])),
            110 => history.reading(time, 0, None),
            _ => {}
        }
        pass(&mut history, k, false);
    }
    let at = |time: f64| history.at(time).expect("seen").readings[0].as_ref().and_then(|numbers| numbers[0]);
    assert_eq!([at(0.1), at(0.25), at(1.19)], [None, Some(1.5), Some(1.5)]);
    // It was collected at 0.2 s.
    assert_eq!([at(1.23), at(2.1), at(2.3)], [None, Some(2.5), None]);
}

#[test]
fn the_minute_before_a_moment_of_a_run_is_some_hundred_moments_none_of_them_later() {
    let mut history = RunHistory::of(&layout());
    for step in 0..6000 {
        pass(&mut history, step, false);
    }
    let minute = |time: f64| history.minute(time).map(|now| now.time).collect::<Vec<_>>();
    let late = minute(100.0);
    assert!((150..=300).contains(&late.len()), "{}", late.len());
    assert!((late[0] - 40.0).abs() < 0.03 && late.is_sorted_by(|a, b| a < b), "{late:?}");
    assert!((99.0..100.0).contains(&late[late.len() - 1]), "{late:?}");
    // Before a minute is over there is less, and nothing before its begin.
    assert!(minute(0.0).is_empty());
    let early = minute(1.0);
    assert!(early[0] < 0.03 && (40..=50).contains(&early.len()), "{early:?}");
}

#[test]
fn the_instructions_of_a_run_are_counted_from_its_last_reset() {
    let mut history = RunHistory::of(&layout());
    let mut counted = Vec::new();
    for step in 0..6 {
        pass(&mut history, 2 * step, step == 3);
        history.instruction("mp", InstructionKind::Move, "JointMove");
        pass(&mut history, 2 * step + 1, false);
        counted.push(history.at(0.02 * (2 * step + 1) as f64).expect("seen").instruction);
    }
    assert_eq!(counted, [1, 2, 3, 1, 2, 3]);
}
