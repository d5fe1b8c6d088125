//! Late steps: they are skipped and never executed afterwards, and the demands stay within the limits.

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_tests::{ExactDrive, Gantry, MS, fault, gantry, peaks, traced};

use crate::runtime::kit::{Counter, Counting, Smooth, Watch, x};

/// Moves along x by a smoothstep whose steps wait for a sensor.
struct Looking {
    t: f64,
    start: f64,
    ticks: Vec<Tick>,
}

impl Looking {
    fn new() -> Looking {
        Looking { t: 0.0, start: 0.0, ticks: Vec::new() }
    }
}

#[generator(ecp, first = look_first)]
fn looking(c: &mut Looking, _v: &Reading<(Counter,)>, t: Tick) -> Step<Gantry> {
    if c.t >= 1.0 {
        return Step::Done;
    }
    c.ticks.push(t);
    c.t = (c.t + t.dt).min(1.0);
    Step::Next(x(c.start + 0.1 * c.t * c.t * (3.0 - 2.0 * c.t)))
}

fn look_first(c: &mut Looking, e: &State<Gantry>, v: &Reading<(Counter,)>, t: Tick) -> Step<Gantry> {
    c.start = e.demanded().joints[0];
    looking(c, v, t)
}

#[test]
fn fault_11_a_sensor_slower_than_a_step_slows_the_steps_and_not_the_motion() {
    // A demand after m lost ones takes (m + 1)(m + 2) / 2 of the path's acceleration, 0.6 m/s²: 6 for m = 3.
    for latency in [300, 999, 1000, 1001, 1400, 1500, 1600, 2000, 2500, 3300] {
        let ((robot, trace), latency) = (gantry("g"), Duration::from_micros(latency));
        let robot = robot.program(move |ecp| {
            let mut counter = ecp.sensor::<Counter>("counter")?;
            let looking = ecp.move_robot((&mut counter,), Looking::new())?;
            // Path time passes as fast as real time: the periods that were skipped count.
            for tick in &looking.ticks {
                assert_eq!(tick.dt, tick.duration);
            }
            Ok(())
        });
        let sensor = SensorSetup::new("counter", Counting::default()).of("g").latency(latency);
        let report = Cell::new(MS).robot(robot).sensor(sensor).run();
        let report = report.unwrap_or_else(|error| panic!("latency {latency:?}: {error}"));
        let trace = trace.borrow();
        let (_, a) = peaks(&trace, 1e-3);
        assert!(a <= 10.0 + 1e-6, "latency {latency:?}: {a} m/s²");
        // A late end is bridged like any late demand: the robot may be off by what such a step moves, a T².
        let end = trace.last().expect("recorded")[0];
        assert!((end - 0.1).abs() < 1e-5, "latency {latency:?}: {end}");
        assert!((1000..1020).contains(&report.steps), "latency {latency:?}: {} steps", report.steps);
    }
}

#[test]
fn a_sensor_slower_than_the_timeout_of_its_ecp_is_named_itself() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 10, ..Watch::default() }).map(drop)
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("g").latency(Duration::from_millis(40));
    let fault = fault(Cell::new(MS).robot(robot).sensor(sensor).run());
    assert_eq!(fault.kind(), FaultKind::PeerLost);
    assert_eq!(fault.process().expect("named").to_string(), "vsp counter", "{fault}");
}

#[test]
fn a_servo_period_of_several_steps_and_of_a_part_of_one_reach_the_same_end() {
    for micros in [125, 250, 500, 1000, 2000, 4000] {
        let drive = ExactDrive::new(nalgebra::Vector3::zeros(), Duration::from_micros(micros));
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::default(), drive));
        let robot = robot.program(|ecp| {
            ecp.move_robot((), Smooth::to(0.3, 0.5))?;
            ecp.wait_until((), Soon(10)).map(drop)
        });
        Cell::new(MS).robot(robot).run().unwrap_or_else(|error| panic!("servo {micros} us: {error}"));
        let trace = trace.borrow();
        assert_eq!(trace.last().expect("recorded")[0], 0.3, "servo {micros} us");
    }
}

struct Soon(u32);

#[mrroc::condition(ecp)]
fn soon(c: &mut Soon) -> bool {
    c.0 -= 1;
    c.0 == 0
}

/// A sensor that answers with its configuration.
struct Echo;

