//! The table of the library's generators and their classes, made from the code.

use mrroc::generator::{Class, Generator, Level, Uses};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::cooperation::StraightBody;
use mrroc_generators::generators::*;
use mrroc_generators::teach::Jogging;
use mrroc_robots::Irp6;
use nalgebra::Vector3;

/// A generator of the library.
pub struct Row {
    /// Name of its module.
    pub name: &'static str,
    /// Its class, which does not depend on the kinds of robot and sensor.
    pub class: Class,
    source: &'static str,
    type_name: &'static str,
}

type Two = [Irp6; 2];
type Points = std::vec::IntoIter<Vector3<f64>>;

/// A force and torque sensor.
pub struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

macro_rules! rows {
    ($($name:ident: $generator:ty,)*) => {
        [$(Row {
            name: stringify!($name),
            class: <$generator as Generator>::CLASS,
            source: include_str!(concat!("../../src/generators/", stringify!($name), ".rs")),
            type_name: stringify!($generator),
        }),*]
    };
}

/// All generators of the library, by name.
pub const ROWS: &[Row] = &rows! {
    await_operator: AwaitOperator<Irp6, fn() -> bool>,
    circular_move: CircularMove<Irp6>,
    compliant_transmit: CompliantTransmit<Irp6, Wrist>,
    constant_order: ConstantOrder<Two>,
    curve_move: CurveMove<Irp6, mrroc_generators::curve::Helix>,
    delay: Delay<Irp6>,
    eye_in_hand: EyeInHand<Irp6, Wrist>,
    follow_master: FollowMaster<Two, StraightBody>,
    followed_frame: FollowedFrame<Irp6, Wrist>,
    force_law: ForceLaw<Irp6, Wrist>,
    guarded_approach: GuardedApproach<Irp6, Wrist>,
    guided_body: GuidedBody<Two, [Wrist; 2]>,
    jog: Jog<Irp6, fn() -> Jogging>,
    joint_move: JointMove<Irp6>,
    joint_spline: JointSpline<Irp6>,
    joint_velocity: JointVelocity<Irp6>,
    joint_via: JointVia<Irp6>,
    line_via: LineVia<Irp6>,
    moving_frame: MovingFrame<Irp6, Pose>,
    ordered_force: OrderedForce<Irp6, Wrist>,
    panel_jog: PanelJog<Irp6>,
    pose_spline_move: PoseSplineMove<Irp6>,
    reach_state: ReachState<Irp6>,
    replay: Replay<Irp6>,
    rigid_carry: RigidCarry<Two, StraightBody>,
    settle: Settle<Irp6>,
    shared_drive: SharedDrive<Two, StraightBody>,
    sleep: Sleep<Irp6>,
    smooth_joint_move: SmoothJointMove<Irp6>,
    spiral_search: SpiralSearch<Irp6>,
    spline_track: SplineTrack<Irp6, Points>,
    squeezed_carry: SqueezedCarry<Two, [Wrist; 2], StraightBody>,
    straight_line: StraightLine<Irp6>,
    tell: Tell<Irp6>,
    tilt_search: TiltSearch<Irp6>,
    time_optimal_curve: TimeOptimalCurve<Irp6, mrroc_generators::curve::Helix>,
    time_optimal_joints: TimeOptimalJoints<Irp6>,
    tool_offset: ToolOffset<Irp6>,
    transmit_displacement: TransmitDisplacement<Irp6>,
    watched_transmit: WatchedTransmit<Irp6>,
    yielding_transmit: YieldingTransmit<Irp6>,
};

impl Row {
    /// What it does: the first line of its file.
    fn summary(&self) -> &'static str {
        let line = self.source.lines().next().unwrap_or_default().trim_start_matches("//!").trim();
        line.trim_end_matches('.')
    }

    /// Lines of code without comments, blank lines and tests.
    fn lines(&self) -> usize {
        let code = self.source.split_once("#[cfg(test)]").map_or(self.source, |(code, _)| code);
        code.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
    }

    /// Its type without parameters.
    fn type_name(&self) -> &'static str {
        self.type_name.split([' ', '<']).next().unwrap_or_default()
    }
}

/// What a step uses besides the function's own state.
fn uses(level: Level, uses: Uses) -> String {
    let order = level == Level::Ecp && uses.order;
    let used =
        [(order, "order"), (uses.robots, "robots"), (uses.sensors, "sensors"), (uses.tick, "path time")];
    let used: Vec<_> = used.into_iter().filter_map(|(uses, name)| uses.then_some(name)).collect();
    if used.is_empty() { "nothing".to_owned() } else { used.join(", ") }
}

/// The table, in Markdown.
pub fn table() -> String {
    let mut table = String::from(
        "| generator | what it does | level | class | first step uses | next steps use | lines |\n|---|---|---|---|---|---|---|\n",
    );
    for row in ROWS {
        let Class { level, first, next, .. } = row.class;
        let class = Class::new(level, next).to_string();
        let (name, function) = class.split_once(' ').unwrap_or(("", &class));
        let (first, next) = (uses(level, first), uses(level, next));
        let (kind, what, lines) = (row.type_name(), row.summary(), row.lines());
        table += &format!("| [`{kind}`] | {what} | {name} | `{function}` | {first} | {next} | {lines} |\n");
    }
    table
}
