//! What the driver of a robot must keep.

use core::f64::consts::TAU;

use mrroc::robot::{DriveFault, Driver, JointVector, Measured, Robot};

use super::{Violation, ensure};

/// Largest error at rest, in seconds at the joint's top speed.
const AT_REST: f64 = 1e-3;

/// Ticks within which a braked robot stands.
const BRAKING: usize = 500;

fn period<R: Robot>(driver: &impl Driver<R>) -> f64 {
    driver.period().as_secs_f64()
}

/// What the encoders read.
pub(super) fn read<R: Robot>(driver: &impl Driver<R>) -> Result<Measured<R::Joints>, Violation> {
    driver.measured().map_err(|fault| Violation(format!("it cannot be read: {fault}")))
}

/// Whether a tick reports the same cause again; its value may be NaN, which is not equal to itself.
fn keeps<J>(outcome: Result<Measured<J>, DriveFault>, fault: &DriveFault) -> bool {
    outcome.is_err_and(|again| (again.joint(), again.what()) == (fault.joint(), fault.what()))
}

/// The largest of `a - b`, as shares of the joints' speed limits.
fn off<R: Robot>(robot: &R, a: &R::Joints, b: &R::Joints) -> f64 {
    (0..R::Joints::LEN)
        .fold(0.0, |worst: f64, i| worst.max(((a[i] - b[i]) / robot.limits().velocity[i]).abs()))
}

/// The period is whole microseconds and fits a step of 1 to 20 ms; the driver rests where it was put and stays there.
///
/// # Errors
/// The first [`Violation`].
pub fn measures_at_rest<R: Robot>(
    robot: &R,
    mut driver: impl Driver<R>,
    start: &R::Joints,
) -> Result<(), Violation> {
    let micros = driver.period().as_nanos();
    ensure(micros > 0 && micros <= 20_000_000 && micros % 1_000 == 0, || format!("a period of {micros} ns"))?;
    let check = |position: &R::Joints, velocity: &R::Joints| {
        let error = off(robot, position, start);
        ensure(error < AT_REST, || format!("at rest it measures {position:?} instead of {start:?}"))?;
        ensure(off(robot, velocity, &R::Joints::zeros()) < AT_REST, || {
            format!("at rest it moves at {velocity:?}")
        })
    };
    let measured = read(&driver)?;
    check(&measured.position, &measured.velocity)?;
    for _ in 0..2_000 {
        let measured = driver.tick(start).map_err(|fault| Violation(format!("holding: {fault}")))?;
        check(&measured.position, &measured.velocity)?;
    }
    Ok(())
}

/// Every joint in turn goes and comes back by a cosine at up to a quarter of its speed and acceleration limits.
///
/// # Errors
/// The first [`Violation`].
pub fn follows_slowly<R: Robot, D: Driver<R>>(
    robot: &R,
    make: impl Fn() -> D,
    start: &R::Joints,
) -> Result<(), Violation> {
    let limits = robot.limits();
    for joint in 0..R::Joints::LEN {
        let mut driver = make();
        let period = period(&driver);
        // Amplitude a and frequency w with a w = velocity / 4 and a w^2 = acceleration / 4, within a tenth of the range.
        let v = 0.25 * limits.velocity[joint];
        let a = 0.25 * limits.acceleration[joint];
        let room = (limits.upper[joint] - start[joint]).min(start[joint] - limits.lower[joint]);
        let amplitude = (v * v / a).min(0.1 * room);
        let frequency = (a / amplitude).sqrt().min(v / amplitude);
        let ticks = (TAU / (frequency * period)).ceil() as usize;
        let mut worst = 0.0_f64;
        let mut demanded = *start;
        for k in 1..=ticks {
            let phase = (TAU * k as f64 / ticks as f64).cos();
            demanded[joint] = start[joint] + 0.5 * amplitude * (1.0 - phase);
            let measured = driver
                .tick(&demanded)
                .map_err(|fault| Violation(format!("joint {joint}, tick {k}: {fault}")))?;
            worst = worst.max((measured.position[joint] - demanded[joint]).abs() / limits.velocity[joint]);
        }
        for _ in 0..500 {
            driver
                .tick(start)
                .map_err(|fault| Violation(format!("joint {joint}, at rest again: {fault}")))?;
        }
        let rest = off(robot, &read(&driver)?.position, start);
        println!(
            "{} joint {joint}: largest error {:.2} ms of its top speed, at rest {:.3} ms",
            R::KIND,
            worst * 1e3,
            rest * 1e3
        );
        ensure(worst < 5e-3 && rest < AT_REST, || {
            format!("joint {joint} lags by {worst} s of its top speed, at rest by {rest} s")
        })?;
    }
    Ok(())
}

