//! What there was to see of a run: margins, slips, forces, falls. It is taken from the world as it truly is, in every servo period.

use mrroc::pose::Pose;
use nalgebra::{Vector2, Vector3};

use crate::leg::Three;
use crate::walk::support::margin;

/// How the machine stands at a time.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Standing {
    /// \[s\].
    pub time: f64,
    /// The trunk.
    pub X_WT: Pose,
    /// Velocity of its origin [m/s, W].
    pub velocity: Vector3<f64>,
    /// Centre of mass of the machine [m, W].
    pub centre: Vector3<f64>,
    /// The feet's middles [m, W].
    pub feet: [Vector3<f64>; 4],
    /// The forces of the ground on them [N, W].
    pub forces: [Vector3<f64>; 4],
    /// How far each has slid in all \[m\].
    pub slid: [f64; 4],
    /// Joint positions \[rad\].
    pub q: [Three; 4],
}

/// A foot bears where the ground pushes it by more than this \[N\].
pub const BEARS: f64 = 1.0;
/// A foot that has been in the air for so long has made a step \[s\].
const AIR: f64 = 0.1;
/// By default every so many servo periods are kept to be drawn.
const KEPT: u64 = 10;

impl Standing {
    /// Whether a foot bears.
    #[must_use]
    pub fn bears(&self, leg: usize) -> bool {
        self.forces[leg].norm() > BEARS
    }

    /// How far the centre of mass is within the polygon of the feet that bear, from above \[m\].
    #[must_use]
    pub fn margin(&self) -> f64 {
        let mut bearing = [Vector2::zeros(); 4];
        let mut count = 0;
        for i in (0..4).filter(|i| self.bears(*i)) {
            bearing[count] = self.feet[i].xy();
            count += 1;
        }
        margin(&bearing[..count], &self.centre.xy())
    }

    /// How far the trunk leans from the level \[rad\].
    #[must_use]
    pub fn lean(&self) -> f64 {
        (self.X_WT.rotation * Vector3::z()).angle(&Vector3::z())
    }

    /// Whether it has fallen: leans by more than 0.35 rad, or is lower than 0.2 m over its highest foot.
    #[must_use]
    pub fn has_fallen(&self) -> bool {
        let highest = self.feet.iter().map(|foot| foot.z).fold(f64::NEG_INFINITY, f64::max);
        let low = self.X_WT.translation.z < highest + 0.2;
        self.lean() > 0.35 || low || !self.centre.iter().all(|x| x.is_finite())
    }
}

/// A step of a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The leg.
    pub leg: usize,
    /// When it left the ground, and when it bore again \[s\].
    pub lifted: f64,
    /// See `lifted`.
    pub landed: f64,
    /// The least margin from one lift of any leg to this one \[m\].
    pub margin: f64,
    /// How far the foot had slid on the ground while it bore, from its landing before to this lift: the length of its path \[m\].
    pub slip: f64,
    /// How far its middle was from where it had landed when it bore last \[m\].
    pub moved: f64,
}

/// What was seen.
#[derive(Clone, Debug)]
pub struct RunMeasurements {
    /// Every tenth period, if it is not told otherwise.
    pub film: Vec<Standing>,
    /// All steps that are over.
    pub steps: Vec<Step>,
    /// The least static margin \[m\].
    pub margin: f64,
    /// The largest lean of the trunk \[rad\].
    pub lean: f64,
    /// Whether it has ever fallen.
    pub fallen: bool,
    /// The largest force on a foot \[N\].
    pub force: f64,
    kept: u64,
    periods: u64,
    /// When each foot bore last.
    bore: [f64; 4],
    /// Where each landed, and how far it has slid since, while it bore.
    landed: [Vector3<f64>; 4],
    slip: [f64; 4],
    /// Where each was when it bore last, and how far it had slid.
    last: [Vector3<f64>; 4],
    slid: [f64; 4],
    begun: bool,
    since: f64,
}

impl Default for RunMeasurements {
    fn default() -> Self {
        Self {
            film: Vec::new(),
            steps: Vec::new(),
            margin: f64::INFINITY,
            lean: 0.0,
            fallen: false,
            force: 0.0,
            kept: KEPT,
            periods: 0,
            bore: [0.0; 4],
            landed: [Vector3::zeros(); 4],
            slip: [0.0; 4],
            last: [Vector3::zeros(); 4],
            slid: [0.0; 4],
            begun: false,
            since: f64::INFINITY,
        }
    }
}

impl RunMeasurements {
    /// Keeps every period of so many.
    pub const fn keep_every(&mut self, periods: u64) {
        self.kept = periods;
    }

    /// Looks at the end of a servo period.
    pub fn look(&mut self, now: &Standing) {
        if !self.begun {
            self.begun = true;
            self.landed = now.feet;
        }
        if self.periods.is_multiple_of(self.kept) {
            self.film.push(now.clone());
        }
        self.periods += 1;
        let margin = now.margin();
        self.margin = self.margin.min(margin);
        self.since = self.since.min(margin);
        self.lean = self.lean.max(now.lean());
        self.fallen |= now.has_fallen();
        for i in 0..4 {
            self.force = self.force.max(now.forces[i].norm());
            if !now.bears(i) {
                self.slid[i] = now.slid[i];
                continue;
            }
            if now.time - self.bore[i] > AIR {
                let at = self.landed[i];
                let step = Step {
                    leg: i,
                    lifted: self.bore[i],
                    landed: now.time,
                    margin: self.since,
                    slip: self.slip[i],
                    moved: (self.last[i] - at).xy().norm(),
                };
                self.steps.push(step);
                self.since = f64::INFINITY;
                self.landed[i] = now.feet[i];
                self.slip[i] = 0.0;
            }
            self.slip[i] += now.slid[i] - self.slid[i];
            self.bore[i] = now.time;
            self.last[i] = now.feet[i];
            self.slid[i] = now.slid[i];
        }
    }

    /// Mean speed of the trunk along x from the first lift to the last landing [m/s]; 0 without a step.
    #[must_use]
    pub fn speed(&self) -> f64 {
        let (Some(first), Some(last)) = (self.steps.first(), self.steps.last()) else { return 0.0 };
        let at = |time: f64| self.film.iter().find(|standing| standing.time >= time);
        let (Some(from), Some(to)) = (at(first.lifted), at(last.landed)) else { return 0.0 };
        (to.X_WT.translation.x - from.X_WT.translation.x) / (to.time - from.time)
    }

    /// The largest slip of a step \[m\].
    #[must_use]
    pub fn slip(&self) -> f64 {
        self.steps.iter().map(|step| step.slip).fold(0.0, f64::max)
    }
}
