//! How near the demands of a run came to the limits of each joint.
//!
//! In: the demanded position of every joint in every step. Out: the largest velocity, acceleration and jerk, as first,
//! second and third differences of positions over the step, and the smallest distance from a position limit; and the first
//! step of a motion that leaves too little for a suspension. Accelerations and jerks are those of motions: what ends a motion or brakes
//! may take all of a limit. Limits are checked where demands are accepted, and not here.

use std::cell::RefCell;
use std::fmt;

use mrroc_core::cell::PATH_SHARE;
use mrroc_core::fault::Name;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::{JointLayout, Layout};
use mrroc_core::observe::step_observer::{Mode, StepEvent, StepObserver};
use mrroc_core::robot::{MAX_JOINTS, POSITION_ROUND_OFF};

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
struct JointTrace {
    position: f64,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    extremes: Extremes,
}

impl JointTrace {
    fn from(position: f64, joint: &JointLayout) -> JointTrace {
        let margin = margin(position, joint);
        let extremes = Extremes { velocity: 0.0, acceleration: 0.0, jerk: 0.0, margin };
        JointTrace { position, velocity: 0.0, acceleration: 0.0, jerk: 0.0, extremes }
    }

    fn advance(&mut self, position: f64, joint: &JointLayout, step: f64, mode: Mode) {
        let velocity = (position - self.position) / step;
        let acceleration = (velocity - self.velocity) / step;
        let jerk = (acceleration - self.acceleration) / step;
        let extremes = &mut self.extremes;
        extremes.velocity = extremes.velocity.max(velocity.abs());
        extremes.margin = extremes.margin.min(margin(position, joint));
        if mode == Mode::Moving {
            extremes.acceleration = extremes.acceleration.max(acceleration.abs());
            extremes.jerk = extremes.jerk.max(jerk.abs());
        }
        self.position = position;
        self.velocity = velocity;
        self.acceleration = acceleration;
        self.jerk = jerk;
    }
}

fn margin(position: f64, joint: &JointLayout) -> f64 {
    (position - joint.lower).min(joint.upper - position)
}

/// A step of a motion that uses more than [`PATH_SHARE`]: suspended there, it may be refused a demand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TooNear {
    robot: String,
    /// Index of the joint, from 0.
    joint: usize,
    step: u64,
    /// Which limit.
    what: &'static str,
    /// What is used of it.
    share: f64,
}

impl fmt::Display for TooNear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TooNear { robot, joint, step, what, share } = self;
        write!(
            f,
            "{robot} joint {} uses {:.1} % of its {what} limit in step {step}: suspended there, it could not be kept on its path\n help: plan with at most 90 % of the limits of acceleration and jerk",
            joint + 1,
            100.0 * share
        )
    }
}

/// Watches the demands of a run.
pub(crate) struct Approach {
    layout: Layout,
    /// The first step that uses too much.
    too_near: RefCell<Option<TooNear>>,
    /// The joints of each robot, in the order of the layout; empty until the robot's first image has come.
    traces: RefCell<Vec<Vec<JointTrace>>>,
}

impl Approach {
    pub fn of(layout: Layout) -> Approach {
        let empty = |robot: &mrroc_core::observe::layout::RobotLayout| Vec::with_capacity(robot.joints.len());
        let traces = RefCell::new(layout.robots.iter().map(empty).collect());
        Approach { layout, traces, too_near: RefCell::default() }
    }

    /// The first step of a motion that leaves too little for a suspension.
    pub fn too_near(&self) -> Option<TooNear> {
        self.too_near.borrow().clone()
    }

    /// The extreme values of the joints of a robot, which is given by its index in the cell.
    pub fn extremes(&self, robot: usize) -> Vec<Extremes> {
        let traces = self.traces.borrow();
        traces
            .get(robot)
            .map(|joints| joints.iter().map(|joint| joint.extremes).collect())
            .unwrap_or_default()
    }

    fn show(&self, robot: Name, step: u64, mode: Mode, words: &[u64]) {
        let Some(place) = self.layout.robots.iter().position(|known| known.name == robot.as_str()) else {
            return;
        };
        let joints = &self.layout.robots[place].joints;
        let period = self.layout.step.as_secs_f64();
        let positions = words.iter().take(MAX_JOINTS).map(|word| f64::from_bits(*word));
        let traces = &mut self.traces.borrow_mut()[place];
        if traces.is_empty() {
            traces.extend(joints.iter().zip(positions).map(|(joint, q)| JointTrace::from(q, joint)));
            return;
        }
        for (i, ((trace, joint), position)) in traces.iter_mut().zip(joints).zip(positions).enumerate() {
            trace.advance(position, joint, period, mode);
            if mode != Mode::Moving {
                continue;
            }
            // Differences of positions of order 1 are round-off below these.
            let round_off = [4.0, 8.0].map(|times| times * POSITION_ROUND_OFF);
            let acceleration =
                (trace.acceleration.abs() - round_off[0] / period.powi(2)) / joint.acceleration;
            let jerk =
                joint.jerk.map_or(0.0, |limit| (trace.jerk.abs() - round_off[1] / period.powi(3)) / limit);
            let (what, share) =
                if acceleration > jerk { ("acceleration", acceleration) } else { ("jerk", jerk) };
            if share > PATH_SHARE * (1.0 + 1e-6) {
                let robot = self.layout.robots[place].name.clone();
                self.too_near.borrow_mut().get_or_insert(TooNear { robot, joint: i, step, what, share });
            }
        }
    }
}

