//! A robot as a URDF, for programs of others; and, as a comment in it, what a URDF cannot say of the robot.
//!
//! In: a tree of bodies, the limits of its coordinates, notes. Out: text. Links have the frames of the tree's segments,
//! which at 0 have the axes of the base wherever the model is written so. Angles are roll, pitch and yaw with all digits.

use core::fmt::Write;

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, JointVector, Limits, Tool};
use nalgebra::Matrix3;

use super::places::CONTINUOUS;
use crate::dynamics::{Segment, Tree};
use crate::models::drives::Driven;

/// What a URDF says of a coordinate beside its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinate {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) velocity: f64,
    pub(crate) effort: f64,
    pub(crate) damping: f64,
    pub(crate) friction: f64,
}

/// The URDF of a robot whose joints are the coordinates of its tree; `None` where it has no tree.
pub(crate) fn exported<const N: usize, R: Driven<N>>(robot: &R, name: &str, tool: &Tool) -> Option<String> {
    let tree = robot.tree()?;
    Some(written(name, &tree, &coordinates(robot), tool, &notes(robot)))
}

/// Limits, and effort and friction of the motors as the joints feel them where the motors are at their marks.
pub(crate) fn coordinates<const N: usize, R: Driven<N>>(robot: &R) -> [Coordinate; N] {
    let Limits { lower, upper, velocity, .. } = robot.limits();
    let ratios = robot.ratios(&robot.marks());
    core::array::from_fn(|i| {
        let motor = &robot.motor_data()[i];
        let ratio = ratios[(i, i)].abs();
        Coordinate {
            lower: lower[i],
            upper: upper[i],
            velocity: velocity[i],
            effort: motor.torque_constant * motor.current_limit / ratio,
            damping: motor.viscous / (ratio * ratio),
            friction: motor.coulomb / ratio,
        }
    })
}

/// What a URDF cannot say of a robot's drives.
pub(crate) fn notes<const N: usize, R: Driven<N>>(robot: &R) -> Vec<String> {
    let marks = robot.marks();
    let ratios = robot.ratios(&marks);
    let limits = robot.motor_limits();
    let rotors = robot.rotors();
    let Limits { lower, upper, .. } = robot.limits();
    let elsewhere = robot.ratios(&robot.motors(&((lower + upper) * 0.5 + (upper - lower) * 0.1)));
    let mut notes = vec![
        "Transmission: speeds of the joints by those of the motors, dq/dm [rad/rad or m/rad], row by row:"
            .to_owned(),
    ];
    for row in ratios.row_iter() {
        let numbers: Vec<_> = row.iter().map(|ratio| format!("{:.6e}", ratio + 0.0)).collect();
        notes.push(format!("  {}", numbers.join("  ")));
    }
    let changes = (ratios - elsewhere).iter().any(|change| !change.is_finite() || change.abs() > 1e-12);
    notes.push(match changes {
        true => "  This is where the motors are at their marks; it depends on the posture.".to_owned(),
        false => "  It is the same in every posture.".to_owned(),
    });
    notes.push(
        "Motors: rotor's inertia, viscous and Coulomb friction, lasting torque; angles and speed allowed:"
            .to_owned(),
    );
    for (i, motor) in robot.motor_data().iter().enumerate() {
        notes.push(format!(
            "  motor {}: {:.4e} kg m2, {:.4e} N m s, {:.4e} N m, {:.4e} N m; {} to {} rad, {} rad/s",
            i + 1,
            rotors[i],
            motor.viscous,
            motor.coulomb,
            motor.torque_constant * motor.current_limit,
            limits.lower[i],
            limits.upper[i],
            limits.speed
        ));
    }
    notes.push("  A rotor is no link: at its joint it has this inertia divided by the square of dq/dm. Coulomb friction holds".to_owned());
    notes.push("  a motor that stands. effort, damping and friction of the joints are those of motor i alone, at its mark.".to_owned());
    notes.push("  Joints that share motors share these limits.".to_owned());
    let limits = robot.limits();
    let list = |values: &R::Joints| {
        let numbers: Vec<_> = (0..R::Joints::LEN).map(|i| values[i].to_string()).collect();
        numbers.join(", ")
    };
    notes.push(format!("Accelerations allowed [rad/s2 or m/s2]: {}.", list(&limits.acceleration)));
    if let Some(jerk) = &limits.jerk {
        notes.push(format!("Jerks allowed [rad/s3 or m/s3]: {}.", list(jerk)));
    }
    if robot.tree().is_some_and(|tree| tree.mass() == 0.0) {
        notes.push("Masses: none are known of this robot; its links have none here.".to_owned());
    }
    notes
}

