//! Wait, eq. 4 of the paper.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, fault, gantry};

use crate::runtime::kit::{Counter, Counting, Phase, Smooth};

struct CountTo(u64);

#[condition(ecp)]
fn count_to(c: &mut CountTo, v: &Reading<(Counter,)>) -> bool {
    v.0.reading().is_some_and(|reading| reading.count >= c.0)
}

#[condition(ecp)]
fn arrived(e: &State<Gantry>) -> bool {
    (e.demanded().joints[0] - 0.2).abs() < 1e-12
}

#[condition(mp)]
fn both_stand(e: &State<(Gantry, Gantry)>) -> bool {
    e.0.measured().velocity.norm() < 1e-9 && e.1.measured().velocity.norm() < 1e-9
}

struct Never;

#[condition(mp)]
fn never(_c: &mut Never) -> bool {
    false
}

struct Broken;

#[condition(ecp)]
fn broken(_c: &mut Broken) -> Result<bool, Fault> {
    Err(Fault::thrown("no part in the feeder"))
}

#[test]
fn a_wait_reads_once_in_every_step_until_the_condition_holds_and_moves_nothing() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.move_robot((), Smooth::to(0.2, 0.4))?;
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.wait_until((&mut counter,), CountTo(50))?;
        assert_eq!(counter.reading().expect("read").count, 50);
        ecp.wait_until((), arrived {})?;
        Ok(())
    });
    let cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("counter", Counting::default()).of("g"));
    let report = cell.run().expect("nothing is wrong");
    assert!((449..=455).contains(&report.steps), "{}", report.steps);
    assert!(trace.borrow()[402..].iter().all(|q| q[0] == 0.2));
}

#[test]
fn a_wait_of_the_mp_sees_fresh_states_of_its_robots() {
    let ((left, _), (right, _)) = (gantry("left"), gantry("right"));
    Cell::new(MS)
        .robot(left)
        .robot(right)
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.wait_until((&mut left, &mut right), (), both_stand {})?;
            Ok(())
        })
        .run()
        .expect("nothing is wrong");
}

#[test]
fn a_wait_with_a_time_out_ends_with_a_fault_that_the_program_may_survive() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        let before = mp.step();
        let fault = mp.wait_at_most((&mut g,), (), Never, 100).err().expect("never met");
        assert_eq!(fault.kind(), FaultKind::TimedOut);
        assert_eq!(mp.step() - before, 101);
        mp.wait_until((), (), Soon(3))?;
        Ok(())
    });
    cell.run().expect("the time-out was handled");
}

struct Soon(u32);

#[condition(mp)]
fn soon(c: &mut Soon) -> bool {
    c.0 -= 1;
    c.0 == 0
}

#[test]
fn a_suspended_wait_goes_on_after_resume_and_an_aborted_one_ends() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS)
        .robot(robot)
        .on_step(|step, operator| match step {
            10 => operator.suspend(),
            200 => operator.resume(),
            400 => operator.abort(),
            _ => {}
        })
        .program(|mp| {
            mp.wait_until((), (), Soon(50))?;
            assert!((239..=241).contains(&mp.step()), "{}", mp.step());
            let fault = mp.wait_until((), (), Never).err().expect("aborted");
            assert_eq!((fault.kind(), mp.step()), (FaultKind::Aborted, 400));
            // An abort is not latched: the program may go on.
            mp.wait_until((), (), Soon(2))?;
            Ok(())
        });
    cell.run().expect("the abort was handled");
}

#[test]
fn a_fault_that_a_condition_throws_ends_the_wait() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| ecp.wait_until((), Broken).map(drop));
    let fault = fault(Cell::new(MS).robot(robot).run());
    assert_eq!((fault.kind(), fault.message()), (FaultKind::Program, "no part in the feeder"));
}

#[generator(mp)]
fn approach() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

#[condition(ecp)]
fn told_to_approach(order: &mrroc::payload::Order<Phase>) -> bool {
    order.value() == Phase::Approach
}

#[test]
fn a_condition_of_an_ecp_reads_the_order() {
    let (robot, _) = gantry("g");
    let robot =
        robot.program(|ecp| ecp.serve(|ecp, _: Phase| ecp.wait_until((), told_to_approach {}).map(drop)));
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), approach()).map(drop)
    });
    cell.run().expect("the condition holds at once");
}

struct Look(u64);

#[condition(ecp)]
fn look(c: &mut Look) -> bool {
    c.0 -= 1;
    c.0 == 0
}

#[test]
fn at_speed_zero_a_wait_goes_on_in_the_mp_and_in_an_ecp_and_only_suspend_pauses_it() {
    // 50 looks from step 2 on; suspended for 100 steps, 50 looks take 150.
    for (suspends, steps) in [(false, 45..60), (true, 145..160)] {
        let operate = move |step: u64, operator: &mrroc::operator::Operator| match step {
            1 => operator.set_speed(0.0).expect("a share"),
            20 if suspends => operator.suspend(),
            120 if suspends => operator.resume(),
            _ => {}
        };
        let (robot, _) = gantry("g");
        let by_mp = Cell::new(MS)
            .robot(robot)
            .on_step(operate)
            .program(|mp| mp.wait_until((), (), Soon(50)).map(drop))
            .run()
            .expect("waits");
        assert!(steps.contains(&by_mp.steps), "mp, suspended {suspends}: {} steps", by_mp.steps);
        let (robot, _) = gantry("g");
        let robot = robot.program(|ecp| ecp.wait_until((), Look(50)).map(drop));
        let by_ecp = Cell::new(MS).robot(robot).on_step(operate).run().expect("waits");
        assert!(steps.contains(&by_ecp.steps), "ecp, suspended {suspends}: {} steps", by_ecp.steps);
    }
}
