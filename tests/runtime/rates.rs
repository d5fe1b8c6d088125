//! Robots of several rates in one cell: one curve, one delay, no period skipped.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::generator::Motion;
use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc::robot::InterpolationSpace;
use mrroc_tests::{ExactDrive, Gantry, MS, Q, traced};
use nalgebra::Vector3;

use crate::runtime::kit::Smooth;

/// Four gantries along x together, in the MP.
struct Together(Smooth);

#[generator(mp)]
fn together(c: &mut Together, t: Tick) -> Step<[Gantry; 4]> {
    match c.0.advance(t.dt) {
        Some(x) => Step::Next([Demand::joints(Vector3::new(x, 0.0, 0.0)); 4]),
        None => Step::Done,
    }
}

/// Ends of servo periods \[s\] and what the drives were told for them.
type Trajectory = Rc<RefCell<Vec<(f64, f64)>>>;

fn robot(name: &str, servo: Duration) -> (RobotSetup<Gantry>, Trajectory) {
    let trajectory = Trajectory::default();
    let recorder = Rc::clone(&trajectory);
    let setup = RobotSetup::new(name, Gantry::default(), ExactDrive::new(Q::zeros(), servo));
    let record =
        move |record: &ServoRecord<Gantry>| recorder.borrow_mut().push((record.time, record.demanded[0]));
    (setup.observe(record), trajectory)
}

#[test]
fn devices_of_1000_500_and_250_hz_are_at_one_place_at_one_time_and_no_period_is_skipped() {
    for step in [MS, MS * 2, MS * 4] {
        let servos = [MS, MS * 2, MS * 4, Duration::from_micros(500)];
        let mut cell = Cell::new(step);
        let mut trajectories = Vec::new();
        for (i, servo) in servos.into_iter().enumerate() {
            let (setup, trajectory) = robot(&format!("g{i}"), servo);
            cell = cell.robot(setup);
            trajectories.push(trajectory);
        }
        let report = cell
            .on_step(|step, operator| match step {
                40 => operator.suspend(),
                120 => operator.resume(),
                _ => {}
            })
            .program(|mp| {
                let mut robots = Vec::new();
                for i in 0..4 {
                    robots.push(mp.robot::<Gantry>(&format!("g{i}"))?);
                }
                let [a, b, c, d] = robots.as_mut_slice() else { unreachable!("four") };
                mp.move_robots([a, b, c, d], (), Together(Smooth::to(0.3, 0.8))).map(drop)
            })
            .run()
            .expect("within the limits");
        for (servo, trajectory) in servos.iter().zip(&trajectories) {
            // A period begins half a period after multiples of it.
            let trajectory = trajectory.borrow();
            let periods = (report.time.as_secs_f64() / servo.as_secs_f64() + 0.5).floor();
            assert!((trajectory.len() as f64 - periods).abs() <= 1.0, "{} of {periods}", trajectory.len());
            for (k, (end, _)) in trajectory.iter().enumerate() {
                assert!(
                    (end - (k as f64 + 1.5) * servo.as_secs_f64()).abs() < 1e-9,
                    "period {k} ends at {end}"
                );
            }
            assert!((trajectory[trajectory.len() - 1].1 - 0.3).abs() < 1e-12, "not at the end");
        }
        // The ends of the half-millisecond periods lie at odd quarters, those of the others at halves and wholes: between
        // two samples of a curve whose second derivative is at most 10 m/s² the chord is off by at most a h² / 8.
        let fast = trajectories[3].borrow();
        let at = |time: f64| {
            let k = fast.iter().position(|(end, _)| *end >= time - 1e-9).filter(|&k| k > 0)?;
            let ((t0, x0), (t1, x1)) = (fast[k - 1], fast[k]);
            Some(x0 + (x1 - x0) * (time - t0) / (t1 - t0))
        };
        for (trajectory, servo) in trajectories[..3].iter().zip(servos) {
            let mut compared = 0;
            for (end, x) in trajectory.borrow().iter() {
                let Some(expected) = at(*end) else { continue };
                let bound = 10.0 * 0.0005_f64.powi(2) / 8.0 + 1e-12;
                assert!((x - expected).abs() <= bound, "{servo:?} at {end}: {x}, {expected} (step {step:?})");
                compared += 1;
            }
            assert!(compared > 100);
        }
    }
}

