//! How near the demands of a run came to the limits of each joint.
//!
//! In: the demanded position of every joint in every step. Out: the largest velocity, acceleration and jerk, as first,
//! second and third differences of positions over the step, and the smallest distance from a position limit. This
//! module only reports how much of the limits was left; they are checked where demands are accepted.

use std::cell::RefCell;
use std::fmt;

use mrroc_core::fault::Name;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::{JointLayout, Layout};
use mrroc_core::observe::witness::{What, Witness};
use mrroc_core::robot::MAX_JOINTS;

/// The extreme values of one joint [rad or m, s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes {
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
    /// The smallest distance from the nearer position limit [rad or m].
    pub margin: f64,
}

/// One joint of one robot, from step to step.
#[derive(Clone, Copy, Debug)]
struct Course {
    position: f64,
    velocity: f64,
    acceleration: f64,
    extremes: Extremes,
}

impl Course {
    fn from(position: f64, joint: &JointLayout) -> Course {
        let margin = margin(position, joint);
        let extremes = Extremes { velocity: 0.0, acceleration: 0.0, jerk: 0.0, margin };
        Course { position, velocity: 0.0, acceleration: 0.0, extremes }
    }

    fn advance(&mut self, position: f64, joint: &JointLayout, step: f64) {
        let velocity = (position - self.position) / step;
        let acceleration = (velocity - self.velocity) / step;
        let jerk = (acceleration - self.acceleration) / step;
        let Extremes { velocity: v, acceleration: a, jerk: j, margin: m } = self.extremes;
        self.extremes = Extremes {
            velocity: v.max(velocity.abs()),
            acceleration: a.max(acceleration.abs()),
            jerk: j.max(jerk.abs()),
            margin: m.min(margin(position, joint)),
        };
        (self.position, self.velocity, self.acceleration) = (position, velocity, acceleration);
    }
}

fn margin(position: f64, joint: &JointLayout) -> f64 {
    (position - joint.lower).min(joint.upper - position)
}

/// Watches the demands of a run.
pub(crate) struct Approach {
    layout: Layout,
    /// The joints of each robot, in the order of the layout; empty until the robot's first image has come.
    courses: RefCell<Vec<Vec<Course>>>,
}

impl Approach {
    pub fn of(layout: Layout) -> Approach {
        let empty = |robot: &mrroc_core::observe::layout::RobotLayout| Vec::with_capacity(robot.joints.len());
        let courses = RefCell::new(layout.robots.iter().map(empty).collect());
        Approach { layout, courses }
    }

    /// The extreme values of the joints of a robot, which is given by its index in the cell.
    pub fn extremes(&self, robot: usize) -> Vec<Extremes> {
        let courses = self.courses.borrow();
        courses
            .get(robot)
            .map(|joints| joints.iter().map(|joint| joint.extremes).collect())
            .unwrap_or_default()
    }

    fn show(&self, robot: Name, words: &[u64]) {
        let Some(place) = self.layout.robots.iter().position(|known| known.name == robot.as_str()) else {
            return;
        };
        let (joints, step) = (&self.layout.robots[place].joints, self.layout.step.as_secs_f64());
        let positions = words.iter().take(MAX_JOINTS).map(|word| f64::from_bits(*word));
        let courses = &mut self.courses.borrow_mut()[place];
        if courses.is_empty() {
            courses.extend(joints.iter().zip(positions).map(|(joint, q)| Course::from(q, joint)));
            return;
        }
        for ((course, joint), position) in courses.iter_mut().zip(joints).zip(positions) {
            course.advance(position, joint, step);
        }
    }
}

impl Witness for Approach {
    fn see(&self, _: Nanos, by: ProcessId, what: &What, words: &[u64]) {
        if let (What::Image { .. }, Some(robot)) = (what, by.name) {
            self.show(robot, words);
        }
    }
}

/// A table of all joints: the largest share of each limit, and the smallest margin.
impl fmt::Display for Approach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<16}{:>10}{:>14}{:>8}{:>24}",
            "joint", "velocity", "acceleration", "jerk", "margin to a limit"
        )?;
        for (i, robot) in self.layout.robots.iter().enumerate() {
            for (j, (found, joint)) in self.extremes(i).iter().zip(&robot.joints).enumerate() {
                let share = |found: f64, limit: f64| format!("{:.1} %", 100.0 * found / limit);
                let jerk = joint.jerk.map_or_else(|| "-".to_owned(), |limit| share(found.jerk, limit));
                let (velocity, acceleration) =
                    (share(found.velocity, joint.velocity), share(found.acceleration, joint.acceleration));
                let name = format!("{} {}", robot.name, j + 1);
                let margin = format!("{:.4} {}", found.margin, joint.kind.unit(0));
                writeln!(f, "{name:<16}{velocity:>10}{acceleration:>14}{jerk:>8}{margin:>24}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    use mrroc_core::fault::Role;
    use mrroc_core::observe::layout::RobotLayout;
    use mrroc_core::observe::witness::Mode;
    use mrroc_core::robot::{InterpolationSpace, JointKind};

    /// A robot with one joint from -1 m to 1 m, 1 m/s, 10 m/s².
    fn slide(name: &str, step: Duration) -> RobotLayout {
        let joint = JointLayout {
            kind: JointKind::Prismatic,
            lower: -1.0,
            upper: 1.0,
            velocity: 1.0,
            acceleration: 10.0,
            jerk: None,
            following_error: 0.05,
            braking: 0.1,
        };
        RobotLayout {
            name: name.to_owned(),
            kind: "slide",
            servo: step,
            homed: true,
            ecp_program: false,
            space: InterpolationSpace::Joints,
            joints: vec![joint],
        }
    }

    #[test]
    fn the_extremes_are_those_of_the_path() {
        let step = Duration::from_millis(2);
        let layout = Layout {
            step,
            stop_time: Duration::from_millis(600),
            path_stop: Duration::from_millis(300),
            protective_stop: Duration::from_millis(300),
            detection: 0.022,
            mp_program: true,
            robots: vec![slide("arm", step), slide("other", step)],
            sensors: Vec::new(),
        };
        let approach = Approach::of(layout);
        let by = ProcessId::new(Role::Edp, Name::new("arm").expect("a name"));
        let path = |k: f64| 0.1 * (0.004 * k).sin();
        for step in 0..1000 {
            let mut words = [0; mrroc_core::observe::witness::IMAGE_WORDS];
            words[0] = path(f64::from(step)).to_bits();
            let what = What::Image { step: u64::from(step as u32), mode: Mode::Moving };
            approach.see(0, by, &what, &words);
        }
        // q = 0.1 sin(2 t): v = 0.2 cos, a = 0.4 sin, j = 0.8 cos, except at the start, where v jumps from 0: there the
        // second difference is v / T = 100 and the third one v / T² = 50 000.
        let found = approach.extremes(0)[0];
        assert!((found.velocity - 0.2).abs() < 1e-5, "{found:?}");
        assert!((found.acceleration - 100.0).abs() < 1e-2, "{found:?}");
        assert!((found.jerk - 50e3).abs() < 500.0, "{found:?}");
        assert!((found.margin - (1.0 - 0.1)).abs() < 1e-5, "{found:?}");
        assert!(approach.extremes(1).iter().all(|joint| joint.velocity == 0.0), "it was not shown");
    }
}
