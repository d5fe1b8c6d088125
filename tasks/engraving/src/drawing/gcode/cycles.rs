//! Cycles for holes: G81 and G82 drill, G83 and G73 peck, G85, G86 and G89 bore (LinuxCNC's manual, G80-G89).
//!
//! Each goes rapidly over the hole and down to R, at the feed down to Z, and up again to the height from which the
//! series of cycles began (G98) or to R (G99), whichever G98 finds higher.

use super::block::Block;
use super::machine::Machine;
use super::modes::{Cycle, Distance, FeedMode, Plane, Sticky};
use super::steps::Pace;
use super::stop::{Stop, malformed, unsupported};
use crate::drawing::Vec3;

/// How far G73 backs off, and how far above the bottom of the hole G83 comes back rapidly, unless P says \[mm\].
const CLEARANCE: f64 = 0.254;
/// The most holes of one line.
const MOST_REPEATS: f64 = 1e6;

impl Machine<'_> {
    /// A line of a cycle.
    pub(super) fn cycle(&mut self, cycle: Cycle, block: &Block, in_machine: bool) -> Result<(), Stop> {
        let Some(byte) = block.first("xyz@^") else {
            return match block.first("rql") {
                Some(byte) => malformed(byte, "a cycle without a place", "give X, Y or Z"),
                None => Ok(()),
            };
        };
        if self.modes.plane != Plane::Xy {
            return unsupported(
                byte,
                "a cycle in the plane G18 or G19",
                "holes go into the plate: write G17",
            );
        }
        if self.modes.feed_mode == FeedMode::InverseTime || in_machine {
            return malformed(byte, "a cycle with G93 or G53", "write G94, and work coordinates");
        }
        let height = self.tool.z;
        let to = self.target(block, false)?;
        let place = |z: f64| Vec3::new(to.x, to.y, z);
        let scale = self.scale();
        let sticky = &mut self.sticky;
        for (letter, kept) in
            [('z', &mut sticky.z), ('r', &mut sticky.r), ('q', &mut sticky.q), ('p', &mut sticky.p)]
        {
            // Q belongs to pecks, P to rests and to what pecks leave; with others they are told.
            let pecks = matches!(cycle, Cycle::Peck { .. });
            let rests = matches!(cycle, Cycle::Drill { rests: true } | Cycle::Bore { rests: true, .. });
            let has = match letter {
                'q' => pecks,
                'p' => pecks || rests,
                _ => true,
            };
            if has && let Some(value) = block.value(letter) {
                *kept = Some(value);
            }
        }
        let Sticky { z, r, q, p, began } = *sticky;
        let (Some(z), Some(r)) = (z, r) else {
            return malformed(
                byte,
                "a cycle without Z and R",
                "give the bottom of the hole by Z, the retreat by R",
            );
        };
        let began = began.unwrap_or(height);
        self.sticky.began = Some(began);
        let origin = self.coordinates.origin().z;
        let relative = self.modes.distance == Distance::Relative;
        let r = if relative { height + r * scale } else { origin + r * scale };
        let bottom = if relative { r + z * scale } else { origin + z * scale };
        if bottom > r {
            return malformed(byte, "a cycle whose R is below its Z", "R is the height above the hole");
        }
        if self.over_plate(bottom) >= 0.0 {
            self.warn_once("hole", "a hole that ends above the plate's surface cuts nothing");
        }
        let times = match block.word('l') {
            None => 1,
            Some(word) if word.value.fract() == 0.0 && (1.0..=MOST_REPEATS).contains(&word.value) => {
                word.value as u32
            }
            Some(word) => {
                return malformed(word.byte, format!("L{}", word.value), "L is a whole number from 1");
            }
        };
        let peck = match (cycle, q) {
            (Cycle::Peck { .. }, Some(q)) if q > 0.0 => q * scale,
            (Cycle::Peck { .. }, _) => {
                return malformed(byte, "pecks without Q", "give the depth of a peck by a positive Q");
            }
            (Cycle::Drill { .. } | Cycle::Bore { .. }, _) => f64::INFINITY,
        };
        let p = p.unwrap_or(0.0);
        if p < 0.0 {
            return malformed(byte, format!("P{p} in a cycle"), "P is not negative");
        }
        let clear = if self.modes.back_to_start { began.max(r) } else { r };
        let by = place(0.0) - Vec3::new(self.tool.x, self.tool.y, 0.0);
        let mut hole = place(0.0);
        if self.tool.z < r {
            self.go(Vec3::new(self.tool.x, self.tool.y, r), Pace::Rapid)?;
        }
        for time in 0..times {
            if time > 0 && relative {
                hole += by;
            }
            let at = |z: f64| Vec3::new(hole.x, hole.y, z);
            self.go(at(self.tool.z), Pace::Rapid)?;
            self.go(at(r), Pace::Rapid)?;
            match cycle {
                Cycle::Drill { rests } => {
                    self.go(at(bottom), Pace::Feed)?;
                    self.rest(if rests { p } else { 0.0 });
                }
                Cycle::Bore { rests, feeds_out } => {
                    self.go(at(bottom), Pace::Feed)?;
                    self.rest(if rests { p } else { 0.0 });
                    if feeds_out {
                        self.go(at(r), Pace::Feed)?;
                    }
                }
                Cycle::Peck { out } => {
                    let clearance = if p > 0.0 { p * scale } else { CLEARANCE };
                    self.pecks(at(r), bottom, peck, clearance, out)?;
                }
            }
            self.go(at(clear), Pace::Withdrawal)?;
        }
        Ok(())
    }

    /// Down by pecks from a place: after each out of the hole and back, or back by a little.
    fn pecks(&mut self, top: Vec3, bottom: f64, peck: f64, clearance: f64, out: bool) -> Result<(), Stop> {
        let at = |z: f64| Vec3::new(top.x, top.y, z);
        let mut reached = top.z;
        while reached > bottom {
            reached = (reached - peck).max(bottom);
            self.go(at(reached), Pace::Feed)?;
            // A rest of a peck that is below what numbers can tell apart would never end.
            if reached <= bottom || reached - peck == reached {
                break;
            }
            if out {
                self.go(at(top.z), Pace::Withdrawal)?;
            }
            let back = (reached + clearance).min(top.z);
            self.go(at(back), Pace::Withdrawal)?;
        }
        Ok(())
    }
}
