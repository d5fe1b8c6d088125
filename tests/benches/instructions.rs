//! Instructions of a step, and of what a step is made of: `cargo run --release -p mrroc-benches --example instructions` (in
//! `just instructions`). They do not depend on how busy the machine is, so they are compared with a table: by CI as `cargo
//! test` compiles them, with a table of its own.
//!
//! Each kernel runs twice under Valgrind, once with twice the calls: the difference is what they cost, and what was done to
//! prepare them falls out. `--accept` writes the table anew.

use std::hint::black_box;
use std::path::Path;
use std::process::{Command, ExitCode};

use mrroc::generator::Generator;
use mrroc::link::envelope::{Envelope, Seal};
use mrroc::link::message::{Kind, Message, OrderKind};
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc_generators::bspline::{SpanStream, SplineSettings};
use mrroc_generators::feed::{FedPath, FeedLimits};
use mrroc_generators::generators::StraightLine;
use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, SynchronisedMove};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

use mrroc_benches::start;

/// The table of the profile that this was compiled with.
const TABLE: &str = if cfg!(debug_assertions) { "instructions-dev.txt" } else { "instructions.txt" };

/// More instructions than the table says are a regression from here on, in parts of the table's. A release build is one unit of code for each crate. A
/// build for tests is several, and which function is inlined where differs with the features and the folder of the build, by up to 15 %.
const TOLERANCE: f64 = if cfg!(debug_assertions) { 0.2 } else { 0.05 };

/// What is counted: its name, what does so many of it, and how many.
type Kernel = (&'static str, fn(u64), u64);

const KERNELS: [Kernel; 14] = [
    ("step of 1 robot, joints held", mrroc_benches::held::<1>, 300),
    ("step of 2 robots, joints held", mrroc_benches::held::<2>, 300),
    ("step of 8 robots, joints held", mrroc_benches::held::<8>, 100),
    ("step of 64 robots, joints held", mrroc_benches::held::<64>, 50),
    ("step of 2 robots, by poses", mrroc_benches::by_poses::<2>, 300),
    ("step of 2 robots, by poses, with dynamics", mrroc_benches::with_dynamics::<2>, 300),
    ("step of 2 robots with jerk limits", mrroc_benches::jerk_limited::<2>, 300),
    ("step of 1 robot with its own program and a sensor", mrroc_benches::sensed, 300),
    ("message sealed and opened", sealed, 300),
    ("direct kinematics of the IRp-6", forward, 300),
    ("inverse kinematics of the IRp-6", inverse, 300),
    ("demand of a straight line", straight_line, 300),
    ("step along a spline through a stream of points", fed_spline, 1000),
    ("jerk-limited plan of 6 axes from any state", plan, 100),
];

fn sealed(calls: u64) {
    let mut message = Message::new(Kind::Order(OrderKind::Step));
    message.header.len = 8;
    let seal = Seal { session: 1, epoch: 1 };
    for sequence in 0..calls {
        let envelope = black_box(Envelope::seal(black_box(&message), seal, sequence));
        envelope.open(&mut message).expect("it is whole");
    }
}

fn forward(calls: u64) {
    let robot = Irp6::nominal();
    let start = start();
    for call in 0..calls {
        let q = start * (1.0 + 1e-6 * call as f64);
        black_box(robot.forward(black_box(&q)));
    }
}

fn inverse(calls: u64) {
    let robot = Irp6::nominal();
    let start = start();
    let pose = robot.forward(&start);
    for call in 0..calls {
        let near = start * (1.0 + 1e-6 * call as f64);
        black_box(robot.inverse(black_box(&pose), black_box(&near)).is_ok());
    }
}

fn straight_line(calls: u64) {
    let limits = ProfileLimits { velocity: 1e-3, acceleration: 1e-3 };
    let pose = Irp6::nominal().forward(&start());
    let state = RobotState::<Irp6> { joints: start(), velocity: Six::zeros(), pose };
    let (e, v) = (State::<Irp6>::new(RobotImage::new(state, state)), Reading::<()>::new(()));
    let t = Tick { step: 0, dt: 1e-5, duration: 1e-3 };
    let goal = pose * Pose::rotation(Vector3::z()) * Pose::translation(0.0, 0.0, 0.1);
    let mut line = StraightLine::<Irp6>::to(goal, ToolLimits { translation: limits, rotation: limits });
    let _ = line.first_step(&Order::new(()), &e, &v, t);
    for _ in 0..calls {
        let _ = black_box(black_box(&mut line).next_step(&Order::new(()), black_box(&e), &v, black_box(t)));
    }
}

/// Planning of the feed is a part of it. The points are as far apart as the feed goes in five steps.
fn fed_spline(calls: u64) {
    let points = (0..).map(|i| {
        let x = 1e-4 * f64::from(i);
        Vector3::new(x, 0.01 * (100.0 * x).sin(), 0.005 * (70.0 * x).cos())
    });
    let limits = FeedLimits {
        feed: 0.02,
        tangential: 2.0,
        normal: 2.0,
        step: 1e-3,
        chord_error: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    let spans = SpanStream::new(SplineSettings::default(), points).expect("sound settings");
    let mut path = FedPath::<_>::new(limits, spans).expect("sound limits");
    for _ in 0..calls {
        black_box(path.advance(1e-3));
    }
}

fn plan(calls: u64) {
    let limits =
        JointLimits { velocity: Six::repeat(1.0), acceleration: Six::repeat(4.0), jerk: Six::repeat(20.0) };
    let mut x = 0.5_f64;
    // A sequence in -size..size that does not repeat soon.
    let mut draw = |size: f64| {
        Six::from_fn(|_, _| {
            x = (x + 0.618_033_988_749_894_9).fract();
            size * ((x * 97.0).fract() * 2.0 - 1.0)
        })
    };
    for _ in 0..calls {
        let start = JointState { position: draw(2.0), velocity: draw(0.6), acceleration: draw(2.0) };
        let target = JointTarget { position: draw(2.0), velocity: draw(0.6), acceleration: Six::zeros() };
        let _ = black_box(SynchronisedMove::new(black_box(&start), black_box(&target), &limits));
    }
}

/// Instructions of one call of a kernel.
fn count(name: &str, calls: u64) -> Result<f64, String> {
    let run = |calls: u64| {
        let executable = std::env::current_exe().map_err(|error| error.to_string())?;
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]);
        let output = valgrind.arg(executable).arg(name).arg(calls.to_string()).output();
        let output =
            output.map_err(|error| format!("valgrind, of the system's package of that name: {error}"))?;
        let text = String::from_utf8_lossy(&output.stderr);
        // `==1234== I refs: 1,234,567`, with more blanks.
        let refs = text
            .lines()
            .find_map(|line| line.split_once("refs:"))
            .map(|(_, count)| count.replace([',', ' '], ""));
        let refs = refs.and_then(|count| count.parse::<u64>().ok()).filter(|_| output.status.success());
        refs.ok_or_else(|| format!("{name}: {text}"))
    };
    Ok((run(2 * calls)? as f64 - run(calls)? as f64) / calls as f64)
}