#[test]
fn the_reply_to_a_demand_leaves_before_the_drives_begin_it() {
    // Step 20 ms, servo period 2 ms: the state that the second step is computed from is that of the moment when its order
    // came, one servo period into the first demand's displacement at most, and not that of its end.
    let seen = Rc::new(RefCell::new(Vec::new()));
    let see = Rc::clone(&seen);
    let drive = ExactDrive::new(Q::zeros(), MS * 2);
    let (setup, trace) = traced(RobotSetup::new("g", Gantry::default(), drive));
    let program = move |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.move_robot((), Ramp { k: 0, see: Rc::clone(&see) }).map(drop)
    };
    Cell::new(MS * 20).robot(setup.program(program)).run().expect("gentle");
    let seen = seen.borrow();
    // What step k sees demanded is its own last demand; what it sees measured is behind by a step and more.
    for (k, (demanded, measured)) in seen.iter().enumerate().skip(2) {
        assert!((demanded - x(k as i32)).abs() < 1e-12, "step {k} sees {demanded}");
        assert!(
            *measured <= x(k as i32 - 1) + 1e-12,
            "step {k}: the reply waited for the drives: {measured}"
        );
    }
    assert!((trace.borrow().last().expect("recorded")[0] - x(12)).abs() < 1e-12);
}

/// The displacement of step `k` \[m\]: up with 0.5 m/s², and a standstill.
fn x(k: i32) -> f64 {
    let t = 0.02 * f64::from(k.clamp(0, 6));
    let back = 0.02 * f64::from((k - 6).clamp(0, 6));
    0.25 * t * t + 0.06 * back - 0.25 * back * back
}

struct Ramp {
    k: i32,
    see: Rc<RefCell<Vec<(f64, f64)>>>,
}

#[generator(ecp)]
fn ramp(c: &mut Ramp, e: &State<Gantry>, _t: Tick) -> Step<Gantry> {
    c.see.borrow_mut().push((e.demanded().joints[0], e.measured().joints[0]));
    c.k += 1;
    if c.k > 12 { Step::Done } else { Step::Next(Demand::joints(Vector3::new(x(c.k), 0.0, 0.0))) }
}

/// An arm in the plane whose joints are radius and angle: a straight line of the tool is none of the joints.
mod polar {
    use mrroc::prelude::*;
    use mrroc::robot::{JointKind, Limits, NoInverse};
    use mrroc_tests::Q;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    #[derive(Clone)]
    pub struct Polar(Limits<Q<2>>);

    impl Default for Polar {
        fn default() -> Self {
            let (velocity, acceleration) = (Q::<2>::new(1.0, 2.0), Q::<2>::new(10.0, 20.0));
            let (lower, upper) = (Q::<2>::new(0.05, -3.0), Q::<2>::new(2.0, 3.0));
            Polar(Limits { lower, upper, velocity, acceleration, jerk: None })
        }
    }

    impl Robot for Polar {
        const KIND: &'static str = "polar";
        type Joints = Q<2>;

        fn joint(&self, i: usize) -> JointKind {
            if i == 0 { JointKind::Prismatic } else { JointKind::Revolute }
        }

        fn limits(&self) -> &Limits<Q<2>> {
            &self.0
        }

        fn forward(&self, q: &Q<2>) -> Pose {
            // The flange does not turn: any line is attainable.
            Pose::from_parts(
                Translation3::new(q[0] * q[1].cos(), q[0] * q[1].sin(), 0.0),
                UnitQuaternion::from_scaled_axis(Vector3::zeros()),
            )
        }

        #[allow(non_snake_case)]
        fn inverse(&self, X_WF: &Pose, _: &Q<2>) -> Result<Q<2>, NoInverse> {
            let p = X_WF.translation.vector;
            Ok(Q::<2>::new(p.x.hypot(p.y), p.y.atan2(p.x)))
        }
    }
}

use polar::Polar;

/// Along x at y = 0.2 m, in steps of 20 ms.
struct Across(Smooth);

#[generator(ecp)]
fn across(c: &mut Across, t: Tick) -> Step<Polar, Motion> {
    match c.0.advance(t.dt) {
        Some(x) => Step::Next(Demand::pose(Pose::translation(0.3 - x, 0.2, 0.0))),
        None => Step::Done,
    }
}

/// The same, and gives up in the middle.
struct GivesUp(Smooth);

#[generator(ecp)]
fn gives_up(c: &mut GivesUp, t: Tick) -> Result<Step<Polar>, Fault> {
    match c.0.advance(t.dt) {
        Some(x) if x > 0.3 => Err(Fault::thrown("gives up")),
        Some(x) => Ok(Step::Next(Demand::pose(Pose::translation(0.3 - x, 0.2, 0.0)))),
        None => Ok(Step::Done),
    }
}

/// There by poses and back by joints, without a stop between.
struct ThereAndBack(Smooth, Smooth);

#[generator(ecp)]
fn there_and_back(c: &mut ThereAndBack, t: Tick) -> Step<Polar> {
    let polar = |x: f64| Q::<2>::new((0.3 - x).hypot(0.2), 0.2_f64.atan2(0.3 - x));
    match c.0.advance(t.dt) {
        Some(x) => Step::Next(Demand::pose(Pose::translation(0.3 - x, 0.2, 0.0))),
        None => c.1.advance(t.dt).map_or(Step::Done, |x| Step::Next(Demand::joints(polar(0.6 - x)))),
    }
}

