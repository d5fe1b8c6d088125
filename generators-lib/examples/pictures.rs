//! Draws what generators demand, one SVG each: position, velocity, acceleration, jerk over time, and the path in space.
//! `cargo run -p mrroc-generators --example pictures -- generators-lib/pictures`

use std::fmt::Write as _;
use std::path::PathBuf;

use mrroc::{
    Demand, Generator, Motion, Order, Pose, Reading, Robot, RobotImage, RobotState, State, Step, Tick,
};
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::combinators::Sequence;
use mrroc_generators::cooperation::Functional;
use mrroc_generators::curve::Helix;
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::*;
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::{JerkLimits, ProfileLimits};
use mrroc_generators::teach::{Jogging, Reference, Space, Taught, TaughtPose};
use mrroc_generators::timing::PathLimits;
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

/// Path time of a step \[s\].
const DT: f64 = 4e-3;
/// Width and height of a chart, and where the first one stands on the page \[px\].
const W: f64 = 560.0;
const H: f64 = 110.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 50.0;
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

fn start() -> RobotImage<Irp6> {
    let q = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let state = RobotState { joints: q, velocity: Six::zeros(), pose: Irp6::nominal().forward(&q) };
    RobotImage::new(state, state)
}

/// Positions of the tool \[m\] as they are demanded, from the start to the end.
fn run<G>(mut generator: G) -> Vec<Vector3<f64>>
where
    G: Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()>,
{
    let (mut image, origin, robot) = (start(), start().demanded().pose, Irp6::nominal());
    let mut positions = vec![origin.translation.vector];
    let (order, v) = (Order::new(()), Reading::new(()));
    for i in 0..10_000 {
        let (t, e) = (Tick { step: i, dt: DT, duration: DT }, State::new(image));
        let step = if i == 0 {
            generator.first_step(&order, &e, &v, t)
        } else {
            generator.next_step(&order, &e, &v, t)
        };
        let Ok(Step::Next(demand)) = step else { break };
        let demand: Demand<Irp6> = demand;
        let pose = demand
            .as_pose()
            .or_else(|| demand.as_displacement().map(|moved| origin * moved))
            .or_else(|| demand.as_joints().map(|q| robot.forward(&q)))
            .unwrap_or(image.demanded().pose);
        let joints = demand.as_joints().unwrap_or(image.demanded().joints);
        let state = RobotState { joints, velocity: Six::zeros(), pose };
        image = RobotImage::new(state, state);
        positions.push(pose.translation.vector);
    }
    positions
}

/// Central differences; at an end, the value beside it.
fn derivative(x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut v: Vec<_> = x.windows(3).map(|w| (w[2] - w[0]) / (2.0 * DT)).collect();
    let (first, last) = (v.first().copied().unwrap_or_default(), v.last().copied().unwrap_or_default());
    v.insert(0, first);
    v.push(last);
    v
}

/// A line through points of the page.
fn line(svg: &mut String, points: impl Iterator<Item = (f64, f64)>, colour: &str) {
    let _ = write!(svg, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"");
    for (x, y) in points {
        let _ = write!(svg, "{x:.1},{y:.1} ");
    }
    svg.push_str("\"/>\n");
}

fn words(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
}

