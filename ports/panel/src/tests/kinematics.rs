//! Where a page shows a robot: where the robot's own kinematics have it.

use mrroc_core::pose::Pose;
use mrroc_core::robot::Robot;
use mrroc_robots::{Irp6, Six};
use serde_json::{Value, json};

use super::{looks, robot_at};
use crate::now::CellMoment;

#[test]
fn a_page_is_shown_the_links_and_the_tool_where_the_robots_own_kinematics_have_them() {
    let joints = Six::new(0.3, -1.4, 0.1, -0.2, 4.6, 0.5);
    let tool = Irp6::nominal().forward(&joints) * Pose::translation(0.0, 0.0, 0.1);
    let mut robot = robot_at(joints);
    robot.tool = tool;
    let state = looks().state(&CellMoment { robots: vec![robot.clone()], ..CellMoment::default() });
    let numbers = |value: &Value| {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect::<Vec<_>>()
    };
    let shown = numbers(&state["robots"][0]["tool"]);
    let at = tool.translation.vector;
    assert!((0..3).all(|i| (shown[i] - at[i]).abs() < 1e-6), "{shown:?} {at}");
    let mut flange = Vec::new();
    Irp6::nominal().frames(&joints, &mut |frame| flange = frame.translation.vector.as_slice().to_vec());
    let last =
        numbers(state["robots"][0]["frames"].as_array().and_then(|frames| frames.last()).expect("a frame"));
    assert!((0..3).all(|i| (last[i] - flange[i]).abs() < 1e-6), "{last:?} {flange:?}");
    assert!(state["robots"][0]["links"].as_array().is_some_and(|links| links.len() > 2));
    // It is where it is demanded, to less than 2 mm: there is no ghost. Turned by 0.1 rad about its upright first axis, the flange is
    // demanded r * 2 sin(0.05) away.
    assert_eq!(state["robots"][0]["ghost"], json!([]));
    robot.demanded[0] += 0.1;
    let state = looks().state(&CellMoment { robots: vec![robot], ..CellMoment::default() });
    let end = |which: &str| {
        let links = state["robots"][0][which].as_array().expect("links");
        numbers(links.last().expect("a link"))
    };
    let (link, ghost) = (end("links"), end("ghost"));
    let apart = (link[3] - ghost[3]).hypot(link[4] - ghost[4]);
    let chord = link[3].hypot(link[4]) * 2.0 * 0.05_f64.sin();
    assert!((apart - chord).abs() < 5e-6 && (link[5] - ghost[5]).abs() < 2e-6, "{apart} {chord}");
}
