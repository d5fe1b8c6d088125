//! Draws how the simulated drives of a robot answer: of each joint, its step response and its following error.
//!
//! ```text
//! cargo run -p mrroc-examples --example response -- irp6 [--out FILE]
//! ```
//!
//! Names: those of [`KINDS`], and `urdf`: the weighted arm of the tests. The default file is `response-NAME.svg`. The
//! drives begin at rest and in equilibrium. One joint after the other is demanded to follow:
//!
//! - a step of 35 encoder pulses of its motor, to which the regulators answer with nearly full voltage;
//! - a trapezoid of the speed with half its limits of speed and acceleration, or less if its range is too short.

mod chart;

use std::process::ExitCode;

use chart::{Chart, Curve};
use mrroc::robot::{Driver, JointKind};
use mrroc_robots::{
    Conveyor, Driven, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Serial, Simulated,
};
use nalgebra::SVector;

/// The kinds of robots.
pub const KINDS: [&str; 8] =
    ["irp6", "irp6-calibrated", "irp6-5dof", "irp6-track", "rnt", "polycrank", "gripper", "conveyor"];

/// Servo period \[s\].
const PERIOD: f64 = 0.002;
/// Height of a step [encoder pulses].
const PULSES: f64 = 35.0;
/// When the step begins, and how long its response is drawn \[s\].
const STEP: (f64, f64) = (0.02, 0.8);
/// How long the trapezoid stays at its speed at most, and what is drawn after its end \[s\].
const STEADY: f64 = 0.5;
const REST: f64 = 0.3;

/// What a joint was demanded and where its shaft was, as changes since the start [rad or m].
struct Run {
    times: Vec<f64>,
    demanded: Vec<f64>,
    true_shaft: Vec<f64>,
}

/// Demands of one joint the positions `path` (of time, since the start) for `duration` \[s\].
fn run<const N: usize, R: Driven<N>>(
    robot: &R,
    start: &SVector<f64, N>,
    joint: usize,
    duration: f64,
    path: impl Fn(f64) -> f64,
) -> Result<Run, String> {
    let mut drives = Simulated::new(robot.clone(), start);
    let shaft = drives.shaft();
    let mut run = Run { times: vec![0.0], demanded: vec![0.0], true_shaft: vec![0.0] };
    for k in 1..=(duration / PERIOD).round() as u32 {
        let (time, mut demanded) = (f64::from(k) * PERIOD, *start);
        demanded[joint] += path(time);
        drives.tick(&demanded).map_err(|fault| format!("joint {}: {fault}", joint + 1))?;
        run.times.push(time);
        run.demanded.push(path(time));
        run.true_shaft.push(shaft.state().position[joint] - start[joint]);
    }
    Ok(run)
}

/// The distance by a trapezoid of the speed, `travel` long, at most `velocity` fast, with `acceleration` up and down; and its
/// duration \[s\].
fn trapezoid(travel: f64, velocity: f64, acceleration: f64) -> (f64, impl Fn(f64) -> f64) {
    let (length, sign) = (travel.abs(), travel.signum());
    let speed = velocity.min((acceleration * length).sqrt());
    let ramp = speed / acceleration;
    let duration = length / speed + ramp;
    let distance = move |t: f64| {
        if t >= duration {
            length
        } else if t < ramp {
            0.5 * acceleration * t * t
        } else if t < duration - ramp {
            speed * (t - 0.5 * ramp)
        } else {
            length - 0.5 * acceleration * (duration - t).powi(2)
        }
    };
    (duration, move |t| sign * distance(t))
}

/// The longest displacement of a joint from `start`, up to `most`, that keeps all limits; negative downwards.
fn room<const N: usize, R: Kinematics<N>>(
    robot: &R,
    start: &SVector<f64, N>,
    joint: usize,
    most: f64,
) -> f64 {
    let along = |sign: f64| {
        let at = |part: u32| sign * most * f64::from(part) / 100.0;
        let free = (1..=100).take_while(|part| {
            let mut q = *start;
            q[joint] += at(*part);
            robot.is_attainable(&q)
        });
        free.last().map_or(0.0, at)
    };
    let (up, down) = (along(1.0), along(-1.0));
    if up >= -down { up } else { down }
}