/// NaN, infinity, a jump and a place far outside the limits are refused at once, with the joint's number, and the cause is
/// kept.
///
/// # Errors
/// The first [`Violation`].
pub fn refuses<R: Robot, D: Driver<R>>(
    robot: &R,
    make: impl Fn() -> D,
    start: &R::Joints,
) -> Result<(), Violation> {
    let limits = robot.limits();
    for joint in 0..R::Joints::LEN {
        let range = limits.upper[joint] - limits.lower[joint];
        for value in
            [f64::NAN, f64::INFINITY, limits.upper[joint] + 2.0 * range, limits.lower[joint] - 2.0 * range]
        {
            let mut driver = make();
            let mut demanded = *start;
            demanded[joint] = value;
            let before = read(&driver)?;
            let Err(fault) = driver.tick(&demanded) else {
                return Err(Violation(format!("joint {joint} takes the demand {value}")));
            };
            let named = fault.joint().unwrap_or(0);
            ensure(named < R::Joints::LEN, || format!("the fault names joint {named}"))?;
            ensure(keeps(driver.tick(start), &fault), || format!("the cause {fault} is not kept"))?;
            let moved = off(robot, &read(&driver)?.position, &before.position);
            ensure(moved < AT_REST, || {
                format!("joint {joint}: {value} moved it by {moved} s of its top speed")
            })?;
        }
    }
    Ok(())
}

/// A moving robot whose demand is refused stands within a second, and reports the first cause all the time.
///
/// # Errors
/// The first [`Violation`].
pub fn comes_to_rest<R: Robot>(
    robot: &R,
    mut driver: impl Driver<R>,
    start: &R::Joints,
) -> Result<(), Violation> {
    let limits = robot.limits();
    let period = period(&driver);
    let mut demanded = *start;
    for k in 1..=100 {
        for i in 0..R::Joints::LEN {
            // Up to a fifth of the speed within 100 ticks, with constant acceleration.
            let speed = 0.2 * limits.velocity[i].min(100.0 * period * limits.acceleration[i]);
            let sign = if limits.upper[i] - start[i] > start[i] - limits.lower[i] { 1.0 } else { -1.0 };
            demanded[i] = start[i] + sign * speed * period * f64::from(k * k) / 200.0;
        }
        driver.tick(&demanded).map_err(|fault| Violation(format!("speeding up, tick {k}: {fault}")))?;
    }
    let moving = read(&driver)?;
    ensure(off(robot, &moving.velocity, &R::Joints::zeros()) > 1e-3, || {
        format!("it moves at {:?}", moving.velocity)
    })?;
    let broken = R::Joints::from_joints(|_| f64::NAN);
    let Err(fault) = driver.tick(&broken) else {
        return Err(Violation("a demand that is NaN is taken".into()));
    };
    for _ in 0..BRAKING {
        ensure(keeps(driver.tick(&demanded), &fault), || format!("the cause {fault} is not kept"))?;
    }
    let rest = read(&driver)?;
    driver.tick(&demanded).err();
    let again = read(&driver)?;
    ensure(again.position == rest.position, || "it still moves after braking".into())
}

/// Two drivers that are given the same demands measure the same, to the bit.
///
/// # Errors
/// The first [`Violation`].
pub fn is_deterministic<R: Robot, D: Driver<R>>(
    robot: &R,
    make: impl Fn() -> D,
    start: &R::Joints,
) -> Result<(), Violation> {
    let mut first = make();
    let mut second = make();
    let limits = robot.limits();
    let period = period(&first);
    for k in 0..1_000_u32 {
        let rise = (f64::from(k) * period).powi(2).min(0.01);
        let demanded = R::Joints::from_joints(|i| {
            start[i] + 0.1 * rise * limits.velocity[i].min(limits.acceleration[i])
        });
        let a = first.tick(&demanded);
        let b = second.tick(&demanded);
        ensure(a == b, || format!("tick {k}: {a:?} and {b:?}"))?;
    }
    Ok(())
}
