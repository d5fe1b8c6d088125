//! The two halves of an instruction: pairing, payloads, first causes, arrays of robots.

use mrroc::fault::{Excess, FaultKind};
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry, traced};

use crate::runtime::kit::{Along, Phase, Smooth, x};

#[generator(mp)]
fn trigger() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

#[condition(ecp)]
fn far(order: &Order<Along>) -> bool {
    order.value().x > 1.0
}

#[test]
fn a_condition_that_reads_an_order_of_another_type_is_told_so() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| ecp.serve(|ecp, _: Phase| ecp.wait_until((), far {}).map(drop)));
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), trigger {}).map(drop)
    });
    let fault = fault(cell.run());
    assert_eq!(fault.kind(), FaultKind::PayloadMismatch, "{fault}");
    assert!(fault.message().contains("`Along`") && fault.message().contains("`Phase`"), "{fault}");
}

#[test]
fn serve_inside_serve_is_refused() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| ecp.serve(|ecp, _: Phase| ecp.serve(|_, _: Phase| Ok(()))));
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), trigger {}).map(drop)
    });
    assert!(fault(cell.run()).message().contains("serve inside serve"));
}

/// Drives that trip at a tick, each with a value of its own.
struct Trips {
    drive: ExactDrive<3>,
    ticks: u64,
    at: u64,
}

impl Driver<Gantry> for Trips {
    fn period(&self) -> std::time::Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive)
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.ticks += 1;
        if self.ticks == self.at {
            return Err(DriveFault::exceeded(0, "trip", Excess::new(2.0, 1.0, "A")));
        }
        Driver::<Gantry>::tick(&mut self.drive, demanded)
    }
}

struct Three(u32);

#[generator(mp)]
fn three(c: &mut Three) -> Step<[Gantry; 3]> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next([mrroc::generator::Demand::hold(); 3])
}

/// What ends a cell of three robots, of which the ones given trip or stick in their ticks.
fn first_cause(trips: [Option<u64>; 3], sticks: [Option<u64>; 3], named: [usize; 3]) -> Fault {
    let names = ["a", "b", "c"];
    let mut cell = Cell::new(MS);
    for i in 0..3 {
        let mut drive = ExactDrive::at_origin();
        // Sticking shows only while the robot moves: read NaN instead.
        drive.sticks_at = None;
        let at = trips[i].unwrap_or(u64::MAX);
        let (robot, _) = match sticks[i] {
            Some(at) => traced(RobotSetup::new(names[i], Gantry::default(), Lost { drive, ticks: 0, at })),
            None => traced(RobotSetup::new(names[i], Gantry::default(), Trips { drive, ticks: 0, at })),
        };
        cell = cell.robot(robot);
    }
    let cell = cell.program(move |mp| {
        let mut robots = [mp.robot::<Gantry>("a")?, mp.robot::<Gantry>("b")?, mp.robot::<Gantry>("c")?];
        let mut handles: Vec<_> = robots.iter_mut().map(Some).collect();
        let list = named.map(|i| handles[i].take().expect("named once"));
        mp.move_robots(list, (), Three(200)).map(drop)
    });
    fault(cell.run())
}

/// Encoders that lose their position at a tick: a following error, less severe than a trip.
struct Lost {
    drive: ExactDrive<3>,
    ticks: u64,
    at: u64,
}

impl Driver<Gantry> for Lost {
    fn period(&self) -> std::time::Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive)
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.ticks += 1;
        let mut measured = Driver::<Gantry>::tick(&mut self.drive, demanded)?;
        if self.ticks >= self.at {
            measured.position[0] += 1.0;
        }
        Ok(measured)
    }
}

#[test]
fn of_faults_in_one_step_the_more_severe_is_the_first_cause_and_of_equals_the_first_in_the_list() {
    let who = |fault: Fault| fault.robot().expect("named").as_str().to_owned();
    // Earlier beats more severe.
    assert_eq!(who(first_cause([None, Some(51), None], [Some(50), None, None], [0, 1, 2])), "a");
    // In one step the trip beats the following error, wherever it stands.
    assert_eq!(who(first_cause([None, Some(50), None], [Some(50), None, None], [0, 1, 2])), "b");
    assert_eq!(who(first_cause([Some(50), None, None], [None, None, Some(50)], [2, 1, 0])), "a");
    // Equals: the place in the instruction's list.
    assert_eq!(who(first_cause([Some(50), None, Some(50)], [None; 3], [0, 1, 2])), "a");
    assert_eq!(who(first_cause([Some(50), None, Some(50)], [None; 3], [2, 1, 0])), "c");
}

/// Every robot of an array along x by its own distance.
struct Fan {
    t: f64,
}

#[generator(mp)]
fn fan(c: &mut Fan, t: Tick) -> Step<[Gantry; 3]> {
    if c.t >= 0.4 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(0.4);
    let u = c.t / 0.4;
    let part = u * u * (3.0 - 2.0 * u);
    Step::Next([0.1, 0.15, 0.2].map(|end| x(end * part)))
}