impl Sensor for Echo {
    const KIND: &'static str = "echo";
    type Reading = Told;
    type Configuration = Told;
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
struct Told {
    value: u64,
}

struct Echoing;

impl VirtualSensor for Echoing {
    type Kind = Echo;
    fn aggregate(&mut self, order: &ReadingOrder<Told>) -> Result<Told, Fault> {
        Ok(order.configuration)
    }
}

struct Heard {
    values: Vec<u64>,
}

#[generator(mp)]
fn heard(c: &mut Heard, v: &Reading<(Echo,)>) -> Step<(Gantry,), crate::runtime::kit::Phase> {
    c.values.extend(v.0.reading().map(|told| told.value));
    if c.values.len() >= 10 { Step::Done } else { Step::Next((crate::runtime::kit::Phase::Approach,)) }
}

struct HeardByEcp {
    values: Vec<u64>,
}

#[generator(ecp)]
fn heard_by_ecp(c: &mut HeardByEcp, v: &Reading<(Echo,)>) -> Step<Gantry> {
    c.values.extend(v.0.reading().map(|told| told.value));
    Step::Next(mrroc::generator::Demand::hold())
}

#[test]
fn an_mp_and_an_ecp_that_configure_one_sensor_differently_each_get_their_own_reading() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut echo = ecp.sensor::<Echo>("echo")?;
        echo.configure(Told { value: 2 });
        ecp.serve(|ecp, _: crate::runtime::kit::Phase| {
            let heard = ecp.move_robot((&mut echo,), HeardByEcp { values: Vec::new() })?;
            assert!(
                heard.values.len() > 5 && heard.values.iter().all(|value| *value == 2),
                "{:?}",
                heard.values
            );
            Ok(())
        })
    });
    let cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("echo", Echoing).of("g"));
    let cell = cell.program(|mp| {
        let (mut g, mut echo) = (mp.robot::<Gantry>("g")?, mp.sensor::<Echo>("echo")?);
        echo.configure(Told { value: 1 });
        let heard = mp.move_robots((&mut g,), (&mut echo,), Heard { values: Vec::new() })?;
        assert!(heard.values.iter().all(|value| *value == 1), "{:?}", heard.values);
        Ok(())
    });
    cell.run().expect("nothing is wrong");
}

#[test]
fn a_free_running_sensor_that_an_mp_and_an_ecp_configure_differently_gives_each_its_own_reading() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut echo = ecp.sensor::<Echo>("echo")?;
        echo.configure(Told { value: 2 });
        ecp.serve(|ecp, _: crate::runtime::kit::Phase| {
            let heard = ecp.move_robot((&mut echo,), HeardByEcp { values: Vec::new() })?.values;
            // Of the default configuration until the first order has come, and then of its own.
            let own = heard.iter().position(|value| *value == 2).expect("its own");
            assert!(own <= 2 && heard[..own].iter().all(|value| *value == 0), "{heard:?}");
            assert!(heard.len() > 5 && heard[own..].iter().all(|value| *value == 2), "{heard:?}");
            Ok(())
        })
    });
    let free = VspMode::NonInteractive(Duration::from_millis(1));
    let cell = Cell::new(MS).robot(robot).sensor(SensorSetup::new("echo", Echoing).of("g").mode(free));
    let cell = cell.program(|mp| {
        let (mut g, mut echo) = (mp.robot::<Gantry>("g")?, mp.sensor::<Echo>("echo")?);
        echo.configure(Told { value: 1 });
        let heard = mp.move_robots((&mut g,), (&mut echo,), Heard { values: Vec::new() })?.values;
        let own = heard.iter().position(|value| *value == 1).expect("its own");
        assert!(own <= 2 && heard[..own].iter().all(|value| *value == 0), "{heard:?}");
        assert!(heard[own..].iter().all(|value| *value == 1), "{heard:?}");
        Ok(())
    });
    cell.run().expect("nothing is wrong");
}

#[test]
fn a_sensor_with_delay_may_be_read_again_after_a_pause() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 30, ..Watch::default() })?;
        ecp.move_robot((), Smooth::to(0.1, 0.3))?;
        let watch = ecp.move_robot((&mut counter,), Watch { steps: 30, ..Watch::default() })?;
        // Until the first new reading comes, the old one shows its age.
        let ages: Vec<_> = watch.seen.iter().flatten().map(|(_, age)| *age).collect();
        assert!(ages.iter().all(|age| (4..=8).contains(age) || *age >= 300), "{ages:?}");
        assert!(*ages.last().expect("read") <= 8, "{ages:?}");
        Ok(())
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(VspMode::WithDelay);
    let cell = Cell::new(MS).robot(robot).sensor(sensor.latency(Duration::from_micros(3500)));
    cell.run().expect("the sensor is as fast as before");
}

#[test]
fn fault_04_a_sensor_with_delay_that_never_answers_is_too_old_after_twenty_steps() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        ecp.move_robot((&mut counter,), Watch { steps: 1000, ..Watch::default() }).map(drop)
    });
    let sensor = SensorSetup::new("counter", Counting::default()).of("g").mode(VspMode::WithDelay);
    let cell = Cell::new(MS).robot(robot).sensor(sensor.latency(Duration::from_secs(3600)));
    let fault = fault(cell.run());
    assert_eq!(fault.kind(), FaultKind::SensorStale);
    assert_eq!(fault.excess().expect("says how old").actual, 21.0);
}
