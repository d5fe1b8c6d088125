//! What the numbered examples do.

use std::error::Error;

use mrroc::generator::{Condition, RobotList};
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_generators::conditions::{ConditionExt, all, any, elapsed, elapsed_since, not};
use nalgebra::Vector3;

use super::sheet::{Chart, Paths, Sheet, Trace};
use crate::usage::examples::{
    belt_in_the_background, conditions, force, jerk_limited_plan, spline_through_points, two_arms_carry,
    via_points,
};

/// Every second servo period: enough for a picture.
const EVERY: usize = 2;

/// Without the standstill before and after a motion.
fn moving(mut path: Trace) -> Trace {
    let still = |pair: &[Vector3<f64>]| (pair[1] - pair[0]).norm() < 1e-9;
    let before = path.windows(2).take_while(|pair| still(pair)).count();
    path.drain(..before);
    let behind = path.windows(2).rev().take_while(|pair| still(pair)).count();
    path.truncate(path.len() - behind);
    path
}

fn thinned(path: &[Vector3<f64>]) -> Trace {
    path.iter().step_by(EVERY).copied().collect()
}

/// Three joints, with their limits.
fn plan() -> Result<Sheet, Box<dyn Error>> {
    const DT: f64 = 4e-3;
    let motion = jerk_limited_plan::plan(0.0)?;
    let steps = (motion.duration() / DT).ceil() as usize;
    let points: Vec<_> = (0..=steps).map(|i| motion.at(i as f64 * DT)).collect();
    let chart = |heading: &str, values: Trace, limit: Option<f64>| Chart {
        heading: heading.to_owned(),
        values: vec![values],
        rounding: 1e-9,
        lines: limit.into_iter().flat_map(|limit| [limit, -limit]).collect(),
    };
    let position: Trace = points.iter().map(|point| point.position).collect();
    Ok(Sheet {
        title: "A jerk-limited plan of three joints".to_owned(),
        axes: vec!["1", "2", "3"],
        dashed: "joint; dotted: its limits",
        duration: motion.duration(),
        charts: vec![
            chart("position [rad]", position.clone(), None),
            chart(
                "velocity [rad/s]",
                points.iter().map(|point| point.velocity).collect(),
                Some(jerk_limited_plan::VELOCITY),
            ),
            chart(
                "acceleration [rad/s²]",
                points.iter().map(|point| point.acceleration).collect(),
                Some(jerk_limited_plan::ACCELERATION),
            ),
            chart(
                "jerk [rad/s³]",
                points.iter().map(|point| point.jerk).collect(),
                Some(jerk_limited_plan::JERK),
            ),
        ],
        paths: Some(Paths {
            traces: vec![position],
            axes: ["joint 1", "joint 2", "joint 3"],
            unit: "rad",
            ..Paths::default()
        }),
    })
}

/// The path of one tool past points.
fn past(title: &str, path: Trace, marks: &[Vector3<f64>], period: f64) -> Sheet {
    let path = thinned(&moving(path));
    let mut sheet = Sheet::of_tools(title, &[path], EVERY as f64 * period);
    if let Some(paths) = &mut sheet.paths {
        paths.marks = marks.to_vec();
        paths.legend = "; circles: the poses to pass";
    }
    sheet
}

/// Two tools and the body between them, from above and from the side.
fn carry() -> Result<Sheet, Box<dyn Error>> {
    let tools = two_arms_carry::tools()?;
    let [left, right] = tools.map(|tool| tool.iter().map(|pose| pose.translation.vector).collect::<Trace>());
    let length = moving(left.clone()).len();
    let begin = left.windows(2).take_while(|pair| (pair[1] - pair[0]).norm() < 1e-9).count();
    let part = |tool: &Trace| thinned(&tool[begin..begin + length]);
    let both = [part(&left), part(&right)];
    let mut sheet = Sheet::of_tools("Two arms carry one body", &both, EVERY as f64 * two_arms_carry::PERIOD);
    let middle = (both[0][0] + both[1][0]) * 0.5;
    let traces = both.map(|trace| trace.iter().map(|p| p - middle).collect::<Trace>());
    let last = traces[0].len() - 1;
    let bars = [0, last / 2, last].map(|i| [traces[0][i], traces[1][i]]).to_vec();
    if let Some(paths) = &mut sheet.paths {
        paths.traces = traces.to_vec();
        paths.bars = bars;
        paths.legend = "; grey: the body";
    }
    Ok(sheet)
}