/// The table's line of a kernel.
fn known(table: &str, name: &str) -> Option<f64> {
    table
        .lines()
        .filter_map(|line| line.rsplit_once("  "))
        .find_map(|(kernel, count)| (kernel.trim() == name).then(|| count.trim().parse().ok())?)
}

fn measure(accept: bool) -> Result<bool, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(TABLE);
    let table = std::fs::read_to_string(&path).unwrap_or_default();
    let mut written = String::new();
    let mut regressions = 0;
    for (name, _, calls) in KERNELS {
        let counted = count(name, calls)?;
        written += &format!("{name:<54}{counted:>10.0}\n");
        let before = known(&table, name);
        let verdict = match before {
            Some(before) if counted > before * (1.0 + TOLERANCE) => {
                regressions += 1;
                "MORE THAN ALLOWED"
            }
            // A table that is far behind would let a regression pass.
            Some(before) if counted < before * (1.0 - TOLERANCE) => "fewer: write the table anew",
            Some(_) => "",
            None => {
                regressions += 1;
                "NOT IN THE TABLE"
            }
        };
        let ratio = before.map_or(f64::NAN, |before| counted / before);
        println!("{name:<54}{counted:>10.0}  {ratio:>6.3} of the table's  {verdict}");
    }
    if accept {
        std::fs::write(&path, written).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(true);
    }
    Ok(regressions == 0)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [name, calls] = arguments.as_slice()
        && let Some((_, kernel, _)) = KERNELS.iter().find(|(known, ..)| known == name)
    {
        kernel(calls.parse().expect("a number of calls"));
        return ExitCode::SUCCESS;
    }
    match measure(arguments.iter().any(|argument| argument == "--accept")) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("error: a step costs more instructions than tests/benches/{TABLE} says");
            eprintln!(
                " help: make it cheaper; or, if it must cost that, `just instructions --accept` and say why"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
