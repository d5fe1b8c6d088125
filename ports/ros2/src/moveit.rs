//! What a configuration of MoveIt needs to have the robots of a cell follow its plans.
//!
//! In: a cell's layout, and the names of its robots' joints. Out: `moveit_controllers.yaml` and `joint_limits.yaml`, as the configurations of MoveIt 2 have them.

use std::fmt::Write as _;

use mrroc_core::observe::layout::Layout;
use mrroc_generators::trajectory::{JERK_SHARE, SHARE, TOLERANCE};

use crate::node::topic_name;

/// By how much a polynomial between two of MoveIt's points, 0.1 s apart, may exceed the acceleration of the plan: 1.74 in trapezoids of all kinds, where
/// the acceleration changes its sign between the points.
const OVERSHOOT: f64 = 1.78;

/// The share of a velocity that a plan may use: the same, in plans that come to it between two points.
const VELOCITY: f64 = 0.98;

/// The names by which plans name the joints of each robot: with the robot's before it where several robots have a joint of that name.
pub fn names(layout: &Layout, joints: &[Vec<String>]) -> Vec<Vec<String>> {
    let robots = layout.robots.iter().zip(joints);
    let is_shared = |name: &String| joints.iter().filter(|of| of.contains(name)).count() > 1;
    let named = |robot: &str, name: &String| {
        if is_shared(name) { format!("{}_{name}", topic_name(robot)) } else { name.clone() }
    };
    robots.map(|(robot, joints)| joints.iter().map(|name| named(&robot.name, name)).collect()).collect()
}

/// The controllers: one for each robot, and one for all, which moves several of them as one.
pub fn controllers(layout: &Layout, joints: &[Vec<String>], node: &str) -> String {
    let names = names(layout, joints);
    let mut of: Vec<(String, Vec<String>)> =
        layout.robots.iter().map(|robot| topic_name(&robot.name)).zip(names.iter().cloned()).collect();
    if of.len() > 1 {
        of.push((node.to_owned(), names.concat()));
    }
    let list = |names: &[String]| names.join(", ");
    let all: Vec<String> = of.iter().map(|(name, _)| name.clone()).collect();
    let mut text = format!(
        "# For MoveIt 2. The bridge of mrroc runs with --goals.
moveit_controller_manager: moveit_simple_controller_manager/MoveItSimpleControllerManager

trajectory_execution:
  # From so far away the cell comes to a plan's first point [rad or m].
  allowed_start_tolerance: {TOLERANCE}
  # A cell that is slowed down or suspended takes longer than the plan says.
  execution_duration_monitoring: false

moveit_simple_controller_manager:
  controller_names: [{}]
",
        list(&all)
    );
    for (name, joints) in of {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "
  {name}:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    default: true
    joints: [{}]
",
            list(&joints)
        );
    }
    text
}

/// Down to a millionth: a plan at the limit is within it.
fn rounded(limit: f64) -> f64 {
    (limit * 1e6).floor() * 1e-6
}

/// The limits that a plan must keep.
pub fn limits(layout: &Layout, joints: &[Vec<String>]) -> String {
    let mut text = format!(
        "# For MoveIt 2: {VELOCITY} of the joints' velocities, {:.2} of their accelerations and {JERK_SHARE} of their jerks. Between the points of a plan, 0.1 s
# apart, polynomials need more than the plan; and the rest of the limits is kept for braking on the path.
default_velocity_scaling_factor: 1.0
default_acceleration_scaling_factor: 1.0

joint_limits:
",
        SHARE / OVERSHOOT
    );
    let names = names(layout, joints);
    for (robot, names) in layout.robots.iter().zip(&names) {
        for (joint, name) in robot.joints.iter().zip(names) {
            // Writing to a string does not fail.
            let _ = write!(
                text,
                "  {name}:
    has_velocity_limits: true
    max_velocity: {:?}
    has_acceleration_limits: true
    max_acceleration: {:?}
",
                rounded(VELOCITY * joint.velocity),
                rounded(SHARE / OVERSHOOT * joint.acceleration)
            );
            if let Some(jerk) = joint.jerk {
                let _ = write!(
                    text,
                    "    has_jerk_limits: true\n    max_jerk: {:?}\n",
                    rounded(JERK_SHARE * jerk)
                );
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use mrroc_launch::cell_file::CellFile;
    use mrroc_robots::simulated;

    use super::*;

    #[test]
    fn joints_of_several_robots_have_their_robots_name_and_limits_leave_room_to_halt() {
        let robot = |name: &str| {
            format!("robots.{name} = {{ kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }}\n")
        };
        let text = format!("step_ms = 2\n{}{}", robot("left"), robot("right-arm"));
        let layout = |text: &str| {
            let file = CellFile::parse("cell.toml", text).expect("nothing is wrong with it");
            file.cell(&simulated()).expect("nor with this").layout()
        };
        let joints = ["a", "b", "c", "d", "e", "f"].map(str::to_owned).to_vec();
        let told = controllers(&layout(&text), &[joints.clone(), joints.clone()], "cell");
        for line in [
            "  allowed_start_tolerance: 0.01",
            "  execution_duration_monitoring: false",
            "  controller_names: [left, right_arm, cell]",
            "    joints: [right_arm_a, right_arm_b, right_arm_c, right_arm_d, right_arm_e, right_arm_f]",
            "    joints: [left_a, left_b, left_c, left_d, left_e, left_f, right_arm_a, right_arm_b, right_arm_c, right_arm_d, right_arm_e, right_arm_f]",
        ] {
            assert!(told.lines().any(|told| told == line), "{line}: {told}");
        }
        let alone = layout(&format!("step_ms = 2\n{}", robot("left")));
        let joints = [joints];
        assert!(controllers(&alone, &joints, "cell").contains("controller_names: [left]"));
        // The IRp-6's first joint: 1.5 rad/s and 7 rad/s^2, and no limit of jerk.
        let told = limits(&alone, &joints);
        let expected = "  a:\n    has_velocity_limits: true\n    max_velocity: 1.47\n    has_acceleration_limits: true\n    max_acceleration: 3.146067\n  b:\n";
        assert!(told.contains(expected) && !told.contains("has_jerk_limits"), "{told}");
    }
}
