//! What must hold of a robot's limits before its cell runs: every one that does not is found, not the first.
//!
//! In: limits, following error, how long the cell takes to notice a loss \[s\], and the stop that it allows. Out: a [`CellError`] for each value that
//! no check of a demand could rely on, and for each joint that could not stop in time.

use core::time::Duration;

use crate::model::joints::JointVector;
use crate::model::name::Name;
use crate::model::robot::{JointKind, Limits};
use crate::safety::stopping::braking_time;

use super::CellError;

/// Checks the limits of one robot.
pub(super) fn check<J: JointVector>(
    robot: Name,
    kind: impl Fn(usize) -> JointKind,
    limits: &Limits<J>,
    following_error: &J,
    noticing: f64,
    stop_time: Duration,
) -> Vec<CellError> {
    let mut errors = Vec::new();
    for joint in 0..J::LEN {
        let unit = |order| kind(joint).unit(order);
        let mut wrong = |what, value, rule, unit| {
            errors.push(CellError::Limit { robot, joint, what, value, rule, unit });
        };
        for (what, value) in
            [("lower position limit", limits.lower[joint]), ("upper position limit", limits.upper[joint])]
        {
            if !value.is_finite() {
                wrong(what, value, "must be finite", unit(0));
            }
        }
        if limits.lower[joint] >= limits.upper[joint] {
            wrong("lower position limit", limits.lower[joint], "must be below the upper one", unit(0));
        }
        let positive = [
            ("velocity limit", Some(limits.velocity[joint]), unit(1)),
            ("acceleration limit", Some(limits.acceleration[joint]), unit(2)),
            ("jerk limit", limits.jerk.map(|jerk| jerk[joint]), unit(3)),
            ("following error", Some(following_error[joint]), unit(0)),
        ];
        let mut stops = true;
        for (what, value, unit) in positive {
            // A following error that nobody gave follows from the velocity limit.
            let follows = what == "following error" && !stops;
            if let Some(value) = value.filter(|value| !(follows || value.is_finite() && *value > 0.0)) {
                wrong(what, value, "must be finite and above 0", unit);
                stops = false;
            }
        }
        let time = noticing + braking_time(limits, joint);
        if stops && time > stop_time.as_secs_f64() {
            errors.push(CellError::StopTime { robot, joint, time, limit: stop_time.as_secs_f64() });
        }
    }
    errors
}
