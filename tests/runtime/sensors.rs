//! Virtual sensors: eq. 14 and the three modes.

use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_tests::{Gantry, MS, fault, gantry};

use crate::runtime::kit::{Counter, Counting, Offset, Smooth, Watch};

fn watched(mode: VspMode, latency: Duration, steps: usize) -> Vec<Option<(u64, u32)>> {
    let (robot, _) = gantry("g");
    let seen = Rc::new(std::cell::RefCell::new(Vec::new()));
    let keep = Rc::clone(&seen);
    let robot = robot.program(move |ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        *keep.borrow_mut() = ecp.move_robot((&mut counter,), Watch { steps, ..Watch::default() })?.seen;
        Ok(())
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(mode).latency(latency);
    Cell::new(MS).robot(robot).sensor(sensor).run().expect("nothing moves");
    seen.take()
}

#[test]
fn an_interactive_sensor_is_read_in_the_step_of_its_order() {
    let seen = watched(VspMode::Interactive, Duration::ZERO, 4);
    assert_eq!(seen, [Some((1, 0)), Some((1, 0)), Some((2, 0)), Some((3, 0))]);
}

#[test]
fn a_sensor_with_delay_never_blocks_and_serves_the_older_reading() {
    // Three steps and a half of work: every fourth step has a new reading.
    let seen = watched(VspMode::WithDelay, Duration::from_micros(3500), 14);
    assert_eq!(seen[0], None, "nothing was read yet");
    let counts: Vec<_> = seen.iter().flatten().map(|(count, _)| *count).collect();
    assert!(counts.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1), "{seen:?}");
    assert!(counts.last().expect("some") >= &2, "{seen:?}");
    // A reading is at least as old as its work took.
    assert!(seen.iter().flatten().all(|(_, age)| (4..=8).contains(age)), "{seen:?}");
}

#[test]
fn a_free_running_sensor_shows_its_latest_reading() {
    let seen = watched(VspMode::NonInteractive(Duration::from_millis(3)), Duration::ZERO, 12);
    let counts: Vec<_> = seen.iter().map(|seen| seen.expect("it ran before the first step").0).collect();
    // One aggregation in three steps, no matter how often it is looked at.
    assert_eq!(counts[11] - counts[2], 3, "{counts:?}");
    assert!(seen.iter().flatten().all(|(_, age)| *age <= 3), "{seen:?}");
}

#[test]
fn a_sensor_is_told_its_configuration_and_the_state_of_its_robot() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.move_robot((), Smooth::to(0.25, 0.5))?;
        let mut counter = ecp.sensor::<Counter>("counter")?;
        counter.configure(Offset { offset: 1000 });
        let watch = ecp.move_robot((&mut counter,), Watch { steps: 3, ..Watch::default() })?;
        assert_eq!(watch.seen[0], Some((1001, 0)));
        assert_eq!(watch.of_robot, [0.25, 0.25, 0.25]);
        Ok(())
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("g");
    Cell::new(MS).robot(robot).sensor(sensor).run().expect("nothing is wrong");
}

/// A sensor whose configuration may be one that no process can read.
struct Fussy;

impl mrroc::sensor::Sensor for Fussy {
    const KIND: &'static str = "fussy";
    type Reading = Offset;
    type Configuration = Odd;
}

/// Reads odd words only, and writes what it is told.
#[derive(Clone, Copy, Debug)]
struct Odd(u64);

impl Default for Odd {
    fn default() -> Self {
        Odd(1)
    }
}

impl mrroc::payload::Wire for Odd {
    const LEN: usize = 1;
    const LAYOUT: u64 = 1;
    fn put(&self, words: &mut [u64]) {
        words[0] = self.0;
    }
    fn get(words: &[u64]) -> Result<Self, mrroc::payload::BadWords> {
        words.first().copied().filter(|word| word % 2 == 1).map(Odd).ok_or(mrroc::payload::BadWords)
    }
}

impl mrroc::payload::Payload for Odd {
    const NAME: &'static str = "Odd";
    const TIGHT: bool = true;
}

struct Answers;

impl mrroc::sensor::VirtualSensor for Answers {
    type Kind = Fussy;
    fn aggregate(&mut self, order: &mrroc::sensor::ReadingOrder<Odd>) -> Result<Offset, mrroc::fault::Fault> {
        Ok(Offset { offset: order.configuration.0 })
    }
}

#[condition(mp)]
fn answered(v: &Reading<(Fussy,)>) -> bool {
    v.0.reading().is_some()
}