/// Both charts of a joint.
fn charts<const N: usize, R: Kinematics<N> + Driven<N>>(
    robot: &R,
    start: &SVector<f64, N>,
    joint: usize,
) -> Result<[Chart; 2], String> {
    let unit = match robot.joint(joint) {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    };
    let name = format!("q{}", joint + 1);

    // How far the joint's motor turns with it.
    let mut aside = *start;
    aside[joint] += 1e-6;
    let gear = (robot.motors(&aside) - robot.motors(start))[joint] / 1e-6;
    let height = PULSES * robot.motor_data()[joint].encoder.pulse() / gear.abs();
    let step = run(robot, start, joint, STEP.1, |t| if t > STEP.0 { height } else { 0.0 })?;
    let overshoot = step.true_shaft.iter().fold(0.0_f64, |most, q| most.max(*q)) / height - 1.0;
    let settled = step.true_shaft.iter().rposition(|q| (q - height).abs() > 0.05 * height).unwrap_or(0);
    let settled = match 1e3 * (step.times[settled] - STEP.0) {
        t if t < 1e3 * (STEP.1 - STEP.0 - PERIOD) => format!("within 5 % after {t:.0} ms"),
        _ => "not yet within 5 %".to_owned(),
    };
    let step_chart = Chart {
        title: format!("{name}: step response"),
        figures: format!("overshoot {:.0} %, {settled}", 100.0 * overshoot.max(0.0)),
        quantity: "position since the start".to_owned(),
        unit,
        curves: vec![Curve::measured(step.true_shaft), Curve::demanded(step.demanded)],
        times: step.times,
    };

    let limits = robot.limits();
    let (velocity, acceleration) = (0.5 * limits.velocity[joint], 0.5 * limits.acceleration[joint]);
    let most = velocity * (velocity / acceleration + STEADY);
    let (duration, position) = trapezoid(0.9 * room(robot, start, joint, most), velocity, acceleration);
    let moved = run(robot, start, joint, duration + REST, position)?;
    let error: Vec<f64> = moved.demanded.iter().zip(&moved.true_shaft).map(|(a, b)| a - b).collect();
    let largest = error.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
    let speeds = moved.demanded.windows(2).map(|w| ((w[1] - w[0]) / PERIOD).abs());
    let fastest = speeds.fold(0.0, f64::max);
    let error_chart = Chart {
        title: format!("{name}: following error on a trapezoid"),
        figures: format!(
            "up to {fastest:.3} {unit}/s, {:.0} ms long; largest {}",
            1e3 * duration,
            chart::with_prefix(largest, unit)
        ),
        quantity: "following error".to_owned(),
        unit,
        curves: vec![Curve::measured(error)],
        times: moved.times,
    };
    Ok([step_chart, error_chart])
}

fn page<const N: usize, R: Kinematics<N> + Driven<N>>(
    kind: &str,
    robot: &R,
    start: [f64; N],
) -> Result<String, String> {
    let start = SVector::from(start);
    let rows: Result<Vec<_>, _> = (0..N).map(|joint| charts(robot, &start, joint)).collect();
    Ok(chart::page(&format!("{kind}: simulated drives, one joint at a time"), &rows?))
}

/// The picture of a kind of robot.
///
/// # Errors
/// The kind is not known, or a drive refuses its demand.
pub fn picture(kind: &str) -> Result<String, String> {
    const ARM: [f64; 6] = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0];
    match kind {
        "irp6" => page(kind, &Irp6::nominal(), ARM),
        "irp6-calibrated" => page(kind, &Irp6::calibrated(), ARM),
        "irp6-5dof" => page(kind, &Irp6FiveDof::nominal(), [0.0, -1.57, 0.16, 0.6, 1.0]),
        "irp6-track" => page(kind, &Irp6Track::nominal(), [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0]),
        "rnt" => page(kind, &Rnt::new(), [0.0, 0.5, 0.55, 0.0, 1.3, 0.0]),
        "polycrank" => page(kind, &Polycrank::new(), [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]),
        "gripper" => page(kind, &Gripper::new(), [0.07]),
        "conveyor" => page(kind, &Conveyor::new(), [0.0]),
        "urdf" => {
            let text = include_str!("../../tests/reference/urdf/weighted_arm.urdf");
            let robot = Serial::<6>::from_urdf(text, "base_link", "tool0")
                .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
                .map_err(|why| why.to_string())?;
            page(kind, &robot, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
        }
        name => Err(format!("no robot is called {name}; there are {}, urdf", KINDS.join(", "))),
    }
}

fn write(mut arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let usage = || format!("usage: response {}|urdf [--out FILE]", KINDS.join("|"));
    let kind = arguments.next().ok_or_else(usage)?;
    let out = match (arguments.next().as_deref(), arguments.next(), arguments.next()) {
        (None, ..) => format!("response-{kind}.svg"),
        (Some("--out"), Some(out), None) => out,
        _ => return Err(usage()),
    };
    let picture = picture(&kind)?;
    mrroc_launch::files::check_outputs([std::path::Path::new(&out)]).map_err(|why| why.to_string())?;
    std::fs::write(&out, picture).map_err(|why| format!("cannot write {out}: {why}"))?;
    Ok(out)
}

fn main() -> ExitCode {
    match write(std::env::args().skip(1)) {
        Ok(out) => {
            println!("{out}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