fn draw(name: &str, positions: &[Vector3<f64>]) -> String {
    let ways: Vec<_> = positions.iter().map(|p| p - positions[0]).collect();
    let (velocity, duration) = (derivative(&ways), DT * (ways.len() - 1) as f64);
    let acceleration = derivative(&velocity);
    let jerk = derivative(&acceleration);
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1000 640\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"1000\" height=\"640\" fill=\"#fff\"/>\n",
    );
    words(
        &mut svg,
        LEFT,
        24.0,
        "start",
        &format!("<tspan font-weight=\"bold\" font-size=\"15\">{name}</tspan>"),
    );
    let rows = [
        ("way [m]", &ways),
        ("velocity [m/s]", &velocity),
        ("acceleration [m/s²]", &acceleration),
        ("jerk [m/s³]", &jerk),
    ];
    for (k, (heading, values)) in rows.into_iter().enumerate() {
        let top = TOP + k as f64 * (H + 32.0);
        let all = || values.iter().flat_map(|p| p.iter().copied());
        let (low, high) = all().fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        let scale = if high > low { H / (high - low) } else { 1.0 };
        let y = |x: f64| top + H - (x - low) * scale;
        let _ = writeln!(
            svg,
            "<path stroke=\"#999\" fill=\"none\" d=\"M{LEFT},{top}V{0}M{LEFT},{1}H{2}\"/>",
            top + H,
            y(0.0),
            LEFT + W
        );
        words(&mut svg, LEFT, top - 6.0, "start", heading);
        // Not where another label stands.
        for x in [low, 0.0, high].into_iter().filter(|x| *x == 0.0 || (y(*x) - y(0.0)).abs() > 12.0) {
            words(&mut svg, LEFT - 6.0, y(x) + 4.0, "end", &format!("{:.3}", x + 0.0));
        }
        for (axis, colour) in COLOURS.iter().enumerate() {
            let points = values
                .iter()
                .enumerate()
                .map(|(i, p)| (LEFT + W * i as f64 * DT / duration.max(DT), y(p[axis])));
            line(&mut svg, points, colour);
        }
    }
    words(&mut svg, LEFT + W, TOP + 4.0 * (H + 32.0) - 16.0, "end", &format!("{duration:.3} s"));
    // The path from above and from the side, to one scale.
    let size = ways.iter().map(|p| p.amax()).fold(1e-6, f64::max);
    for (k, (heading, axes)) in [("x right, y up", (0, 1)), ("x right, z up", (0, 2))].into_iter().enumerate()
    {
        let (x0, y0) = (820.0, 180.0 + 280.0 * k as f64);
        let _ = writeln!(
            svg,
            "<path stroke=\"#ccc\" fill=\"none\" d=\"M{0},{y0}h260M{x0},{1}v260\"/>",
            x0 - 130.0,
            y0 - 130.0
        );
        words(&mut svg, x0, y0 - 138.0, "middle", &format!("path, {heading}: {size:.3} m to the edge"));
        line(
            &mut svg,
            ways.iter().map(|p| (x0 + 130.0 * p[axes.0] / size, y0 - 130.0 * p[axes.1] / size)),
            "#222",
        );
    }
    for (axis, colour) in COLOURS.iter().enumerate() {
        let name = ["x", "y", "z"][axis];
        words(
            &mut svg,
            LEFT + W - 60.0 + 24.0 * axis as f64,
            24.0,
            "start",
            &format!("<tspan fill=\"{colour}\">{name}</tspan>"),
        );
    }
    svg + "</svg>\n"
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("say into which folder")?);
    let limits = |velocity, acceleration| {
        let limits = ProfileLimits { velocity, acceleration };
        ToolLimits { translation: limits, rotation: limits }
    };
    let (here, tool) = (start().demanded().pose, limits(0.2, 0.8));
    let offset = Pose::new(Vector3::new(0.1, 0.05, 0.02), Vector3::z() * 0.3);
    let points: Vec<_> = (0..=48).map(|i| f64::from(i) * std::f64::consts::TAU / 48.0).collect();
    let points: Vec<_> =
        points.into_iter().map(|a| Vector3::new(1.0 - a.cos(), (2.0 * a).sin() / 2.0, 0.0) * 0.05).collect();
    let infinite = f64::INFINITY;
    let feed = FeedLimits {
        feed: 0.1,
        tangential: 0.4,
        normal: 0.4,
        step: DT,
        chord_error: infinite,
        jerk: infinite,
    };
    let belt = Functional::new(move |age| Pose::translation(0.1 * age, 0.0, 0.0) * here);
    let taught = [[0.08, 0.0, 0.0], [0.0, 0.08, 0.0], [-0.08, -0.08, 0.04]];
    let taught = taught.map(|[x, y, z]| TaughtPose::new(1.0, 1.0, &[x, y, z, 0.0, 0.0, 0.0]));
    let poses = taught.into_iter().collect::<Option<_>>().ok_or("out of range")?;
    let taught = Taught { space: Space::AngleAxis, reference: Reference::Relative, poses };
    let mut step = 0;
    let panel = move || {
        step += 1;
        let turned = if step < 200 { Vector3::x() } else { Vector3::y() };
        Jogging { along: turned * 0.1, done: step > 400, ..Jogging::default() }
    };
    let spline = SplineTrack::through(
        points,
        SplineSettings::default(),
        feed,
        here,
        nalgebra::UnitQuaternion::identity(),
    )?;
    let (q, sixth) = (start().demanded().joints, Six::repeat(1.0));
    let sequence = Sequence::of(StraightLine::by(offset, tool), StraightLine::to(here, tool));
    let at = |x: f64, y: f64| q + Six::new(x, y, -0.5 * x, 0.0, y, 0.3 * x);
    let joints = vec![at(0.2, 0.1), at(0.4, -0.1), at(0.3, 0.2), at(0.0, 0.1)];
    let path = PathLimits { velocity: sixth * 0.4, acceleration: sixth * 1.6, speed: infinite };
    let joint = JointLimits { velocity: sixth * 0.4, acceleration: sixth * 1.6, jerk: sixth * 16.0 };
    let unit = JerkLimits { velocity: 0.2, acceleration: 0.8, jerk: 8.0 };
    let smooth = SmoothToolLimits {
        translation: unit,
        rotation: JerkLimits { velocity: 1.0, acceleration: 4.0, jerk: 40.0 },
    };
    let by = |x: f64, y: f64, z: f64| Pose::translation(x, y, z) * here;
    let square = vec![by(0.1, 0.0, 0.0), by(0.1, 0.1, 0.0), by(0.0, 0.1, 0.05), here];
    let helix =
        Helix::about(Vector3::x() * 0.05, Vector3::zeros(), Vector3::z_axis(), std::f64::consts::TAU, 0.05)?;
    let pictures = [
        (
            "joint_move",
            run(JointMove::to(q + Six::new(0.3, 0.2, -0.1, 0.0, 0.1, 0.0), sixth * 0.4, sixth * 1.6)),
        ),
        ("straight_line", run(StraightLine::by(offset, tool))),
        ("tool_offset", run(ToolOffset::by(offset, tool))),
        ("spline_track", run(spline)),
        ("moving_frame", run(MovingFrame::to(belt, Pose::translation(0.0, 0.1, 0.05), 1.0, 1.5))),
        ("replay", run(Replay::of(taught, sixth, sixth, tool))),
        ("jog", run(Jog::by(panel, (0.5, 1.0), 0))),
        ("sequence", run(sequence)),
        ("time_optimal_joints", run(TimeOptimalJoints::through(joints.clone(), path))),
        ("time_optimal_curve", run(TimeOptimalCurve::along(Irp6::nominal(), helix, path))),
        ("joint_via", run(JointVia::through(joints, sixth * 0.02, joint))),
        ("line_via", run(LineVia::through(square.clone(), (0.01, 0.1), smooth))),
        ("pose_spline_move", run(PoseSplineMove::through(square, smooth))),
    ];
    std::fs::create_dir_all(&folder)?;
    for (name, positions) in pictures {
        std::fs::write(folder.join(format!("{name}.svg")), draw(name, &positions))?;
    }
    Ok(())
}