#[test]
fn an_array_of_robots_gives_each_its_own_demand_in_the_order_of_the_list() {
    let ((a, _), (b, _), (c, _)) = (gantry("a"), gantry("b"), gantry("c"));
    let cell = Cell::new(MS).robot(a).robot(b).robot(c).program(|mp| {
        let (mut a, mut b, mut c) =
            (mp.robot::<Gantry>("a")?, mp.robot::<Gantry>("b")?, mp.robot::<Gantry>("c")?);
        mp.move_robots([&mut c, &mut a, &mut b], (), Fan { t: 0.0 })?;
        assert_eq!([&a, &b, &c].map(|robot| robot.demanded().joints[0]), [0.15, 0.2, 0.1]);
        Ok(())
    });
    cell.run().expect("keeps the limits");
}

/// Eq. 6 with a terminal condition that holds in the first step: no demand is executed.
struct Over;

#[generator(mp)]
fn over(_c: &mut Over) -> Step<(Gantry,)> {
    Step::Done
}

struct EcpOver;

#[generator(ecp)]
fn ecp_over(_c: &mut EcpOver) -> Step<Gantry> {
    Step::Done
}

#[test]
fn a_motion_that_is_over_in_its_first_step_moves_nothing_and_the_next_ones_follow() {
    let (robot, trace) = gantry("g");
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        for _ in 0..3 {
            mp.move_robots((&mut g,), (), Over)?;
        }
        Ok(())
    });
    cell.run().expect("nothing moves");
    assert!(trace.borrow().iter().all(|q| q.norm() == 0.0));

    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.move_robot((), EcpOver)?;
        ecp.move_robot((), EcpOver)?;
        ecp.move_robot((), Smooth::to(0.2, 0.4))?;
        ecp.move_robot((), EcpOver).map(drop)
    });
    let report = Cell::new(MS).robot(robot).run().expect("keeps the limits");
    assert_eq!(trace.borrow().last().expect("recorded")[0], 0.2);
    // Motions of no steps take none.
    assert!((401..=404).contains(&report.steps), "{}", report.steps);
}

#[test]
fn programs_that_call_nothing_end_at_once() {
    let (robot, trace) = gantry("g");
    let report = Cell::new(MS).robot(robot).program(|_| Ok(())).run().expect("nothing is wrong");
    assert_eq!(report.steps, 0);
    assert!(trace.borrow().is_empty());
    let (robot, trace) = gantry("g");
    let report = Cell::new(MS).robot(robot.program(|_| Ok(()))).run().expect("nothing is wrong");
    assert!(report.steps <= 3, "{}", report.steps);
    assert!(trace.borrow().iter().all(|q| q.norm() == 0.0));
}

#[test]
fn an_ecp_that_finishes_in_the_very_step_of_the_end_finishes_once() {
    // The MP triggers for n steps; the ECP's own motion takes 400.
    for steps in 396..406 {
        let (robot, trace) = gantry("g");
        let robot = robot.program(|ecp| {
            ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.2, 0.4)).map(drop))?;
            ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.1, 0.4)).map(drop))
        });
        let cell = Cell::new(MS).robot(robot).program(move |mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            mp.move_robots((&mut g,), (), Triggering(steps))?;
            mp.move_robots((&mut g,), (), trigger {}).map(drop)
        });
        cell.run().unwrap_or_else(|error| panic!("{steps} steps: {error}"));
        assert_eq!(trace.borrow().last().expect("recorded")[0], 0.1, "{steps} steps");
    }
}

struct Triggering(u32);

#[generator(mp)]
fn triggering(c: &mut Triggering) -> Step<(Gantry,), Phase> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((Phase::Approach,))
}

#[test]
fn the_operators_speed_is_the_one_that_was_set() {
    let operator = Cell::new(MS).operator();
    for speed in [0.0, 0.1, 0.3, 1e-9, 1.0 / 3.0, 1.0] {
        operator.set_speed(speed).expect("a share");
        assert_eq!(operator.speed(), speed);
    }
}

#[test]
fn a_period_of_no_time_is_refused() {
    let (robot, _) = gantry("g");
    let result = Cell::new(std::time::Duration::ZERO).robot(robot.program(|_| Ok(()))).run();
    assert_eq!(result, Err(mrroc::cell::CellError::Step));
    let timeless = ExactDrive::new(Q::<3>::zeros(), std::time::Duration::ZERO);
    let robot = RobotSetup::new("g", Gantry::default(), timeless).program(|_| Ok(()));
    assert!(matches!(Cell::new(MS).robot(robot).run(), Err(mrroc::cell::CellError::NoServo(_))));
    let free = mrroc::sensor::VspMode::NonInteractive(std::time::Duration::ZERO);
    let sensor =
        mrroc::cell::SensorSetup::new("counter", crate::runtime::kit::Counting::default()).mode(free);
    let result = Cell::new(MS).robot(gantry("g").0.program(|_| Ok(()))).sensor(sensor).run();
    assert!(matches!(result, Err(mrroc::cell::CellError::NoPeriod(_))));
}
