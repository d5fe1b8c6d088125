//! Which arm takes which part: an assignment by Kuhn and Munkres.
//!
//! In: parts that wait, arms, the belt's speed. Out: for each part the arm and whether that is its next pick, its second next, ..
//!
//! Parts are assigned to *picks* of arms. Pick `k` (from 0 on) of an arm that is free `f` \[s\] from now on, with its window from `a` to `b`
//! along the belt and the part at `s`, is over at
//!
//! ```text
//! t = max(f + k CYCLE + REACHING, (a - s) / v) + CARRYING,     if f + k CYCLE + REACHING <= (b - s) / v
//! ```
//!
//! Else the arm cannot take it so. What is minimised is first the number of parts that no pick is left for, then the sum of `t`.

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// So many parts are looked at, the ones that are farthest along: more than lie on the belt from the first window's begin to the last one's end.
pub const PARTS: usize = 32;
/// So many picks of each arm are looked at.
pub const PICKS: usize = 3;

/// What each pick takes \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// From one pick of an arm to its next one, where parts never wait for it nor it for them.
    pub cycle: f64,
    /// From when it sets out until it has the part.
    pub reaching: f64,
    /// From then until the part is in its bin.
    pub carrying: f64,
}

/// An arm at the belt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// For how long it is still busy \[s\], >= 0.
    pub after: f64,
    /// It goes down onto parts from here on, along the belt \[m\] ..
    pub first: f64,
    /// .. and not beyond \[m\].
    pub last: f64,
}

/// A part that waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waiting<const ARMS: usize> {
    /// Where it is now, along the belt \[m\].
    pub at: f64,
    /// Which arms have tried in vain to take it.
    pub tried: [bool; ARMS],
}

/// Costs are in milliseconds; this is that of a part that no pick is left for.
const PASSES: i64 = 1_000_000_000;

/// When a pick of an arm is over \[s from now\]; `None` where it cannot be.
#[must_use]
pub fn over(at: f64, arm: &Free, pick: usize, speed: f64, times: &Times) -> Option<f64> {
    let reached = arm.after + pick as f64 * times.cycle + times.reaching;
    let (comes, leaves) = if speed > 1e-4 {
        ((arm.first - at) / speed, (arm.last - at) / speed)
    } else if (arm.first..=arm.last).contains(&at) {
        (0.0, f64::INFINITY)
    } else {
        return None;
    };
    (reached <= leaves).then(|| reached.max(comes) + times.carrying)
}

/// For each part, of which at most [`PARTS`] are looked at, the arm and the number of its pick; `None` for one that no pick is left for.
#[must_use]
pub fn assign<const ARMS: usize>(
    parts: &[Waiting<ARMS>],
    arms: &[Free; ARMS],
    speed: f64,
    times: &Times,
) -> Vec<Option<(usize, usize)>> {
    let parts = &parts[..parts.len().min(PARTS)];
    if parts.is_empty() {
        return Vec::new();
    }
    let picks = ARMS * PICKS;
    // Each part may also pass: so there are never fewer columns than rows.
    let cost = |(row, column): (usize, usize)| {
        let (part, arm) = (&parts[row], column / PICKS);
        if column >= picks || part.tried[arm] {
            return PASSES;
        }
        over(part.at, &arms[arm], column % PICKS, speed, times).map_or(PASSES, |t| (1e3 * t) as i64)
    };
    let costs = Matrix::from_fn(parts.len(), picks + parts.len(), cost);
    let (_, columns) = kuhn_munkres_min(&costs);
    let taken = |(row, column): (usize, &usize)| {
        (costs[(row, *column)] < PASSES).then_some((column / PICKS, column % PICKS))
    };
    columns.iter().enumerate().map(taken).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::random::Noise;

    const TIMES: Times = Times { cycle: 8.0, reaching: 4.5, carrying: 3.5 };

    /// The least number of parts that pass, and then the least sum of times \[ms\], by trying all.
    fn least(
        parts: &[Waiting<2>],
        arms: &[Free; 2],
        speed: f64,
        taken: &mut [[bool; PICKS]; 2],
    ) -> (usize, i64) {
        let Some((part, rest)) = parts.split_first() else { return (0, 0) };
        let (passing, sum) = least(rest, arms, speed, taken);
        let mut best = (passing + 1, sum);
        for arm in 0..2 {
            for pick in 0..PICKS {
                let time = over(part.at, &arms[arm], pick, speed, &TIMES).filter(|_| !part.tried[arm]);
                let Some(time) = time.filter(|_| !taken[arm][pick]) else { continue };
                taken[arm][pick] = true;
                let (passing, sum) = least(rest, arms, speed, taken);
                taken[arm][pick] = false;
                best = best.min((passing, sum + (1e3 * time) as i64));
            }
        }
        best
    }

    #[test]
    fn no_other_assignment_lets_fewer_parts_pass_or_is_over_sooner() {
        let mut random = Noise::seeded(7);
        for _ in 0..60 {
            let speed = random.between(0.03, 0.18);
            let mut free = |first: f64| Free { after: random.between(0.0, 9.0), first, last: first + 0.85 };
            let arms = [free(0.0), free(1.8)];
            let count = 1 + (random.uniform() * 4.0) as usize;
            let mut part = || Waiting {
                at: random.between(-0.4, 2.5),
                tried: [random.uniform() < 0.2, random.uniform() < 0.2],
            };
            let parts: Vec<_> = (0..count).map(|_| part()).collect();
            let found = assign(&parts, &arms, speed, &TIMES);
            let mut sum = (0, 0);
            for (part, found) in parts.iter().zip(&found) {
                match found {
                    None => sum.0 += 1,
                    Some((arm, pick)) => {
                        assert!(!part.tried[*arm]);
                        let time = over(part.at, &arms[*arm], *pick, speed, &TIMES).expect("it can be taken");
                        sum.1 += (1e3 * time) as i64;
                    }
                }
            }
            assert_eq!(sum, least(&parts, &arms, speed, &mut Default::default()), "{parts:?} {arms:?}");
        }
    }

    #[test]
    fn what_one_arm_cannot_take_is_the_others_while_it_still_can() {
        let arm = |after, first| Free { after, first, last: first + 0.85 };
        let part = |at, tried| Waiting { at, tried };
        // At 0.1 m/s the part leaves the first window in 4 s, and the arm would need 4.5 s.
        let idle = [arm(0.0, 0.0), arm(0.0, 1.8)];
        assert_eq!(assign(&[part(0.45, [false; 2])], &idle, 0.1, &TIMES), [Some((1, 0))]);
        assert_eq!(assign(&[part(-0.3, [false; 2])], &idle, 0.1, &TIMES), [Some((0, 0))]);
        // Tried by the first in vain; tried by both; beyond both.
        assert_eq!(assign(&[part(-0.3, [true, false])], &idle, 0.1, &TIMES), [Some((1, 0))]);
        assert_eq!(assign(&[part(-0.3, [true, true])], &idle, 0.1, &TIMES), [None]);
        assert_eq!(assign(&[part(2.6, [false; 2])], &idle, 0.1, &TIMES), [None]);
        // A cluster: the first arm is free for one of the two before they leave its window.
        let cluster = [part(-0.2, [false; 2]), part(-0.36, [false; 2])];
        let picks = assign(&cluster, &idle, 0.1, &TIMES);
        let mut of: Vec<_> = picks.iter().flatten().collect();
        of.sort();
        assert_eq!(of, [&(0, 0), &(1, 0)], "{picks:?}");
        assert_eq!(assign::<2>(&[], &idle, 0.1, &TIMES), []);
    }
}
