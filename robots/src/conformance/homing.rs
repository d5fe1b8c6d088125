//! What the homing of a robot's drives must keep.

use mrroc::robot::{DriveFault, Driver, Homing, JointVector, Robot, Search};

use super::driver::read;
use super::{Violation, ensure};

/// Longest search \[s\].
const LONGEST: f64 = 3600.0;

/// For how long a found robot is looked at [servo periods].
const STANDING: usize = 1_000;

/// Servo periods that a search took and the drives that it came to, or the fault.
type Outcome<R, H> = Result<(u64, <H as Homing<R>>::Drives), DriveFault>;

/// Searches until the end.
fn searched<R: Robot, H: Homing<R>>(mut homing: H) -> Result<Outcome<R, H>, Violation> {
    let period = homing.period().as_secs_f64();
    let mut ticks = 0_u64;
    loop {
        ticks += 1;
        ensure(ticks as f64 * period < LONGEST, || format!("it searches for {LONGEST} s"))?;
        match homing.search() {
            Ok(Search::Searching(on)) => homing = on,
            Ok(Search::Found(drives)) => return Ok(Ok((ticks, drives))),
            Err(fault) => return Ok(Err(fault)),
        }
    }
}

/// From every start it finds its marks within an hour; it has the servo period of the drives that it becomes; and the robot
/// then stands within its limits, where its drives can hold it.
///
/// # Errors
/// The first [`Violation`].
pub fn finds_its_marks<R: Robot, H: Homing<R>>(
    robot: &R,
    make: impl Fn(&R::Joints) -> H,
    starts: &[R::Joints],
) -> Result<(), Violation> {
    ensure(starts.len() > 1, || "one start is not several".into())?;
    let limits = robot.limits();
    for start in starts {
        let homing = make(start);
        let period = homing.period();
        let (ticks, mut drives) =
            searched(homing)?.map_err(|fault| Violation(format!("from {start:?}: {fault}")))?;
        println!("{} from {start:?}: {:.1} s", R::KIND, ticks as f64 * period.as_secs_f64());
        ensure(drives.period() == period, || {
            format!("it searches every {period:?} and drives every {:?}", drives.period())
        })?;
        let found = read(&drives)?.position;
        for i in 0..R::Joints::LEN {
            let (lower, upper) = (limits.lower[i], limits.upper[i]);
            ensure((lower..=upper).contains(&found[i]), || {
                format!("joint {i} is found at {}, outside of {lower} to {upper}", found[i])
            })?;
        }
        robot.check_coupled(&found, &found, 1.0).map_err(|limit| Violation(format!("found at {limit:?}")))?;
        for _ in 0..STANDING {
            let measured = drives.tick(&found).map_err(|fault| Violation(format!("holding: {fault}")))?;
            for i in 0..R::Joints::LEN {
                let off = (measured.position[i] - found[i]).abs() / limits.velocity[i];
                // Coarse encoders tell of speeds by whole pulses.
                let speed = measured.velocity[i].abs() / limits.velocity[i];
                ensure(off < 1e-3 && speed < 0.05, || {
                    format!("joint {i} is found moving: {off} s of its top speed off, at {speed} of it")
                })?;
            }
        }
    }
    Ok(())
}

/// Two searches from one place take equally long and measure the same, to the bit.
///
/// # Errors
/// The first [`Violation`].
pub fn searches_alike<R: Robot, H: Homing<R>>(
    _robot: &R,
    make: impl Fn(&R::Joints) -> H,
    starts: &[R::Joints],
) -> Result<(), Violation> {
    for start in starts.iter().take(2) {
        let run = || {
            let (ticks, drives) = searched(make(start))?.map_err(|fault| Violation(fault.to_string()))?;
            Ok::<_, Violation>((ticks, read(&drives)?))
        };
        let one = run()?;
        let other = run()?;
        ensure(one == other, || format!("{one:?} and {other:?}"))?;
    }
    Ok(())
}

/// A joint that does not move ends the search with a fault that names it.
///
/// # Errors
/// The first [`Violation`].
pub fn trips_where_jammed<R: Robot, H: Homing<R>>(
    _robot: &R,
    jammed: impl Fn(usize) -> H,
) -> Result<(), Violation> {
    for joint in 0..R::Joints::LEN {
        let Err(fault) = searched(jammed(joint))? else {
            return Err(Violation(format!("joint {joint} is jammed, and found")));
        };
        ensure(fault.joint() == Some(joint), || match fault.joint() {
            Some(named) => format!("joint {joint} is jammed, and joint {named} named"),
            None => format!("joint {joint} is jammed, and no joint named"),
        })?;
    }
    Ok(())
}