impl StepObserver for Approach {
    fn see(&self, _: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        if let (StepEvent::Image { step, mode }, Some(robot)) = (what, by.name) {
            self.show(robot, *step, *mode, words);
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
    use mrroc_core::observe::layout::HardwareLayout;

    use mrroc_core::fault::Role;
    use mrroc_core::nalgebra::Vector3;
    use mrroc_core::observe::layout::{Figure, RobotLayout};
    use mrroc_core::pose::Pose;
    use mrroc_core::robot::{InterpolationSpace, JointKind};
    use std::sync::Arc;

    /// Nobody draws these robots.
    struct Nowhere;

    impl Figure for Nowhere {
        fn frames(&self, _: &[f64], _: &mut dyn FnMut(&Pose)) {}
        fn capsules(&self, _: &[f64], _: &mut dyn FnMut([Vector3<f64>; 2], f64)) {}
    }

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
            drives: HardwareLayout::Nothing,
            servo: step,
            homed: true,
            ecp_program: false,
            space: InterpolationSpace::Joints,
            mounted_on: None,
            stop_time: Duration::from_millis(600),
            coupled_limits: Vec::new(),
            signals: Vec::new(),
            joints: vec![joint],
            figure: Arc::new(Nowhere),
        }
    }

    /// A cell of these robots.
    fn layout(step: Duration, robots: Vec<RobotLayout>) -> Layout {
        Layout {
            step,
            stop_time: Duration::from_millis(600),
            path_stop: Duration::from_millis(300),
            protective_stop: Duration::from_millis(300),
            detection: 0.022,
            mp_program: true,
            cells: Vec::new(),
            robots,
            sensors: Vec::new(),
            frames: Vec::new(),
            tools: Vec::new(),
            bodies: Vec::new(),
            obstacles: Vec::new(),
        }
    }

    #[test]
    fn fault_86_what_leaves_less_than_a_tenth_of_a_limit_to_a_suspension_is_told() {
        let step = Duration::from_millis(2);
        let told = |share: f64, mode: Mode| {
            let approach = Approach::of(layout(step, vec![slide("arm", step)]));
            let by = ProcessId::new(Role::Edp, Name::new("arm").expect("a name"));
            // From rest at `share` of 10 m/s².
            for k in 0..20_u32 {
                let mut words = [0; mrroc_core::observe::step_observer::IMAGE_WORDS];
                words[0] = (0.5 * share * 10.0 * 4e-6 * f64::from(k * (k + 1))).to_bits();
                approach.see(0, by, &StepEvent::Image { step: u64::from(k), mode }, &words);
            }
            approach.too_near().is_some()
        };
        assert!(!told(0.9, Mode::Moving) && told(0.91, Mode::Moving) && !told(1.0, Mode::Braking));
        // And the table says of a motion what is checked: at 0.9 it is well, whatever its end takes.
        let approach = Approach::of(layout(step, vec![slide("arm", step)]));
        let by = ProcessId::new(Role::Edp, Name::new("arm").expect("a name"));
        for (k, (position, mode)) in
            [(0.0, Mode::Holding), (36e-6, Mode::Moving), (36e-6, Mode::Holding)].into_iter().enumerate()
        {
            let mut words = [0; mrroc_core::observe::step_observer::IMAGE_WORDS];
            words[0] = f64::to_bits(position);
            approach.see(0, by, &StepEvent::Image { step: k as u64, mode }, &words);
        }
        assert!((approach.extremes(0)[0].acceleration - 9.0).abs() < 1e-9, "{approach}");
    }

    #[test]
    fn the_extremes_are_those_of_the_path() {
        let step = Duration::from_millis(2);
        let approach = Approach::of(layout(step, vec![slide("arm", step), slide("other", step)]));
        let by = ProcessId::new(Role::Edp, Name::new("arm").expect("a name"));
        let path = |k: f64| 0.1 * (0.004 * k).sin();
        for step in 0..1000 {
            let mut words = [0; mrroc_core::observe::step_observer::IMAGE_WORDS];
            words[0] = path(f64::from(step)).to_bits();
            let what = StepEvent::Image { step: u64::from(step as u32), mode: Mode::Moving };
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
        // 100 of 10 m/s² when it begins.
        let told = approach.too_near().expect("a jump").to_string();
        assert!(told.starts_with("arm joint 1 uses 1000.0 % of its acceleration limit in step 1:"), "{told}");
    }
}