#[test]
fn fault_16_a_configuration_that_cannot_be_read_is_a_fault_and_never_the_default_one() {
    for (configuration, readable) in [(3, true), (4, false)] {
        let (robot, _) = gantry("g");
        let cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("fussy", Answers)).program(move |mp| {
            let mut fussy = mp.sensor::<Fussy>("fussy")?;
            fussy.configure(Odd(configuration));
            mp.wait_until((), (&mut fussy,), answered {}).map(drop)
        });
        match cell.run() {
            Ok(_) => assert!(readable),
            Err(mrroc::cell::CellError::Fault(fault)) => {
                assert!(!readable);
                assert_eq!(fault.kind(), FaultKind::Message, "{fault}");
                assert_eq!(fault.process().expect("named").to_string(), "vsp fussy", "{fault}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}

struct Both(u64);

#[condition(mp)]
fn both(c: &mut Both, v: &Reading<(Counter,)>) -> bool {
    c.0 = v.0.reading().map_or(0, |reading| reading.count);
    c.0 >= 20
}

#[test]
fn an_mp_reads_its_own_sensors_in_a_wait() {
    let (robot, _) = gantry("g");
    let counting = Counting::default();
    let count = Rc::clone(&counting.count);
    Cell::new(MS)
        .robot(robot)
        .sensor(SensorSetup::new("counter", counting))
        .program(|mp| {
            let (mut g, mut counter) = (mp.robot::<Gantry>("g")?, mp.sensor::<Counter>("counter")?);
            assert_eq!(mp.wait_until((), (&mut counter,), Both(0))?.0, 20);
            let _ = &mut g;
            Ok(())
        })
        .run()
        .expect("nothing is wrong");
    assert_eq!(count.get(), 20);
}

#[test]
fn fault_25_a_sensor_that_fails_ends_the_motion_that_reads_it() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 100, ..Watch::default() }).map(drop)
    });
    let sensor = SensorSetup::new("counter", Counting { fails_at: Some(10), ..Counting::default() }).of("g");
    let fault = fault(Cell::new(MS).robot(robot).sensor(sensor).run());
    assert_eq!(fault.message(), "the cable is cut");
    assert_eq!(fault.process().expect("named").to_string(), "vsp counter");
}

#[test]
fn fault_25_a_reading_older_than_twenty_steps_is_not_moved_by() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 1000, ..Watch::default() }).map(drop)
    });
    let free = VspMode::NonInteractive(Duration::from_millis(100));
    let sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(free);
    let fault = fault(Cell::new(MS).robot(robot).sensor(sensor).run());
    assert_eq!(fault.kind(), FaultKind::SensorStale);
    assert_eq!(fault.excess().expect("says how old").actual, 21.0);
    assert_eq!(fault.message(), "21 ms, at most 20 ms");
}

#[test]
fn the_first_order_of_the_mp_has_the_state_of_the_sensors_robot_too() {
    let (robot, _) = gantry("g");
    let sensor = SensorSetup::new("state", OfRobot).of("g");
    let cell = Cell::new(MS).robot(robot).sensor(sensor).program(|mp| {
        let mut state = mp.sensor::<Counter>("state")?;
        // In a Wait for no robot at all, as the first instruction.
        mp.wait_at_most((), (&mut state,), known {}, 0).map(drop)
    });
    cell.run().expect("the sensor knows its robot");
}

/// Reads 1 when it was told the state of its robot, and fails otherwise.
struct OfRobot;

impl mrroc::sensor::VirtualSensor for OfRobot {
    type Kind = Counter;
    fn aggregate(
        &mut self,
        order: &mrroc::sensor::ReadingOrder<Offset>,
    ) -> Result<crate::runtime::kit::Count, mrroc::fault::Fault> {
        order
            .robot
            .map(|_| crate::runtime::kit::Count { count: 1, x: 0.0, step: order.step })
            .ok_or_else(|| mrroc::fault::Fault::thrown("no state"))
    }
}

#[condition(mp)]
fn known(v: &Reading<(Counter,)>) -> bool {
    v.0.reading().is_some_and(|reading| reading.count == 1)
}

#[test]
fn fault_25_a_reading_may_be_as_old_as_its_sensor_says() {
    let run = |stale_after: Option<u64>| {
        let (robot, _) = gantry("g");
        let seen = Rc::new(std::cell::RefCell::new(Vec::new()));
        let keep = Rc::clone(&seen);
        let robot = robot.program(move |ecp| {
            let mut counter = ecp.sensor::<Counter>("counter")?;
            *keep.borrow_mut() =
                ecp.move_robot((&mut counter,), Watch { steps: 300, ..Watch::default() })?.seen;
            Ok(())
        });
        let mut sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(VspMode::WithDelay);
        sensor = sensor.latency(Duration::from_micros(30_500));
        if let Some(age) = stale_after {
            sensor = sensor.stale_after(Duration::from_millis(age));
        }
        Cell::new(MS).robot(robot).sensor(sensor).run().map(|report| (report, seen.take()))
    };
    let told = |stale_after| fault(run(stale_after).map(|(report, _)| report));
    let (default, short) = (told(None), told(Some(60)));
    assert_eq!(default.kind(), FaultKind::SensorStale);
    assert_eq!((default.excess().expect("told").actual, default.excess().expect("told").limit), (21.0, 20.0));
    assert_eq!((short.excess().expect("told").actual, short.excess().expect("told").limit), (61.0, 60.0));
    // A reading that is ordered in step k is there in step k + 31, in which the next one is ordered; that is there in step
    // k + 62, so that the first one is used last when it is 61 steps old.
    let (_, seen) = run(Some(61)).expect("no reading is older");
    let oldest = seen.iter().flatten().map(|(_, age)| *age).max();
    assert_eq!(oldest, Some(61), "{seen:?}");
}