/// The largest accelerations of the drives' positions [m/s², rad/s²], by differences.
fn peaks_of<G>(space: InterpolationSpace, make: impl Fn() -> G + 'static) -> [f64; 2]
where
    G: mrroc::generator::Generator<Robots = Polar, Sensors = (), Language = Motion> + 'static,
{
    let told = Rc::new(RefCell::new(Vec::new()));
    let keep = Rc::clone(&told);
    let start = Q::<2>::new(0.3_f64.hypot(0.2), 0.2_f64.atan2(0.3));
    let setup = RobotSetup::new("p", Polar::default(), ExactDrive::new(start, MS * 2))
        .interpolation(space)
        .observe(move |record: &ServoRecord<Polar>| keep.borrow_mut().push(record.demanded))
        .program(move |ecp| ecp.move_robot((), make()).map(drop));
    // One of them ends with a fault of its own.
    Cell::new(MS * 20).robot(setup).run().ok();
    let told = told.borrow();
    assert!(told.len() > 300, "{} periods", told.len());
    [0, 1].map(|i| {
        told.windows(3).fold(0.0, |peak: f64, w| peak.max((w[2][i] - 2.0 * w[1][i] + w[0][i]).abs() / 4e-6))
    })
}

#[test]
fn leaving_the_task_space_for_a_fault_or_for_joints_asks_for_no_more_than_the_limits() {
    for space in [InterpolationSpace::Joints, InterpolationSpace::Task] {
        for [radius, angle] in [
            peaks_of(space, || GivesUp(Smooth::to(0.6, 2.4))),
            peaks_of(space, || ThereAndBack(Smooth::to(0.6, 2.4), Smooth::to(0.6, 2.4))),
        ] {
            assert!(
                radius <= 10.0 * 1.02 && angle <= 20.0 * 1.02,
                "{space:?}: {radius} m/s², {angle} rad/s²"
            );
        }
    }
}

/// Two slides along x, one on the other: a pose does not say where each of them is.
#[derive(Clone)]
struct Tandem(mrroc::robot::Limits<Q<2>>);

impl mrroc::robot::Robot for Tandem {
    const KIND: &'static str = "tandem";
    type Joints = Q<2>;

    fn limits(&self) -> &mrroc::robot::Limits<Q<2>> {
        &self.0
    }

    fn forward(&self, q: &Q<2>) -> Pose {
        Pose::translation(q[0] + q[1], 0.0, 0.0)
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Q<2>) -> Result<Q<2>, mrroc::robot::NoInverse> {
        self.inverse_at(X_WF, near[0], near)
    }

    #[allow(non_snake_case)]
    fn inverse_at(&self, X_WF: &Pose, first: f64, _: &Q<2>) -> Result<Q<2>, mrroc::robot::NoInverse> {
        Ok(Q::<2>::new(first, X_WF.translation.x - first))
    }
}

#[test]
fn a_robot_whose_joints_a_pose_does_not_determine_is_not_interpolated_in_the_task_space() {
    let limits = mrroc::robot::Limits {
        lower: Q::repeat(-2.0),
        upper: Q::repeat(2.0),
        velocity: Q::repeat(1.0),
        acceleration: Q::repeat(10.0),
        jerk: None,
    };
    let robot = RobotSetup::new("t", Tandem(limits), ExactDrive::new(Q::<2>::zeros(), MS))
        .interpolation(InterpolationSpace::Task)
        .program(|_| Ok(()));
    let error = Cell::new(MS * 4).robot(robot).run().expect_err("redundant");
    assert!(error.to_string().contains("robot `t`: a pose does not determine its joints"), "{error}");
}

/// The largest distance of the drives' positions from the line \[m\].
fn off_the_line(space: InterpolationSpace) -> f64 {
    let worst = Rc::new(RefCell::new(0.0_f64));
    let (keep, robot) = (Rc::clone(&worst), Polar::default());
    let start = Q::<2>::new(0.3_f64.hypot(0.2), 0.2_f64.atan2(0.3));
    let setup = RobotSetup::new("p", robot, ExactDrive::new(start, MS * 2))
        .interpolation(space)
        .observe(move |record: &ServoRecord<Polar>| {
            let off = (record.demanded[0] * record.demanded[1].sin() - 0.2).abs();
            let mut worst = keep.borrow_mut();
            *worst = worst.max(off);
        })
        .program(|ecp| ecp.move_robot((), Across(Smooth::to(0.6, 2.4))).map(drop));
    Cell::new(MS * 20).robot(setup).run().expect("within the limits");
    *worst.borrow()
}

#[test]
fn a_line_stays_straight_between_demands_that_are_interpolated_in_the_task_space() {
    // In joints the quadratic spline cuts the corner of second order: some a T² / 8 = 0.5 m/s² x (20 ms)² / 8 = 3e-5 m.
    let joints = off_the_line(InterpolationSpace::Joints);
    let task = off_the_line(InterpolationSpace::Task);
    assert!(task < 1e-12, "{task} m in the task space");
    assert!(joints > 1e-6 && joints < 5e-4, "{joints} m in joints");
}
