//! How the arm brings a part that it has to its bin.
//!
//! In: where the arm is, the bin, the angle of the tool. Out: the poses to which the tool goes on straight lines, or none, where the arm
//! cannot go along any of them. A straight line from one end of the window to the bins beyond the other one leads nearer to the column
//! than the arm can fold.

use mrroc::prelude::*;
use mrroc::robot::RobotState;
use mrroc_robots::Irp6;

use super::acquire::at;
use super::layout::{Station, bin, limits};
use crate::places::{BELT, HIGH, LOW, OVER_TRAY, SURFACE};
use crate::reach::Reach;

/// Opposite the column, along the belt and across it from its middle \[m\]: lines to here and from here lead past the column.
const OPPOSITE: [f64; 2] = [-BELT[1], -0.04];

/// The hand opens within this time \[s\].
pub const OPENING: f64 = 0.8;

/// The same pose, so high over the belt \[m\].
#[allow(non_snake_case)]
fn at_height(X_WE: &Pose, height: f64) -> Pose {
    let mut pose = *X_WE;
    pose.translation.vector.z = height;
    pose
}

/// The same pose beside a part that lies on the belt: from there a part is let go.
#[must_use]
#[allow(non_snake_case)]
pub fn lowered(X_WE: &Pose) -> Pose {
    at_height(X_WE, LOW)
}

/// The same pose, over everything that comes.
#[must_use]
#[allow(non_snake_case)]
pub fn raised(X_WE: &Pose) -> Pose {
    at_height(X_WE, HIGH)
}

/// Whether the tool is where parts come: then it must not stay there.
#[must_use]
#[allow(non_snake_case)]
pub fn is_low(X_WE: &Pose) -> bool {
    X_WE.translation.z < 0.5 * HIGH
}

/// Whether the tool is over the belt, and not over a bin.
#[must_use]
#[allow(non_snake_case)]
pub fn is_over_belt(X_WE: &Pose) -> bool {
    (X_WE.translation.x - BELT[0]).abs() < 0.5 * SURFACE[2]
}

/// Where the tool is along the belt \[m\].
#[must_use]
#[allow(non_snake_case)]
pub fn along(X_WE: &Pose) -> f64 {
    X_WE.translation.y - BELT[1]
}