#[test]
fn a_sensor_that_is_asked_in_every_third_step_serves_its_last_reading_between() {
    for mode in [VspMode::Interactive, VspMode::WithDelay] {
        let (robot, _) = gantry("g");
        let counting = Counting::default();
        let count = Rc::clone(&counting.count);
        let seen = Rc::new(std::cell::RefCell::new(Vec::new()));
        let keep = Rc::clone(&seen);
        let robot = robot.program(move |ecp| {
            let mut counter = ecp.sensor::<Counter>("counter")?;
            *keep.borrow_mut() =
                ecp.move_robot((&mut counter,), Watch { steps: 30, ..Watch::default() })?.seen;
            Ok(())
        });
        let sensor = SensorSetup::new("counter", counting).of("g").mode(mode).every(3);
        Cell::new(MS).robot(robot).sensor(sensor).run().expect("nothing moves");
        let seen = seen.take();
        // The step function is called 31 times, twice of it in the first step: 30 steps, of which each third has a new reading.
        assert_eq!(count.get(), 10, "{mode:?}");
        let ages: Vec<_> = seen.iter().skip(3).flatten().map(|(_, age)| *age).collect();
        assert!(ages.iter().all(|age| *age < 3), "{mode:?}: {ages:?}");
        assert!(ages.windows(3).all(|three| three.iter().sum::<u32>() == 3), "{mode:?}: {ages:?}");
    }
}

#[test]
fn a_free_running_sensor_or_one_whose_readings_would_be_too_old_cannot_be_asked_seldom() {
    let free = VspMode::NonInteractive(Duration::from_millis(5));
    for (mode, every, stale) in [(free, 2, 20), (VspMode::Interactive, 21, 20), (VspMode::Interactive, 0, 20)]
    {
        let (robot, _) = gantry("g");
        let sensor = SensorSetup::new("counter", Counting::default()).mode(mode).every(every);
        let sensor = sensor.stale_after(Duration::from_millis(stale));
        let refused = Cell::new(MS).robot(robot.program(|_| Ok(()))).sensor(sensor).run();
        let told = refused.expect_err("refused").to_string();
        assert!(told.contains(&format!("is asked every {every} steps")), "{told}");
    }
}

/// A camera over a belt: the belt's encoder says where things are, and an arm takes them.
#[test]
fn an_arm_reads_a_sensor_of_a_belt_which_knows_where_the_belt_is() {
    for mode in [VspMode::Interactive, VspMode::NonInteractive(Duration::from_millis(1))] {
        let ((belt, trace), (arm, _)) = (gantry("belt"), gantry("arm"));
        let belt = belt.program(|ecp| ecp.move_robot((), Smooth::to(0.2, 0.5)).map(drop));
        let seen = Rc::new(std::cell::RefCell::new(Vec::new()));
        let keep = Rc::clone(&seen);
        let arm = arm.program(move |ecp| {
            let mut camera = ecp.sensor::<Counter>("camera")?;
            *keep.borrow_mut() =
                ecp.move_robot((&mut camera,), Watch { steps: 400, ..Watch::default() })?.of_robot;
            Ok(())
        });
        let camera = SensorSetup::new("camera", Counting::default()).of("belt").readers(["arm"]).mode(mode);
        Cell::new(MS).robot(belt).robot(arm).sensor(camera).run().expect("both keep the limits");
        let (seen, trace) = (seen.take(), trace.borrow());
        // Each reading is of a place where the belt was, one step after the last one, and the newest that was measured: the
        // drives are two steps behind the demands, and a reading is of the step before.
        let moved: Vec<_> = seen.iter().copied().filter(|x| *x > 0.01).collect();
        assert!(moved.len() > 200, "{}", moved.len());
        let place = |x: f64| trace.iter().position(|q| q[0] == x).expect("the belt was there");
        let places: Vec<_> = moved.iter().map(|x| place(*x)).collect();
        assert!(places.windows(2).all(|pair| pair[1] == pair[0] + 1), "{mode:?}: {places:?}");
    }
}

#[test]
fn a_sensor_of_a_belt_is_told_to_nobody_else_than_its_readers() {
    let ((belt, _), (arm, _)) = (gantry("belt"), gantry("arm"));
    let belt = belt.program(|ecp| ecp.sensor::<Counter>("camera").map(drop));
    let camera = SensorSetup::new("camera", Counting::default()).of("belt").readers(["arm"]);
    let fault = fault(Cell::new(MS).robot(belt).robot(arm).sensor(camera).run());
    assert!(fault.message().contains("readers = [\"belt\"]"), "{fault}");
    let (arm, _) = gantry("arm");
    let camera = SensorSetup::new("camera", Counting::default()).readers(["amr"]);
    let refused = Cell::new(MS).robot(arm.program(|_| Ok(()))).sensor(camera).run().expect_err("a slip");
    assert!(refused.to_string().contains("shall be read by robot `amr`"), "{refused}");
}
