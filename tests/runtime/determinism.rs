//! The memory link: the same demands to the bit, every time.

use std::time::Duration;

use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_tests::{ExactDrive, Gantry, MS, Q, gantry, traced};

use crate::runtime::kit::{Counter, Counting, Phase, Smooth, Twin, Watch};

#[generator(mp)]
fn told() -> Always<(Gantry, Gantry), Phase> {
    Always((Phase::Approach, Phase::Retreat))
}

#[generator(mp)]
fn told_left() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

fn traces(quarter: bool) -> (u64, Vec<Vec<Q<3>>>) {
    let period = if quarter { Duration::from_micros(250) } else { MS };
    let drive = ExactDrive::new(nalgebra::Vector3::zeros(), period);
    let (left, left_trace) = traced(RobotSetup::new("left", Gantry::default(), drive));
    let (right, right_trace) = gantry("right");
    let program = |end: f64, watches: bool| {
        move |ecp: &mut mrroc::program::Ecp<Gantry>| {
            let mut counter = if watches { Some(ecp.sensor::<Counter>("counter")?) } else { None };
            ecp.serve(|ecp, _: Phase| {
                ecp.move_robot((), Smooth::to(end, 0.5))?;
                match &mut counter {
                    Some(counter) => {
                        ecp.move_robot((counter,), Watch { steps: 40, ..Watch::default() }).map(drop)
                    }
                    None => Ok(()),
                }
            })?;
            if watches {
                ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.0, 0.7)).map(drop))
            } else {
                Ok(())
            }
        }
    };
    let report = Cell::new(MS)
        .robot(left.program(program(0.3, true)))
        .robot(right.program(program(-0.2, false)))
        .sensor(
            SensorSetup::new("counter", Counting::default())
                .of("left")
                .mode(VspMode::WithDelay)
                .latency(Duration::from_micros(2700)),
        )
        .on_step(|step, operator| match step {
            77 => operator.set_speed(0.7).expect("a share"),
            150 | 900 => operator.suspend(),
            500 | 1100 => operator.resume(),
            _ => {}
        })
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), told())?;
            // The other robot, whose program is over, is not named.
            mp.move_robots((&mut left,), (), told_left())?;
            Ok(())
        })
        .run()
        .expect("keeps the limits");
    (report.steps, vec![left_trace.take(), right_trace.take()])
}

#[test]
fn a_run_is_the_same_to_the_bit_every_time() {
    for quarter in [false, true] {
        let (steps, first) = traces(quarter);
        let bits = |traces: &[Vec<Q<3>>]| -> Vec<u64> {
            traces.iter().flatten().flat_map(|q| q.iter().map(|x| x.to_bits()).collect::<Vec<_>>()).collect()
        };
        for _ in 0..3 {
            let (again_steps, again) = traces(quarter);
            assert_eq!(steps, again_steps);
            assert!(bits(&first) == bits(&again), "the traces differ");
        }
    }
}

#[test]
fn a_robot_that_an_instruction_does_not_name_holds_and_is_not_missed() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let cell = Cell::new(MS).robot(left).robot(right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.2, 0.4)))?;
        // Longer than the time of any watchdog.
        mp.move_robots((&mut right,), (), One(Smooth::to(0.0, 0.5), 0.0))?;
        assert!((right.demanded().joints[0] - 0.1).abs() < 1e-15);
        let before = (left.demanded().joints[0], right.demanded().joints[0]);
        mp.move_robots([&mut right, &mut left], (), Nothing(3))?;
        assert_eq!((left.demanded().joints[0], right.demanded().joints[0]), before);
        Ok(())
    });
    cell.run().expect("keeps the limits");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    assert!(left[405..].iter().all(|q| q[0] == 0.2));
    assert!((right.last().expect("recorded")[0] - 0.1).abs() < 1e-15);
}

/// From where the robot is to 0.1 m.
struct One(Smooth, f64);

#[generator(mp, first = from_here)]
fn one(c: &mut One, t: mrroc::generator::Tick) -> mrroc::generator::Step<(Gantry,)> {
    if c.0.duration <= 0.0 {
        return mrroc::generator::Step::Done;
    }
    c.0.duration = (c.0.duration - t.dt).max(0.0);
    let u = 1.0 - c.0.duration / 0.5;
    mrroc::generator::Step::Next((crate::runtime::kit::x(c.1 + (0.1 - c.1) * u * u * (3.0 - 2.0 * u)),))
}

fn from_here(
    c: &mut One,
    e: &mrroc::robot::State<(Gantry,)>,
    t: mrroc::generator::Tick,
) -> mrroc::generator::Step<(Gantry,)> {
    c.1 = e.0.demanded().joints[0];
    one(c, t)
}

struct Nothing(u32);

#[generator(mp)]
fn nothing(c: &mut Nothing) -> mrroc::generator::Step<[Gantry; 2]> {
    if c.0 == 0 {
        return mrroc::generator::Step::Done;
    }
    c.0 -= 1;
    mrroc::generator::Step::Next([mrroc::generator::Demand::hold(); 2])
}