/// A tree as a URDF.
pub(crate) fn written<const N: usize>(
    name: &str,
    tree: &Tree<N>,
    coordinates: &[Coordinate; N],
    tool: &Tool,
    notes: &[String],
) -> String {
    let mut urdf = String::from("<?xml version=\"1.0\"?>\n<!--\n");
    urdf.push_str("  What a URDF cannot say of this robot:\n");
    for note in notes {
        // Two hyphens would end a comment.
        urdf.push_str(&format!("  {}\n", note.replace("--", "- -")));
    }
    urdf.push_str(&format!("-->\n<robot name=\"{}\">\n  <link name=\"world\"/>\n", escaped(name)));
    let segments = tree.segments();
    let fixed = |wanted: &str| {
        let mut name = wanted.to_owned();
        let is_taken =
            |name: &str| segments.iter().any(|segment| segment.name == name || link_of(segment) == name);
        while is_taken(&name) || is_taken(&format!("{name}_fixed")) {
            name.push('_');
        }
        name
    };
    let (base, flange, tip) = (fixed("base"), fixed("flange"), fixed("tool"));
    let join = |urdf: &mut String, name: &str, parent: &str, pose: &Pose| {
        let _ = write!(
            urdf,
            "  <joint name=\"{name}_fixed\" type=\"fixed\">\n    {}\n    <parent link=\"{}\"/>\n    \
             <child link=\"{name}\"/>\n  </joint>\n",
            origin(pose),
            escaped(parent)
        );
    };
    let _ = writeln!(urdf, "  <link name=\"{base}\"/>");
    join(&mut urdf, &base, "world", tree.base());
    for segment in segments {
        let parent = segment.parent.map_or_else(|| base.clone(), |parent| link_of(&segments[parent]));
        link(&mut urdf, &link_of(segment), &segment.body);
        joint(&mut urdf, segment, &parent, leader(segments, segment), &coordinates[segment.coordinate]);
    }
    let last = segments.last().map_or_else(|| base.clone(), link_of);
    link(&mut urdf, &flange, &tool.load);
    join(&mut urdf, &flange, &last, tree.tip());
    let _ = writeln!(urdf, "  <link name=\"{tip}\"/>");
    join(&mut urdf, &tip, &flange, &tool.frame);
    urdf.push_str("</robot>\n");
    urdf
}

fn link_of(segment: &Segment) -> String {
    format!("{}_link", segment.name)
}

/// The segment that this one follows; `None` for one that moves by itself.
fn leader<'s>(segments: &'s [Segment], segment: &Segment) -> Option<&'s Segment> {
    let leads =
        |one: &&Segment| one.coordinate == segment.coordinate && one.multiplier == 1.0 && one.offset == 0.0;
    segments.iter().find(leads).filter(|leader| leader.name != segment.name)
}

fn link(urdf: &mut String, name: &str, body: &mrroc::robot::Load) {
    if body.mass == 0.0 && body.inertia.amax() == 0.0 {
        let _ = writeln!(urdf, "  <link name=\"{}\"/>", escaped(name));
        return;
    }
    let (c, i) = (&body.centre, &body.inertia);
    let _ = write!(
        urdf,
        "  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{} {} {}\"/>\n      <mass value=\"{}\"/>\n      \
         <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>\n    </inertial>\n  </link>\n",
        escaped(name),
        c.x,
        c.y,
        c.z,
        body.mass,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)]
    );
}

