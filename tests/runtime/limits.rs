//! Limits: what a cell refuses before it runs, and the bounds on stops that follow from this.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use mrroc::fault::{Excess, FaultKind};
use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, NoInverse};
use mrroc_robots::{Irp6, SimulatedIrp6};
use mrroc_tests::{ExactDrive, MS, Q, fault, peaks, traced};

/// Three slides with any limits, weak brakes and a limit on x + y.
#[derive(Clone)]
struct Bench {
    limits: Limits<Q<3>>,
    faded: Limits<Q<3>>,
    /// When the second limits begin to hold.
    fades: Arc<AtomicBool>,
    /// Largest x + y \[m\].
    sum: f64,
}

impl Bench {
    fn new() -> Bench {
        let limits = Limits {
            lower: Q::repeat(-1.0),
            upper: Q::repeat(1.0),
            velocity: Q::repeat(1.0),
            acceleration: Q::repeat(10.0),
            jerk: None,
        };
        Bench { limits, faded: limits, fades: Arc::default(), sum: 9.0 }
    }

    fn with(change: impl FnOnce(&mut Limits<Q<3>>)) -> Bench {
        let mut bench = Bench::new();
        change(&mut bench.limits);
        bench
    }
}

impl Robot for Bench {
    const KIND: &'static str = "bench";
    type Joints = Q<3>;

    fn joint(&self, _: usize) -> JointKind {
        JointKind::Prismatic
    }

    fn limits(&self) -> &Limits<Q<3>> {
        if self.fades.load(Ordering::Relaxed) { &self.faded } else { &self.limits }
    }

    fn check_coupled(&self, from: &Q<3>, to: &Q<3>, duration: f64) -> Result<(), CoupledLimit> {
        assert!(((to - from) / duration).amax() <= 1.0 + 1e-9, "faster than the joints may be");
        let sum = to[0] + to[1];
        if sum > self.sum {
            return Err(CoupledLimit { joint: 1, what: "x + y", excess: Excess::new(sum, self.sum, "m") });
        }
        Ok(())
    }

    fn forward(&self, q: &Q<3>) -> Pose {
        Pose::translation(q[0], q[1], q[2])
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Q<3>) -> Result<Q<3>, NoInverse> {
        Ok(X_WF.translation.vector)
    }
}

fn set_up(bench: Bench) -> Cell {
    Cell::new(MS).robot(RobotSetup::new("bench", bench, ExactDrive::<3>::at_origin())).program(|_| Ok(()))
}

#[test]
fn limits_that_no_demand_could_be_checked_against_are_refused_by_name_before_anything_runs() {
    type Change = fn(&mut Limits<Q<3>>);
    let cases: [(Change, &str, usize); 9] = [
        (|l| l.velocity[1] = f64::NAN, "velocity limit", 1),
        (|l| l.velocity[0] = 0.0, "velocity limit", 0),
        (|l| l.velocity[2] = -1.0, "velocity limit", 2),
        (|l| l.acceleration[1] = 0.0, "acceleration limit", 1),
        (|l| l.acceleration[1] = f64::INFINITY, "acceleration limit", 1),
        (|l| l.jerk = Some(Q::<3>::new(1e3, 1e3, -1e3)), "jerk limit", 2),
        (|l| l.lower[0] = 1.0, "lower position limit", 0),
        (|l| l.lower[0] = f64::NEG_INFINITY, "lower position limit", 0),
        (|l| l.upper[2] = f64::NAN, "upper position limit", 2),
    ];
    for (change, named, number) in cases {
        let error = set_up(Bench::with(change)).run().expect_err("refused");
        let several = |errors: &[CellError]| {
            errors.iter().all(|error| {
                matches!(error, CellError::Limit { what, joint, .. } if *what == named && *joint == number)
            })
        };
        match &error {
            // A velocity limit that is wrong makes the default following error, a share of it, wrong as well.
            CellError::Several(errors) => {
                assert!(errors.iter().any(|error| several(core::slice::from_ref(error))), "{named}: {error}")
            }
            error => assert!(several(core::slice::from_ref(error)), "{named}: {error}"),
        }
        assert!(
            error.to_string().contains(&format!("robot `bench` joint {}: {named}", number + 1)),
            "{error}"
        );
    }
    let setup = RobotSetup::new("bench", Bench::new(), ExactDrive::<3>::at_origin());
    let cell = Cell::new(MS).robot(setup.following_error(Q::<3>::new(0.1, 0.0, 0.1))).program(|_| Ok(()));
    let error = cell.run().expect_err("refused");
    assert!(error.to_string().contains("joint 2: following error 0 m"), "{error}");
}

