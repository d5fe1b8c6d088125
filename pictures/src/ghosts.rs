//! Which poses are drawn pale between the first and the last: evenly along the path, not over time.
//!
//! In: a motion. Out: indices of its samples, none of a robot that stands still.

use crate::stick::Motion;

/// The most ghosts of a robot, and of a picture's robots together.
const MOST: usize = 7;
const MOST_TOGETHER: usize = 24;

/// Farther than this from one ghost to the next \[px\].
const GAP: f64 = 14.0;

/// Indices of the ghosts of one of `robots` motions that are drawn at this scale [px/m], without the first and the last
/// sample.
pub(crate) fn ghosts(motion: &Motion, scale: f64, robots: usize) -> Vec<usize> {
    let mut travelled = Vec::with_capacity(motion.sticks.len());
    let mut length = 0.0;
    for (i, stick) in motion.sticks.iter().enumerate() {
        if let Some(before) = i.checked_sub(1).and_then(|i| motion.sticks.get(i)) {
            // Less than a micrometre is an encoder's noise.
            let step = stick.distance(before);
            length += if step > 1e-6 { step } else { 0.0 };
        }
        travelled.push(length);
    }
    let count =
        ((length * scale / GAP) as usize).saturating_sub(1).min(MOST).min(MOST_TOGETHER / robots.max(1));
    let mut found: Vec<usize> = Vec::with_capacity(count);
    let places = (1..=count)
        .map(|k| travelled.partition_point(|s| *s < length * k as f64 / (count + 1) as f64))
        .filter(|i| *i > 0 && i + 1 < travelled.len());
    for i in places {
        // There and back is one ghost.
        let near = |j: &usize| motion.sticks[i].distance(&motion.sticks[*j]) * scale < 0.5 * GAP;
        if ![0, travelled.len() - 1].iter().chain(&found).any(near) {
            found.push(i);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::History;
    use crate::history::tests::slide;
    use mrroc::robot::JointKind;

    fn motion(x: impl Fn(f64) -> f64) -> Motion {
        let mut history = History::new("slide", "slide", &[JointKind::Prismatic]);
        for i in 0..=1000 {
            let time = f64::from(i) * 1e-3;
            history.add(slide(time, x(time), x(time)));
        }
        Motion::of(&history, 0.05)
    }

    #[test]
    fn ghosts_are_evenly_spaced_along_the_path_however_the_speed_changes() {
        let motion = motion(|t| t.powi(4));
        let found = ghosts(&motion, 500.0, 1);
        assert_eq!(found.len(), MOST);
        for (k, i) in found.iter().enumerate() {
            let expected = (k + 1) as f64 / (MOST + 1) as f64;
            assert!((motion.tool[*i].x - expected).abs() < 5e-3, "{k}");
        }
        assert_eq!(ghosts(&motion, 500.0, 8).len(), 3);
        assert!(ghosts(&motion, 10.0, 1).is_empty());
    }

    #[test]
    fn what_stands_still_has_no_ghosts() {
        assert!(ghosts(&motion(|_| 0.3), 500.0, 1).is_empty());
    }
}