fn joint(urdf: &mut String, segment: &Segment, parent: &str, leader: Option<&Segment>, of: &Coordinate) {
    let (factor, offset) = (segment.multiplier, segment.offset);
    let (a, b) = (factor * of.lower + offset, factor * of.upper + offset);
    let is_endless = segment.kind == JointKind::Revolute && of.lower <= -CONTINUOUS && of.upper >= CONTINUOUS;
    let kind = match segment.kind {
        JointKind::Prismatic => "prismatic",
        JointKind::Revolute if is_endless => "continuous",
        JointKind::Revolute => "revolute",
    };
    let range =
        if is_endless { String::new() } else { format!("lower=\"{}\" upper=\"{}\" ", a.min(b), a.max(b)) };
    let _ = write!(
        urdf,
        "  <joint name=\"{}\" type=\"{kind}\">\n    {}\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n    \
         <axis xyz=\"{} {} {}\"/>\n    <limit {range}effort=\"{}\" velocity=\"{}\"/>\n",
        escaped(&segment.name),
        origin(&segment.X_PJ),
        escaped(parent),
        escaped(&link_of(segment)),
        segment.axis.x,
        segment.axis.y,
        segment.axis.z,
        of.effort,
        of.velocity * factor.abs(),
    );
    match leader {
        Some(leader) => {
            let name = escaped(&leader.name);
            let _ =
                writeln!(urdf, "    <mimic joint=\"{name}\" multiplier=\"{factor}\" offset=\"{offset}\"/>");
        }
        None => {
            let _ = writeln!(urdf, "    <dynamics damping=\"{}\" friction=\"{}\"/>", of.damping, of.friction);
        }
    }
    urdf.push_str("  </joint>\n");
}

fn origin(pose: &Pose) -> String {
    let p = pose.translation.vector;
    let [roll, pitch, yaw] = angles(pose.rotation.to_rotation_matrix().matrix());
    format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", p.x, p.y, p.z)
}

/// Roll, pitch and yaw \[rad\] of a rotation, `R_z(yaw) R_y(pitch) R_x(roll)`, exact where pitch is a right angle, too: there
/// yaw is whatever round-off makes it, and roll is what is left.
fn angles(r: &Matrix3<f64>) -> [f64; 3] {
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let (s, c) = yaw.sin_cos();
    let pitch = (-r[(2, 0)]).atan2(c * r[(0, 0)] + s * r[(1, 0)]);
    // The middle row of R_z(-yaw) R is (0, cos roll, -sin roll).
    let middle = |column: usize| c * r[(1, column)] - s * r[(0, column)];
    let roll = (-middle(2)).atan2(middle(1));
    // -0 is written as 0.
    [roll, pitch, yaw].map(|angle| angle + 0.0)
}

/// Text in an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn roll_pitch_and_yaw_say_every_rotation() {
        let mut worst = 0.0_f64;
        let turn = |axis: Vector3<f64>, angle: f64| *nalgebra::Rotation3::new(axis * angle).matrix();
        for k in 0..4000 {
            let angle = |factor: f64| (f64::from(k) * factor).sin() * 3.2;
            // Right angles, and next to them.
            let right = core::f64::consts::FRAC_PI_2 + 10_f64.powi(-(k % 18)) * angle(0.7);
            let pitch = if k % 3 == 0 { right } else { angle(1.3) };
            let pitch = if k % 2 == 0 { pitch } else { -pitch };
            let r =
                turn(Vector3::z(), angle(0.3)) * turn(Vector3::y(), pitch) * turn(Vector3::x(), angle(2.1));
            let [roll, pitch, yaw] = angles(&r);
            let back = turn(Vector3::z(), yaw) * turn(Vector3::y(), pitch) * turn(Vector3::x(), roll);
            worst = worst.max((back - r).amax());
        }
        assert!(worst < 1e-15 * 4.0, "{worst}");
    }
}
