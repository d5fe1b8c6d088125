//! Why parts were missed, one by one.

use core::fmt;

use super::kinds::kinds;
use super::run::Outcome;
use super::settings::Settings;
use crate::monitor::Fate;

/// A part that was missed.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// Its number in the run, from 0 on.
    pub part: usize,
    /// Its kind; of a stranger [`KINDS`](super::kinds::KINDS).
    pub kind: usize,
    /// When it came \[s\] ..
    pub came: f64,
    /// .. and how long after the one before \[s\].
    pub after: f64,
    /// Why.
    pub why: Missed,
}

/// Why a part was missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Missed {
    /// No image showed it whole and alone.
    Unseen,
    /// It was taken for none of the kinds.
    Rejected,
    /// It came in a cluster, sooner than the arms could be done with those before: it was out of reach by then.
    Cluster {
        /// The last of so many parts ..
        parts: usize,
        /// .. that came within so long \[s\].
        within: f64,
    },
    /// The arms were busy until it was out of reach, though it came in no cluster.
    Late,
    /// It was not between the fingers where it was expected.
    NotThere,
    /// It was put back onto the belt: the arm could go along no path to its bin.
    NoPath,
    /// It was lost after the hand had it.
    Lost,
}

impl fmt::Display for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Missed::Unseen => write!(f, "unseen: no image showed it whole and alone"),
            Missed::Rejected => write!(f, "rejected: it was taken for none of the kinds"),
            Missed::Cluster { parts, within } => {
                write!(
                    f,
                    "cluster: number {parts} within {within:.1} s; it left the window while the arms were busy"
                )
            }
            Missed::Late => write!(f, "late: it left the window while the arms were busy"),
            Missed::NotThere => write!(f, "not there: it was not between the fingers where it was expected"),
            Missed::NoPath => {
                write!(
                    f,
                    "no path: it was put back, because every path to its bin leads beyond the arm's limits"
                )
            }
            Missed::Lost => write!(f, "lost: after the hand had it"),
        }
    }
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = kinds().get(self.kind).map_or("stranger", |kind| kind.class.name);
        write!(f, "{:7}  {name:14}{:7.1}{:7.1}   {}", self.part, self.came, self.after, self.why)
    }
}

/// The cluster of which a part is the last, when parts come at these times \[s\] and are each taken in `cycle` \[s\]: the one that leaves
/// the least time. `None` where there was always time enough.
#[must_use]
pub fn cluster(came: &[f64], part: usize, cycle: f64) -> Option<(usize, f64)> {
    let short = |first: usize| (part - first) as f64 * cycle - (came[part] - came[first]);
    let first = (0..part).max_by(|a, b| short(*a).total_cmp(&short(*b)))?;
    (short(first) > 0.0).then(|| (part - first + 1, came[part] - came[first]))
}

impl Outcome {
    /// Why each part that was missed was, with so many arms at the belt.
    #[must_use]
    pub fn misses(&self, arms: usize) -> Vec<Miss> {
        // Numbers, as the camera counts: each part once, when it is first known.
        let mut numbered: Vec<usize> = Vec::new();
        for look in self.looks.iter().filter(|look| look.taken.is_some()) {
            if !numbered.contains(&look.part) {
                numbered.push(look.part);
            }
        }
        let times: Vec<f64> = self.came.iter().map(|(time, _)| *time).collect();
        let cycle = Settings::CYCLE / arms.max(1) as f64;
        let why = |part: usize| {
            let number = numbered.iter().position(|of| *of == part).map(|place| place as u32 + 1);
            if number.is_some_and(|number| self.stranded.contains(&number)) {
                Missed::NoPath
            } else if self.grips.iter().any(|grip| grip.part == part) {
                Missed::Lost
            } else if !self.looks.iter().any(|look| look.part == part) {
                Missed::Unseen
            } else if number.is_none() {
                Missed::Rejected
            } else if number.is_some_and(|number| self.late.contains(&number)) {
                let cluster = cluster(&times, part, cycle);
                cluster.map_or(Missed::Late, |(parts, within)| Missed::Cluster { parts, within })
            } else {
                Missed::NotThere
            }
        };
        let missed = self.fates.iter().enumerate().filter(|(_, fate)| **fate == Fate::Missed);
        let miss = |(part, _): (usize, &Fate)| {
            let (came, kind) = self.came[part];
            let after = came - if part > 0 { times[part - 1] } else { 0.0 };
            Miss { part, kind, came, after, why: why(part) }
        };
        missed.map(miss).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cluster_is_where_parts_come_sooner_than_they_can_be_taken() {
        let came = [0.0, 20.0, 25.0, 29.0, 60.0];
        assert_eq!(cluster(&came, 0, 8.0), None);
        assert_eq!(cluster(&came, 1, 8.0), None);
        // Three within 9 s, where 16 s would be needed.
        assert_eq!(cluster(&came, 3, 8.0), Some((3, 9.0)));
        assert_eq!(cluster(&came, 4, 8.0), None);
        // Two arms need half as long.
        assert_eq!(cluster(&came, 3, 4.0), None);
    }
}
