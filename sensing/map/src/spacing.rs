//! Whether walls stand at multiples of one spacing, and which: learned from touches alone.
//!
//! ```text
//! a touch        tells one coordinate c of a wall's middle line, x or y, from the frame's lower left corner
//! hypotheses     spacings s that divide both sides of the frame into whole parts no narrower than a passage; and none at all
//! P(c | s)       normal about the nearest multiple of s, each of the multiples as probable; of none, even over the frame's side
//! P(s)           proportional to s^-4: passages are rather about as wide as they are told to be than many times so
//! learned        as soon as one of the spacings is `SURE` times as probable as all else together; until it is `SURE` times less so
//! ```

use crate::contact::{Contact, Knowledge};

/// The odds at which a spacing counts as learned.
const SURE: f64 = 30.0;
/// Standard deviation of a touched line, as a share of a passage: 0.5 mm of 15 mm.
const SPREAD: f64 = 1.0 / 30.0;
/// This share of touches may be of anything.
const OTHER: f64 = 0.2;
/// How probable it is beforehand that walls stand at no multiples.
const NONE: f64 = 0.2;

/// The spacing at whose multiples walls stand \[m\], if the touches bear one out; `before` is what was learned before the last touch.
///
/// ```
/// use mrroc_map::{Contact, Knowledge, Place, spacing};
///
/// let known = Knowledge { size: [0.4, 0.4], radius: 0.002, thickness: 0.002, passage: 0.015, wall: 0.025 };
/// // Seven walls that are met from the left: their middle lines are at multiples of 25 mm.
/// let into = Place::new(1.0, 0.0);
/// let met = |line: f64| {
///     let at = Place::new(line - 0.001, 0.1);
///     Contact { at, into, moving: into, ball: at - 0.002 * into }
/// };
/// let contacts = [0.05, 0.075, 0.125, 0.2, 0.275, 0.3, 0.375].map(met);
/// assert_eq!(spacing(&contacts, &known, None), Some(0.025));
/// // One wall alone bears out no spacing.
/// assert_eq!(spacing(&contacts[..1], &known, None), None);
/// ```
#[must_use]
pub fn spacing(contacts: &[Contact], known: &Knowledge, before: Option<f64>) -> Option<f64> {
    let least = known.passage + known.thickness;
    let [width, height] = known.size;
    let spread = SPREAD * known.passage;
    let mut hypotheses = vec![];
    for parts in 1..=(width / least) as usize {
        let s = width / parts as f64;
        let along = (height / s).round();
        if along >= 1.0 && (height / s - along).abs() * s < 2.0 * spread {
            hypotheses.push((s, -4.0 * s.ln()));
        }
    }
    let sum: f64 = hypotheses.iter().map(|(_, log)| log.exp()).sum();
    for (_, log) in &mut hypotheses {
        *log += ((1.0 - NONE) / sum).ln();
    }
    let mut none = NONE.ln();
    // A line that is touched again tells nothing new.
    let mut seen: Vec<(bool, f64)> = vec![];
    for contact in contacts {
        let middle = contact.at + contact.into * (0.5 * known.thickness);
        let upright = contact.into.x.abs() > 0.5;
        let (c, side) = if upright { (middle.x, width) } else { (middle.y, height) };
        let is_frame = c < least || c > side - least;
        if is_frame || seen.iter().any(|(of, at)| *of == upright && (at - c).abs() < 6.0 * spread) {
            continue;
        }
        seen.push((upright, c));
        none += side.recip().ln();
        for (s, log) in &mut hypotheses {
            let lines = (side / *s).round() - 1.0;
            let off = (c - (c / *s).round() * *s) / spread;
            let normal = (-0.5 * off * off).exp() / (spread * (2.0 * core::f64::consts::PI).sqrt());
            *log += if lines < 0.5 {
                (OTHER / side).ln()
            } else {
                ((1.0 - OTHER) * normal / lines + OTHER / side).ln()
            };
        }
    }
    let odds = |s: f64| {
        let own = hypotheses.iter().find(|(other, _)| *other == s).map_or(f64::NEG_INFINITY, |(_, log)| *log);
        let others = hypotheses.iter().filter(|(other, _)| *other != s).map(|(_, log)| (log - own).exp());
        1.0 / (others.sum::<f64>() + (none - own).exp())
    };
    let (best, _) = hypotheses.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    if odds(best) >= SURE { Some(best) } else { before.filter(|s| odds(*s) > 1.0 / SURE) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::Place;
    use mrroc::random::Random;

    const KNOWN: Knowledge =
        Knowledge { size: [0.4, 0.4], radius: 0.002, thickness: 0.002, passage: 0.015, wall: 0.025 };

    /// Touches of walls whose middle lines are given by `line`, alternately upright and level, to 0.3 mm.
    fn learned(count: usize, seed: u64, mut line: impl FnMut(&mut Random) -> f64) -> Option<f64> {
        let mut chance = Random::seeded(seed);
        let mut contacts = vec![];
        let mut learned = None;
        for number in 0..count {
            let c = line(&mut chance) + chance.within(3e-4) - 0.001;
            let along = 0.4 * chance.unit();
            let (into, at) = if number % 2 == 0 {
                (Place::new(1.0, 0.0), Place::new(c, along))
            } else {
                (Place::new(0.0, 1.0), Place::new(along, c))
            };
            contacts.push(Contact { at, into, moving: into, ball: at });
            learned = spacing(&contacts, &KNOWN, learned);
        }
        learned
    }

    #[test]
    fn the_spacing_of_walls_is_learned_whatever_it_is_and_no_other() {
        for parts in [8_usize, 10, 16, 20] {
            let s = 0.4 / parts as f64;
            let found = |touches: usize, seed: u64| {
                learned(touches, seed, |chance| (1 + chance.below(parts - 1)) as f64 * s)
            };
            for seed in 0..20 {
                assert_eq!(found(40, seed), Some(s), "{parts} parts, seed {seed}");
            }
            // Half of 50 mm would do for a dozen touches as well, but no part of 25 mm is a passage.
            let early = (0..20).filter(|seed| found(12, *seed) == Some(s)).count();
            assert!(parts < 16 || early >= 16, "{parts} parts: {early} of 20 by a dozen touches");
        }
    }

    #[test]
    fn of_walls_that_stand_anywhere_no_spacing_is_learned() {
        let wrong =
            (0..200).filter(|seed| learned(12, *seed, |chance| 0.02 + 0.36 * chance.unit()).is_some());
        // At odds of 30 to 1 against, a few of 200 may mislead.
        let wrong = wrong.count();
        assert!(wrong <= 6, "{wrong}");
    }
}