/// The poses of the tool on the way to a bin, its angle `yaw` \[rad\]: straight, or else past the column; over the bin, and down to it.
/// `None` where the arm can go along neither.
#[must_use]
pub fn lines(
    reach: &Reach,
    from: &RobotState<Irp6>,
    station: &Station,
    number: usize,
    yaw: f64,
) -> Option<Vec<Pose>> {
    let ([x, y], _) = bin(number);
    let over = |height| at(y - BELT[1] + station.along, x - BELT[0], height, yaw);
    let [along, across] = OPPOSITE;
    let opposite = at(along + station.along, across, HIGH, yaw);
    let end = [over(HIGH), over(OVER_TRAY)];
    let straight = end.to_vec();
    let past = core::iter::once(opposite).chain(end).collect();
    [straight, past].into_iter().find(|poses| reach.contains(from, poses, limits()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::acquire::Acquire;
    use crate::camera::layout::{ACROSS, BINS, FIRST, LAST, STATIONS};
    use crate::reach::tests::at_rest;
    use core::f64::consts::PI;
    use core::time::Duration;
    use mrroc::random::Noise;
    use mrroc_generators::generators::StraightLine;
    use mrroc_robots::SimulatedIrp6;

    /// The far end of the window, where a step of seed 7019 was lifted \[m, W\], and the bin of steps.
    const FAR: [f64; 2] = [0.7566, 0.4937];
    const STEPS: usize = 6;

    /// What the EDP of the arm says to lines from there: whether it goes along all of them.
    fn goes(from: &RobotState<Irp6>, poses: &[Pose]) -> bool {
        let (arm, poses) = (Irp6::nominal(), poses.to_vec());
        let drives = SimulatedIrp6::new(arm.clone(), &from.joints);
        let setup = RobotSetup::new("arm", arm, drives).tool(Pose::translation(0.0, 0.0, 0.2));
        let setup = setup.program(move |ecp| {
            poses.iter().try_for_each(|pose| ecp.move_robot((), StraightLine::to(*pose, limits())).map(drop))
        });
        let report = Cell::new(Duration::from_millis(4)).robot(setup).run();
        if let Err(error) = &report {
            assert!(error.to_string().contains("edp arm joint"), "{error}");
        }
        report.is_ok()
    }

    #[test]
    fn a_line_on_which_a_motor_would_pass_its_limit_is_known_before_and_another_one_is_found() {
        let (station, ([x, y], yaw)) = (&STATIONS[0], (FAR, 0.5 * PI));
        let from = at_rest(at(y - BELT[1], x - BELT[0], HIGH, yaw), station.along).expect("a posture");
        let reach = Reach::at(station.along, Duration::from_millis(4));
        let found = lines(&reach, &from, station, STEPS, yaw).expect("lines");
        assert_eq!(found.len(), 3, "past the column, over the bin, down");
        assert!(goes(&from, &found) && !goes(&from, &found[1..]));
    }

    #[test]
    fn reach_says_of_lines_what_the_edp_does() {
        let (station, reach) = (&STATIONS[0], Reach::at(STATIONS[0].along, Duration::from_millis(4)));
        let mut random = Noise::seeded(36);
        let mut counts = [0, 0];
        while counts[0] + counts[1] < 150 {
            let mut place = |height| {
                let (s, across) = (random.between(-0.3, 1.1), random.between(-0.35, 0.3));
                at(s, across, height, random.between(-0.6, 3.7))
            };
            let Some(from) = at_rest(place(HIGH), station.along) else { continue };
            let to = place(OVER_TRAY);
            // It begins within its limits.
            if !reach.contains(&from, &[], limits()) || !Irp6::nominal().is_feasible(&from.joints) {
                continue;
            }
            let known = reach.contains(&from, &[to], limits());
            assert_eq!(known, goes(&from, &[to]), "{from:?} {to}");
            counts[usize::from(known)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
    }

    #[test]
    fn from_everywhere_in_the_window_the_arm_gets_to_every_bin_and_can_put_back_what_it_has() {
        let mut counts = [0, 0];
        for station in &STATIONS {
            let reach = Reach::at(station.along, Duration::from_millis(4));
            // Where the tool stops after it has left the part, at 1.2 times the fastest belt; across, as far as parts are believed to lie.
            let (farthest, aside) = (LAST + 0.1 + 0.2 * 1.2 * 0.15, 1.2 * ACROSS);
            for s in between(FIRST, farthest, 20) {
                for across in between(-aside, aside, 4) {
                    for yaw in between(Acquire::ANGLES[0], Acquire::ANGLES[1], 6) {
                        let pose = at(s + station.along, across, HIGH, yaw);
                        let from = at_rest(pose, station.along).expect("a posture");
                        assert!(reach.contains(&from, &[lowered(&pose), pose], limits()), "{pose}");
                        assert!(is_over_belt(&pose) && (along(&pose) - s - station.along).abs() < 1e-12);
                        for number in 0..BINS {
                            let found = lines(&reach, &from, station, number, yaw);
                            let found = found.unwrap_or_else(|| panic!("{s} {across} {yaw} to bin {number}"));
                            counts[found.len() - 2] += 1;
                            assert!(!is_over_belt(&found[found.len() - 1]), "bin {number}");
                        }
                    }
                }
            }
        }
        let [straight, past] = counts;
        assert!(straight > 0 && past > 0);
    }

    fn between(from: f64, to: f64, steps: u32) -> impl Iterator<Item = f64> + Clone {
        (0..=steps).map(move |i| from + (to - from) * f64::from(i) / f64::from(steps))
    }
}
