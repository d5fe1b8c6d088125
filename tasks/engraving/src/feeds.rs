//! The greatest feed along a stroke that the arm's joints allow, and whether the arm reaches it.

use mrroc::prelude::*;

use crate::drawing::{Stroke, Vec3};
use crate::ecp::travel_height;
use crate::layout::{Layout, OutOfReach};

/// The path of the tip is looked at this often \[mm\].
const STEP: f64 = 2.0;
/// The share of a joint's greatest speed that a feed may take: the rest is for what lies between two looks.
const SHARE: f64 = 0.8;

/// The greatest feed along a stroke at its depth [mm/s]: at it the fastest joint has a share of its greatest speed.
///
/// # Errors
/// The first place that the arm does not reach.
pub fn greatest_feed(layout: &Layout, stroke: &Stroke) -> Result<f64, OutOfReach> {
    let limits = layout.arm.limits();
    let joints = |tip: Vec3| layout.joints(tip.xy(), tip.z * 1e-3);
    // Where the tool comes from, as far as it matters: above the start.
    layout.joints(stroke.start(), travel_height(stroke.manner()))?;
    let mut greatest = f64::INFINITY;
    let mut last: Option<(Vec3, _)> = None;
    for tip in stroke.flattened_tips(0.05) {
        let Some((from, mut before)) = last else {
            last = Some((tip, joints(tip)?));
            continue;
        };
        let parts = ((tip - from).norm() / STEP).ceil().max(1.0);
        let mut here = from;
        for part in 1..=parts as u32 {
            let next = from + (tip - from) * (f64::from(part) / parts);
            let after = joints(next)?;
            let distance = (next - here).norm();
            for i in 0..6 {
                let turned = (after[i] - before[i]).abs();
                if turned > 1e-12 {
                    greatest = greatest.min(SHARE * limits.velocity[i] * distance / turned);
                }
            }
            (here, before) = (next, after);
        }
        last = Some((tip, before));
    }
    Ok(greatest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Piece, Stroke, Vec2};
    use crate::placement::Plate;

    #[test]
    fn the_limit_is_that_of_the_first_joint_across_the_arm() {
        let plate = Plate::default();
        let layout = Layout::new(&plate).unwrap();
        let line = Piece::Line { from: Vec2::new(99.0, 60.0), to: Vec2::new(101.0, 60.0) };
        let stroke = Stroke::new(vec![line]).unwrap().sunk(0.3);
        // Across at a distance of 0.85 m from the first axis, that joint turns by v / 0.85 m; so does the last, which
        // keeps the tool's orientation. No other joint moves as fast.
        let limits = layout.arm.limits();
        let slowest = limits.velocity[0].min(limits.velocity[5]);
        let expected = 0.8 * slowest * 850.0;
        let found = greatest_feed(&layout, &stroke).unwrap();
        assert!((found - expected).abs() < 0.01 * expected, "{found} for {expected}");
    }
}
