//! Where the feet step: one foothold for each footstep, from the ground as it is told to be.
//!
//! A foothold is on a tread, away from edges, as near to its regular place as the support allows: when a leg swings, the centre of mass must be
//! well within the triangle of the three others. A depth-first search goes through the footsteps and takes the last footholds back where a later
//! swing would not be stable. It is done before anything moves.

use nalgebra::{Vector2, Vector3};

use super::footstep::{LEAST, Refused, centre_of_mass};
use super::gait::Gait;
use super::support::margin;
use crate::ground::Ground;
use crate::leg::{Leg, Three};
use crate::places::{NAMES, NEAR, below, stance};

/// Margins that are looked for, the first that there is \[m\]: errors of the ground and of the start take some of it.
const WANTED: [f64; 4] = [0.04, 0.035, 0.03, 0.025];
/// How far a foothold is from an edge at least \[m\].
const EDGE: f64 = 0.05;
/// How far from its regular place a foothold may be, and by how much places are apart \[m\].
const ASTRAY: f64 = 0.08;
const APART: f64 = 0.01;
/// Times at which a swing is looked at.
const LOOKS: u32 = 8;
/// How many footholds are tried for each margin that is looked for.
const TRIES: usize = 4000;

/// The footholds of a crawl [m, W], one for each footstep.
#[derive(Clone, Debug, PartialEq)]
pub struct FootholdPlan {
    holds: Vec<Vector2<f64>>,
}

/// The search for a plan.
struct Search<'a> {
    gait: &'a Gait,
    ground: &'a Ground,
    legs: &'a [Leg; 4],
    wanted: f64,
    tries: usize,
    holds: Vec<Vector2<f64>>,
    /// The farthest footstep that was come to, and why it went no farther.
    farthest: Option<(usize, Refused)>,
}

impl FootholdPlan {
    /// The footholds of this gait on this ground.
    ///
    /// # Errors
    /// The first footstep that has none, or that would be unstable.
    pub fn plan(gait: &Gait, legs: &[Leg; 4], ground: &Ground) -> Result<Self, Refused> {
        let start = stance(gait).map(|foot| foot.xy());
        let mut refused = None;
        for wanted in WANTED.into_iter().chain([LEAST]) {
            let mut search =
                Search { gait, ground, legs, wanted, tries: 0, holds: Vec::new(), farthest: None };
            if search.go_on(0, start) {
                return Ok(Self { holds: search.holds });
            }
            refused = search.farthest.map(|(_, why)| why);
        }
        Err(refused.unwrap_or(Refused::NoFoothold { leg: NAMES[Gait::leg(0)], x: 0.0 }))
    }

    /// A plan of these footholds [m, W].
    #[must_use]
    pub const fn of(holds: Vec<Vector2<f64>>) -> Self {
        Self { holds }
    }

    /// The foothold of a footstep, counted from 0.
    #[must_use]
    pub fn hold(&self, number: usize) -> Option<&Vector2<f64>> {
        self.holds.get(number)
    }
}

/// Where a leg steps by the gait [m, W].
#[must_use]
pub fn regular(gait: &Gait, number: usize) -> Vector2<f64> {
    let place = below(Gait::leg(number), 0.0);
    Vector2::new(place.x + gait.advance(gait.begins(number) + gait.swing) + gait.ahead(), place.y)
}

impl Search<'_> {
    /// Whether there are footholds from this footstep on, with the feet there [m, W]; they are then in `holds`.
    fn go_on(&mut self, number: usize, feet: [Vector2<f64>; 4]) -> bool {
        if number == self.gait.footsteps {
            return true;
        }
        let leg = Gait::leg(number);
        let regular = regular(self.gait, number);
        let least = self.swing(number, leg, &feet);
        if least < self.wanted {
            let x = regular.x;
            self.stopped(number, Refused::Unstable { leg: NAMES[leg], x, margin: least });
            return false;
        }
        let steps = (ASTRAY / APART).round() as i32;
        let mut any = false;
        // The nearest ones first, before and behind in turn.
        for i in (0..=2 * steps).map(|i| if i % 2 == 0 { i / 2 } else { -(i / 2) - 1 }) {
            let at = regular + Vector2::x() * (f64::from(i) * APART);
            if self.ground.lane(at.y).clearance(at.x) < EDGE {
                continue;
            }
            any = true;
            self.tries += 1;
            if self.tries > TRIES {
                return false;
            }
            let mut next = feet;
            next[leg] = at;
            self.holds.push(at);
            if self.go_on(number + 1, next) {
                return true;
            }
            self.holds.pop();
        }
        if !any {
            self.stopped(number, Refused::NoFoothold { leg: NAMES[leg], x: regular.x });
        }
        false
    }

    fn stopped(&mut self, number: usize, why: Refused) {
        if self.farthest.is_none_or(|(farthest, _)| number > farthest) {
            self.farthest = Some((number, why));
        }
    }

    /// The least margin while this leg swings \[m\], as if the ground were level.
    fn swing(&self, number: usize, leg: usize, feet: &[Vector2<f64>; 4]) -> f64 {
        let begins = self.gait.begins(number);
        let standing: [Vector2<f64>; 3] = core::array::from_fn(|i| feet[i + usize::from(i >= leg)]);
        let look = |look: u32| {
            let t = begins + self.gait.swing * f64::from(look) / f64::from(LOOKS);
            let trunk = Vector2::new(self.gait.advance(t), self.gait.aside(t));
            margin(&standing, &(trunk + self.centre(&trunk, feet)))
        };
        (0..=LOOKS).map(look).fold(f64::INFINITY, f64::min)
    }

    /// Where the centre of mass is from the trunk's origin, with the feet there [m, W].
    fn centre(&self, trunk: &Vector2<f64>, feet: &[Vector2<f64>; 4]) -> Vector2<f64> {
        let q: [Three; 4] = core::array::from_fn(|i| {
            let foot = feet[i] - trunk;
            let at = Vector3::new(foot.x, foot.y, -self.gait.height);
            // Where a leg cannot reach so far, the footstep itself is refused.
            self.legs[i].reach_for(&at, &NEAR).unwrap_or(NEAR)
        });
        centre_of_mass(self.legs, &q).xy()
    }
}
