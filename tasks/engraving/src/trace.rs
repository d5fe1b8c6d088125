//! The executed path, thinned while it is recorded: for a picture, not for measuring.
//!
//! A point is left out as long as one line from the last kept point passes all points since within the tolerance
//! (the sector method of Williams 1978).

use crate::drawing::Vec2;
use crate::plate::Tip;

/// Whether the tool was in the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Below the surface.
    Cutting,
    /// Above it.
    Travelling,
}

/// A part of the path without change of contact.
#[derive(Clone, Debug, PartialEq)]
pub struct TracePart {
    /// What the tool did.
    pub contact: Contact,
    /// Kept points \[mm\].
    pub points: Vec<Vec2>,
}

/// A recorder of tool tips.
#[derive(Clone, Debug)]
pub struct Trace {
    parts: Vec<TracePart>,
    tolerance: f64,
    latest: Option<Vec2>,
    sector: Option<Sector>,
}

/// The directions from the last kept point that pass all points since: a middle and half an angle \[rad\].
#[derive(Clone, Copy, Debug)]
struct Sector {
    reference: Vec2,
    low: f64,
    high: f64,
    /// The farthest skipped point's distance: a path that turns back is kept.
    reached: f64,
}

impl Trace {
    /// Keeps points so that the thinned path stays within `tolerance` \[mm\], > 0.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self { parts: Vec::new(), tolerance, latest: None, sector: None }
    }

    /// The parts so far, the latest point among them.
    #[must_use]
    pub fn parts(mut self) -> Vec<TracePart> {
        self.keep_latest();
        self.parts.retain(|part| part.points.len() > 1);
        self.parts
    }

    /// Records an executed tip \[mm\].
    pub fn move_to(&mut self, tip: Tip) {
        let p = Vec2::new(tip.x, tip.y);
        let contact = if tip.z < 0.0 { Contact::Cutting } else { Contact::Travelling };
        if self.parts.last().is_none_or(|part| part.contact != contact) {
            self.keep_latest();
            let start = self.latest.unwrap_or(p);
            self.parts.push(TracePart { contact, points: vec![start] });
            self.sector = None;
            self.latest = Some(p);
            return;
        }
        let Some(kept) = self.parts.last().and_then(|part| part.points.last()).copied() else { return };
        if !self.passes(kept, p) {
            self.keep_latest();
            let kept = self.latest.unwrap_or(kept);
            self.sector = None;
            self.passes(kept, p);
        }
        self.latest = Some(p);
    }

    fn keep_latest(&mut self) {
        if let (Some(latest), Some(part)) = (self.latest, self.parts.last_mut())
            && part.points.last() != Some(&latest)
        {
            part.points.push(latest);
        }
    }

    /// Narrows the sector by a point; `false` if none is left or the path turns back.
    fn passes(&mut self, kept: Vec2, p: Vec2) -> bool {
        let gap = p - kept;
        let distance = gap.norm();
        if distance <= self.tolerance {
            return self.sector.is_none_or(|s| s.reached <= 2.0 * self.tolerance);
        }
        let width = (self.tolerance / distance).min(1.0).asin();
        let Some(sector) = &mut self.sector else {
            self.sector =
                Some(Sector { reference: gap / distance, low: -width, high: width, reached: distance });
            return true;
        };
        let angle = crate::drawing::cross(sector.reference, gap).atan2(sector.reference.dot(&gap));
        if angle < sector.low || angle > sector.high || distance < sector.reached - self.tolerance {
            return false;
        }
        sector.low = sector.low.max(angle - width);
        sector.high = sector.high.min(angle + width);
        sector.reached = sector.reached.max(distance);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_circle_stays_within_the_tolerance_with_few_points() {
        let mut trace = Trace::new(1e-3);
        for k in 0..=20_000 {
            let a = f64::from(k) / 20_000.0 * std::f64::consts::TAU;
            trace.move_to(Tip::new(10.0 * a.cos(), 10.0 * a.sin(), -0.1));
        }
        let parts = trace.parts();
        let points = &parts[0].points;
        // Sagitta of a chord: s = l² / 8r, so 1 µm allows 0.28 mm, 222 chords.
        assert!((150..500).contains(&points.len()), "{}", points.len());
        for w in points.windows(2) {
            assert!(((w[0] + w[1]) * 0.5).norm() > 10.0 - 2e-3);
        }
    }

    #[test]
    fn lifting_begins_a_new_part_and_turning_back_is_kept() {
        let mut trace = Trace::new(1e-3);
        for (x, z) in [(0.0, -1.0), (1.0, -1.0), (5.0, -1.0), (2.0, -1.0), (2.0, 1.0), (9.0, 1.0)] {
            trace.move_to(Tip::new(x, 0.0, z));
        }
        let parts = trace.parts();
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0].points.iter().map(|p| p.x).collect::<Vec<_>>(), [0.0, 5.0, 2.0]);
        assert_eq!(parts[1].contact, Contact::Travelling);
    }
}