#[test]
fn all_that_is_wrong_with_a_cell_is_told_at_once() {
    let wrong = Bench::with(|limits| {
        limits.acceleration[0] = -1.0;
        limits.upper[1] = -2.0;
    });
    let setup = |name, bench| RobotSetup::new(name, bench, ExactDrive::<3>::at_origin());
    let cell = Cell::new(MS)
        .robot(setup("a", wrong))
        .robot(setup("b", Bench::with(|limits| limits.acceleration[2] = 1.0)))
        .robot(setup("b", Bench::new()))
        .sensor(mrroc::cell::SensorSetup::new("counter", crate::runtime::kit::Counting::default()).of("c"));
    let Err(CellError::Several(errors)) = cell.run() else { panic!("refused") };
    let texts: Vec<_> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 6, "{texts:?}");
    assert!(texts[0].contains("`a` joint 1: acceleration limit -1 m/s²"), "{}", texts[0]);
    assert!(texts[1].contains("`a` joint 2: lower position limit -1 m must be below"), "{}", texts[1]);
    assert!(texts[2].contains("`b` joint 3: a stop may take 1.021 s, at most 0.600 s"), "{}", texts[2]);
    assert_eq!(errors[3], CellError::Twice(mrroc::fault::Name::new("b").expect("a name")));
    assert!(matches!(&errors[4], CellError::NoSuchRobot(_, robot) if robot == "c"), "{}", texts[4]);
    assert_eq!(errors[5], CellError::NoProgram);
}

#[test]
fn a_joint_that_could_not_stop_in_time_is_refused_unless_the_cell_allows_it() {
    // T_stop = 21 ms + v / a + 2.5 a / j: at 600 ms, v / a = 0.579 s; with j = 250, 0.1 s of that is for the jerk.
    for (acceleration, jerk, stops) in [
        (1.0 / 0.578, None, true),
        (1.0 / 0.580, None, false),
        (10.0, Some(25.0 / 0.478), true),
        (10.0, Some(25.0 / 0.480), false),
    ] {
        let bench = || {
            Bench::with(|limits| {
                limits.acceleration = Q::repeat(acceleration);
                limits.jerk = jerk.map(Q::repeat);
            })
        };
        let result = set_up(bench()).run();
        assert_eq!(result.is_ok(), stops, "{acceleration} {jerk:?}: {result:?}");
        set_up(bench()).stop_time(Duration::from_secs(1)).run().expect("the cell allows it");
    }
}

#[test]
fn a_robot_s_own_stop_time_takes_the_place_of_the_cell_s() {
    // T_stop is 0.621 s.
    let slow = || Bench::with(|limits| limits.acceleration = Q::repeat(1.0 / 0.6));
    let millis = Duration::from_millis;
    let cell = |own: Duration, cell: Duration| {
        let robot = RobotSetup::new("slow", slow(), ExactDrive::<3>::at_origin()).stop_time(own);
        Cell::new(MS).stop_time(cell).robot(robot).program(|_| Ok(()))
    };
    cell(millis(622), millis(100)).run().expect("its own time is long enough");
    assert_eq!(cell(millis(622), millis(100)).stop_limit(), millis(622));
    assert_eq!(cell(millis(622), millis(100)).layout().robots[0].stop_time, millis(622));
    let why = cell(millis(620), millis(5000)).run().expect_err("its own time is too short").to_string();
    assert!(why.contains("`slow` joint 1: a stop may take 0.621 s, at most 0.620 s"), "{why}");
    assert!(why.contains("stop_ms = 621 in [robots.slow] of cell.toml"), "{why}");
    // Others keep the cell's.
    let both =
        cell(millis(700), millis(600)).robot(RobotSetup::new("other", slow(), ExactDrive::<3>::at_origin()));
    let why = both.run().expect_err("the other has no time of its own").to_string();
    assert!(why.contains("`other` joint 1") && !why.contains("`slow`"), "{why}");
}