/// The distance down to the table, and the force on it.
fn press() -> Result<Sheet, Box<dyn Error>> {
    let depths = force::depths()?;
    let depths_drawn: Trace =
        depths.iter().step_by(EVERY).map(|depth| Vector3::new(*depth, 0.0, 0.0)).collect();
    let forces =
        depths_drawn.iter().map(|depth| Vector3::x() * force::STIFFNESS * (depth.x - force::GAP).max(0.0));
    let forces: Trace = forces.collect();
    let duration = EVERY as f64 * force::PERIOD * (depths_drawn.len() - 1) as f64;
    let chart = |heading: &str, values: Trace, line: f64| Chart {
        heading: heading.to_owned(),
        values: vec![values],
        rounding: 1e-9,
        lines: vec![line],
    };
    let charts = vec![
        chart("distance down [m]; dotted: the surface of the table", depths_drawn, force::GAP),
        chart("force on the table [N]; dotted: what is asked for", forces, force::LOAD),
    ];
    let title = "A tool finds a table and presses on it".to_owned();
    Ok(Sheet { title, axes: vec![""], dashed: "", charts, paths: None, duration })
}

/// In which steps conditions hold, one below the other.
fn logic() -> Result<Sheet, Box<dyn Error>> {
    use conditions::{door_open, seated};
    const STEPS: usize = 500;
    const DT: f64 = 2e-3;
    fn chart<C>(heading: &str, mut condition: C) -> Result<Chart, Fault>
    where
        C: Condition<Sensors = (conditions::Fixture,), Order = ()>,
    {
        let mut fixture = conditions::Simulated(0);
        let mut values = Trace::new();
        for step in 0..STEPS {
            let inputs =
                fixture.aggregate(&ReadingOrder { configuration: (), robot: None, step: step as u64 })?;
            let v = Reading::new((SensorImage::new(inputs, 0),));
            let t = Tick { step: step as u64, dt: DT, duration: DT };
            let e = State::new(<C::Robots as RobotList>::unknown());
            let met = condition.is_met(&Order::new(()), &e, &v, t)?;
            values.push(Vector3::x() * f64::from(u8::from(met)));
        }
        Ok(Chart { heading: heading.to_owned(), values: vec![values], rounding: 1e-9, lines: Vec::new() })
    }
    let ready = || all((seated {}.held_for(0.1), not(door_open {})));
    let charts = vec![
        chart("seated {}: the switch bounces", seated {})?,
        chart("seated {}.held_for(0.1)", seated {}.held_for(0.1))?,
        chart("elapsed_since(seated {}, 0.3)", elapsed_since(seated {}, 0.3))?,
        chart("not(door_open {})", not(door_open {}))?,
        chart("all((seated {}.held_for(0.1), not(door_open {})))", ready())?,
        chart("any((all(..), elapsed(0.8)))", any((ready(), elapsed(0.8))))?,
    ];
    let duration = DT * (STEPS - 1) as f64;
    let title = "When conditions hold".to_owned();
    Ok(Sheet { title, axes: vec![""], dashed: "1: holds, 0: does not", charts, paths: None, duration })
}

/// The velocities of a belt, and of the first joint of an arm beside it.
fn background() -> Result<Sheet, Box<dyn Error>> {
    const PERIOD: f64 = belt_in_the_background::PERIOD;
    let positions = belt_in_the_background::positions()?;
    let steps = positions.iter().map(Vec::len).min().unwrap_or(0);
    let chart = |heading: &str, positions: &[f64]| {
        let speeds = positions[..steps].windows(2).map(|pair| (pair[1] - pair[0]) / PERIOD);
        let values = speeds.step_by(EVERY).map(|speed| Vector3::x() * speed).collect();
        Chart { heading: heading.to_owned(), values: vec![values], rounding: 1e-9, lines: Vec::new() }
    };
    let position = |heading: &str, positions: &[f64]| {
        let values =
            positions[..steps].iter().step_by(EVERY).map(|position| Vector3::x() * *position).collect();
        Chart { heading: heading.to_owned(), values: vec![values], rounding: 1e-9, lines: Vec::new() }
    };
    let charts = vec![
        position("position of the belt [m]", &positions[0]),
        position("the arm's first joint [rad]", &positions[1]),
        chart("velocity of the belt [m/s]", &positions[0]),
        chart("velocity of the arm's first joint [rad/s]", &positions[1]),
    ];
    let duration = PERIOD * (steps.saturating_sub(2)) as f64;
    let title = "A belt runs in the background".to_owned();
    Ok(Sheet { title, axes: vec![""], dashed: "", charts, paths: None, duration })
}

/// A name and a sheet for every example.
pub fn pictures() -> Result<Vec<(&'static str, Sheet)>, Box<dyn Error>> {
    let spline = past(
        "A spline through four poses",
        spline_through_points::path()?,
        &spline_through_points::POINTS,
        spline_through_points::PERIOD,
    );
    let via =
        past("Straight lines past via poses", via_points::path()?, &via_points::CORNERS, via_points::PERIOD);
    Ok(vec![
        ("01_jerk_limited_plan", plan()?),
        ("02_spline_through_points", spline),
        ("03_via_points", via),
        ("04_two_arms_carry", carry()?),
        ("05_force", press()?),
        ("06_conditions", logic()?),
        ("07_belt_in_the_background", background()?),
    ])
}
