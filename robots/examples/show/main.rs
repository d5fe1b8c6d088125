//! Draws a robot in a pose, its links' frames and a slice of its workspace, from the side and from above.
//!
//! ```text
//! cargo run -p mrroc-examples --example show -- irp6 [--out FILE] [--joints q1,q2,..]
//! ```
//!
//! Names: those of [`KINDS`]. Joints in rad and m. The default file is `NAME.svg`.

mod drawing;

use std::process::ExitCode;

use drawing::{Line, Scene};
use mrroc::pose::Pose;
use mrroc_robots::{
    Conveyor, Five, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, One, Polycrank, Rnt, Seven, Six,
};
use nalgebra::{SVector, Vector3};

/// The kinds of robots.
pub const KINDS: [&str; 8] =
    ["irp6", "irp6-calibrated", "irp6-5dof", "irp6-track", "rnt", "polycrank", "gripper", "conveyor"];

fn usage() -> String {
    format!("usage: show {} [--out FILE] [--joints q1,q2,..]", KINDS.join("|"))
}

/// The options of the command line.
struct Request {
    name: String,
    out: String,
    joints: Option<Vec<f64>>,
}

fn request(mut arguments: impl Iterator<Item = String>) -> Result<Request, String> {
    let name = arguments.next().ok_or_else(usage)?;
    let mut request = Request { out: format!("{name}.svg"), name, joints: None };
    while let Some(option) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{option} needs a value\n{}", usage()))?;
        match option.as_str() {
            "--out" => request.out = value,
            "--joints" => {
                let numbers: Result<_, _> = value.split(',').map(str::parse).collect();
                request.joints = Some(numbers.map_err(|why| format!("--joints {value}: {why}"))?);
            }
            _ => return Err(format!("unknown option {option}\n{}", usage())),
        }
    }
    Ok(request)
}

/// The joints asked for, or `usual`.
fn joints<const N: usize>(request: &Request, usual: SVector<f64, N>) -> Result<SVector<f64, N>, String> {
    let Some(numbers) = &request.joints else { return Ok(usual) };
    if numbers.len() != N || numbers.iter().any(|q| !q.is_finite()) {
        return Err(format!("{} has {N} joints, finite numbers", request.name));
    }
    Ok(SVector::from_column_slice(numbers))
}

/// Draws a robot at `q`: `body` makes the lines of its links from their origins.
fn draw<const N: usize, R: Kinematics<N>>(
    robot: &R,
    q: SVector<f64, N>,
    body: impl Fn(&[Pose]) -> Vec<Line>,
) -> String {
    let mut poses = Vec::new();
    robot.frames(&q, &mut |frame| poses.push(*frame));
    let numbers: Vec<String> = q.iter().map(|q| format!("{q:.3}")).collect();
    let attainable = if robot.is_attainable(&q) { "attainable" } else { "beyond a limit" };
    let title = format!("{} at q = ({}) [rad, m], {attainable}", R::KIND, numbers.join(", "));
    let measures = format!(
        "manipulability {:.4}, distance to singularity {:.3}",
        robot.manipulability(&q),
        robot.singularity_distance(&q)
    );
    let scene =
        Scene { title, measures, lines: body(&poses), frames: poses, size: drawing::size(robot.reach()) };
    scene.svg(&drawing::flange_positions(robot))
}

/// Straight links from frame to frame.
fn chained(frames: &[Pose]) -> Vec<Line> {
    let at = |i: usize| frames[i].translation.vector;
    (1..frames.len()).map(|i| Line::link(at(i - 1), at(i))).collect()
}

/// Down each axis by d, then out by a: the links of Denavit and Hartenberg.
fn cranked(frames: &[Pose]) -> Vec<Line> {
    let mut lines = Vec::new();
    for pair in frames.windows(2) {
        let (from, to) = (pair[0].translation.vector, pair[1].translation.vector);
        let axis = pair[0].rotation * Vector3::z();
        let bend = from + axis * axis.dot(&(to - from));
        lines.extend([Line::link(from, bend), Line::link(bend, to)]);
    }
    lines
}

/// The closed linkages: B, column, O, R, T, E, C, F.
fn closed(frames: &[Pose]) -> Vec<Line> {
    let at = |i: usize| frames[i].translation.vector;
    let (o, r, t, e, c, f) = (at(2), at(3), at(4), at(5), at(6), at(7));
    let out = (frames[1].rotation * Vector3::x()).normalize();
    let foot = |distance: f64, degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        o + distance * (cosine * out + sine * Vector3::z())
    };
    let mut lines: Vec<Line> = [(at(0), at(1)), (at(1), o), (o, e), (t, c), (c, f), (o, r), (r, t)]
        .map(|(from, to)| Line::link(from, to))
        .into();
    lines.push(Line::actuator(foot(0.40, -20.0), o + (e - o) * 0.5));
    lines.push(Line::actuator(foot(0.55, 250.0), r));
    lines
}

/// The picture of a kind of robot in its usual pose.
///
/// # Errors
/// The kind is not known.
#[allow(dead_code, reason = "what the tests of the examples call")]
pub fn picture(kind: &str) -> Result<String, String> {
    svg(&request([kind.to_owned()].into_iter())?)
}

fn svg(request: &Request) -> Result<String, String> {
    let arm = Six::new(0.0, -1.55, 0.1, -0.1, 4.6, 0.2);
    Ok(match request.name.as_str() {
        "irp6" => {
            let robot = Irp6::nominal();
            draw(&robot, joints(request, arm)?, chained)
        }
        "irp6-calibrated" => {
            let robot = Irp6::calibrated();
            draw(&robot, joints(request, arm)?, chained)
        }
        "irp6-5dof" => {
            let robot = Irp6FiveDof::nominal();
            let q = joints(request, Five::new(0.0, -1.6, 0.1, 0.6, 1.0))?;
            draw(&robot, q, chained)
        }
        "irp6-track" => {
            let robot = Irp6Track::nominal();
            let q = joints(request, Seven::from([0.5, 0.0, -1.55, 0.1, -0.1, 4.6, 0.2]))?;
            draw(&robot, q, chained)
        }
        "rnt" => {
            let robot = Rnt::new();
            let q = joints(request, Six::new(0.0, 0.5, 0.52, 0.0, 1.3, 0.3))?;
            draw(&robot, q, closed)
        }
        "polycrank" => {
            let robot = Polycrank::new();
            let q = joints(request, Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]))?;
            draw(&robot, q, cranked)
        }
        "gripper" => draw(&Gripper::new(), joints(request, One::new(0.07))?, chained),
        "conveyor" => draw(&Conveyor::new(), joints(request, One::new(0.5))?, chained),
        name => return Err(format!("no robot is called {name}\n{}", usage())),
    })
}

fn main() -> ExitCode {
    let outcome = request(std::env::args().skip(1)).and_then(|request| {
        let text = svg(&request)?;
        std::fs::write(&request.out, text).map_err(|why| format!("cannot write {}: {why}", request.out))?;
        Ok(request.out)
    });
    match outcome {
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