#[test]
fn the_limits_of_the_irp6_pass_at_its_step() {
    let start = Irp6::READY;
    let setup = || RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    Cell::new(2 * MS).robot(setup()).program(|_| Ok(())).run().expect("1.5 / 7 s and 22 ms");
    // The very bound: 0.2363 s.
    let cell =
        |limit| Cell::new(2 * MS).stop_time(Duration::from_micros(limit)).robot(setup()).program(|_| Ok(()));
    cell(236_300).run().expect("T_stop is 0.23629 s");
    assert!(cell(236_200).run().is_err());
}

/// x and y together up to `speed` \[m/s\] by 5 m/s², and on.
struct Diagonal {
    x: f64,
    v: f64,
    speed: f64,
    /// When the braking power falls.
    fades_at: u64,
    fades: Arc<AtomicBool>,
}

#[generator(ecp)]
fn diagonal(c: &mut Diagonal, t: Tick) -> Step<Bench> {
    if t.step == c.fades_at {
        c.fades.store(true, Ordering::Relaxed);
    }
    c.v = (c.v + 5.0 * t.dt).min(c.speed);
    c.x += c.v * t.dt;
    Step::Next(mrroc::generator::Demand::joints(Q::<3>::new(c.x, c.x, 0.0)))
}

#[test]
fn fault_20_a_limit_that_joints_share_is_kept_by_the_stop_as_well() {
    for speed in [0.2, 0.5, 0.9] {
        let bench = Bench { sum: 0.8, ..Bench::new() };
        let (robot, trace) = traced(RobotSetup::new("bench", bench, ExactDrive::<3>::at_origin()));
        let robot = robot.program(move |ecp| {
            let never = Arc::default();
            ecp.move_robot((), Diagonal { x: 0.0, v: 0.0, speed, fades_at: u64::MAX, fades: never }).map(drop)
        });
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert_eq!((fault.kind(), fault.message()), (FaultKind::DemandOutOfRange, "x + y"), "{fault}");
        let trace = trace.borrow();
        let highest = trace.iter().map(|q| q[0] + q[1]).fold(0.0, f64::max);
        assert!(highest <= 0.8, "{speed} m/s: x + y reaches {highest}");
        // Refused no earlier than the stop needs: it was 21 ms of the speed away at the most, and two steps.
        assert!(highest >= 0.8 - 2.0 * speed * 0.023, "{speed} m/s: stops at {highest} already");
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    }
}

#[test]
fn a_stop_is_not_waited_for_longer_than_it_may_take() {
    // From step 200 on the brakes take 0.5 m/s away in 50 s: nothing of that was in the limits that were checked.
    let mut bench = Bench::new();
    bench.faded.acceleration = Q::repeat(0.01);
    (bench.limits.upper, bench.faded.upper, bench.sum) = (Q::repeat(100.0), Q::repeat(100.0), 200.0);
    let fades = Arc::clone(&bench.fades);
    let (robot, trace) = traced(RobotSetup::new("bench", bench, ExactDrive::<3>::at_origin()));
    let robot = robot.program(move |ecp| {
        let coast = Diagonal { x: 0.0, v: 0.0, speed: 0.5, fades_at: 200, fades: Arc::clone(&fades) };
        ecp.move_robot((), Throws(coast)).map(drop)
    });
    let fault = fault(Cell::new(MS).robot(robot).run());
    // The first cause is kept.
    assert_eq!(fault.message(), "enough", "{fault}");
    // v / 0.8 a of the limits that were checked, 21 ms, and 2 servo periods: 148 steps, and a few for the messages.
    let steps = trace.borrow().len();
    assert!((425..=455).contains(&steps), "{steps} steps");
}

/// Coasts, and throws a fault in step 300.
struct Throws(Diagonal);

#[generator(ecp)]
fn throws(c: &mut Throws, t: Tick) -> Result<Step<Bench>, mrroc::fault::Fault> {
    if t.step == 300 {
        return Err(mrroc::fault::Fault::thrown("enough"));
    }
    Ok(diagonal(&mut c.0, t))
}
