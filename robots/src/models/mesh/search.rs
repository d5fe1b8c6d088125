//! The search for capsules: which ones are tried, and how much they cover.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::bound::radius;
use super::grid::Grid;
use super::patches::{Groups, Holder, Patch, cut, sort_by_place};
use super::solid::Solid;
use super::triangles::TriangleMesh;
use crate::models::shape::Capsule;

/// Edge of patches, as a part of the excess \[1\], and as a part of the whole body, where that is more \[1\].
const EDGE: f64 = 0.7;
const EDGE_OF_BODY: f64 = 0.007;

/// Most patches that a mesh is cut into.
const MOST_PATCHES: usize = 80_000;

/// Most centres that capsules are tried through.
const MOST_CENTRES: usize = 1000;

/// Patches by which candidates are compared at first.
const SAMPLE: usize = 500;

/// Candidates that are kept of each centre.
const KEPT: usize = 3;

/// Balls that capsules around a patch are tried through.
const BALLS: usize = 16;

/// What is given away to prove a radius, as a part of the excess \[1\].
const TOLERANCE: f64 = 0.03;

type Ends = [Vector3<f64>; 2];

/// The centre of a ball in the body.
#[derive(Clone, Copy, Debug)]
struct Centre {
    /// Where it is \[m\].
    at: Vector3<f64>,
    /// Its level (`solid.rs`) \[m\], at most 0.
    level: f64,
    /// Along the edge between the two places that the ball touches, if that is a direction.
    along: Option<Vector3<f64>>,
}

impl Centre {
    /// The largest ball around it that is allowed.
    fn ball(&self, excess: f64) -> Capsule {
        Capsule::new(self.at, self.at, excess - self.level)
    }
}

/// A capsule that may be taken, and what it covers that is not yet covered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    ends: Ends,
    gain: f64,
}

/// What a search works on.
pub(super) struct Search {
    solid: Solid,
    grid: Grid,
    excess: f64,
    /// Edge of patches \[m\].
    edge: f64,
    centres: Vec<Centre>,
    /// What is not yet covered.
    open: Groups,
    /// What is covered.
    held: Vec<Patch>,
}

/// Directions in which capsules are tried: edges and diagonals of a cube.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let all = (0..27).map(|i| [i / 9, i / 3 % 3, i % 3].map(|k: i32| f64::from(k - 1)));
    // The first 13 are opposite to the last 13.
    all.skip(14).map(|direction| Vector3::from(direction).normalize())
}

/// The largest gain first.
fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
}

/// Centres of largest balls in the body, and points of its surface where it has no inside.
fn inner_centres(solid: &Solid, patches: &[Patch], excess: f64) -> Vec<Centre> {
    let stride = patches.len().div_ceil(4 * MOST_CENTRES).max(1);
    let mut found: Vec<Centre> = Vec::new();
    for patch in patches.iter().step_by(stride) {
        let centre = patch.centre();
        let sides = patch.normal().into_iter().flat_map(|normal| [normal, -normal]);
        let before = found.len();
        found.extend(sides.filter_map(|normal| {
            let (at, other) = solid.inner_ball(&centre, &normal)?;
            let level = solid.level_below(&at, 0.0).unwrap_or(0.0);
            let across = other.map(|other| (other - at).cross(&(centre - at)));
            // Of balls between two walls that face one another it has no direction.
            let along = across.and_then(|across| across.try_normalize(0.1 * level * level));
            Some(Centre { at, level, along })
        }));
        if found.len() == before {
            found.push(Centre { at: centre, level: 0.0, along: None });
        }
    }
    // Of those that are near one another the deepest is kept.
    found.sort_by(|a, b| a.level.total_cmp(&b.level));
    let mut apart = 0.5 * excess;
    loop {
        let mut cells = BTreeSet::new();
        let cell = |centre: &Vector3<f64>| [0, 1, 2].map(|axis| (centre[axis] / apart).floor() as i64);
        let kept = found.iter().filter(|centre| cells.insert(cell(&centre.at))).copied();
        let kept: Vec<Centre> = kept.collect();
        if kept.len() <= MOST_CENTRES {
            return kept;
        }
        apart *= 1.2;
    }
}

/// Lets patches count for more that few balls hold.
fn weigh(patches: &mut [Patch], centres: &[Centre], excess: f64) {
    let mut counts = vec![1_u32; patches.len()];
    for centre in centres {
        let holder = Holder::of(&centre.ball(excess));
        for (count, patch) in counts.iter_mut().zip(&*patches) {
            *count += u32::from(holder.holds(patch));
        }
    }
    for (count, patch) in counts.into_iter().zip(patches) {
        patch.weight = patch.area / f64::from(count);
    }
}

impl Search {
    pub(super) fn of(mesh: &TriangleMesh, excess: f64) -> Self {
        let bounds = mesh.bounds();
        let edge = (EDGE * excess).max(EDGE_OF_BODY * (bounds[1] - bounds[0]).norm());
        let triangles = mesh.triangles().iter().map(|triangle| Patch::of(mesh.corners(triangle)));
        let solid = Solid::of(mesh);
        let grid = Grid::of(&solid, bounds, excess);
        let mut open = cut(triangles.collect(), edge, MOST_PATCHES);
        sort_by_place(&mut open, edge);
        let centres = inner_centres(&solid, &open, excess);
        weigh(&mut open, &centres, excess);
        Self { solid, grid, excess, edge, centres, open: Groups::of(open), held: Vec::new() }
    }

    /// What is covered.
    pub(super) fn held(&self) -> &[Patch] {
        &self.held
    }

    /// What all that is not covered counts for.
    pub(super) fn worth(&self) -> f64 {
        self.open.all().iter().map(|patch| patch.weight).sum()
    }

    /// How far from `centre` a capsule of this radius may reach, about.
    fn reach(&self, centre: &Vector3<f64>, direction: &Vector3<f64>, radius: f64) -> Vector3<f64> {
        let step = 0.5 * self.grid.spacing();
        let mut end = *centre;
        loop {
            let next = end + direction * step;
            if self.excess - self.grid.level(&next) < radius {
                return end;
            }
            end = next;
        }
    }

    /// The capsule with these ends, its radius about the largest one that is allowed; 0 where none is.
    fn about(&self, [a, b]: Ends) -> Capsule {
        let count = ((b - a).norm() / (0.5 * self.grid.spacing())).ceil().max(1.0);
        let along = (0..=count as usize).map(|i| a + (b - a) * (i as f64 / count));
        let level = along.map(|point| self.grid.level(&point)).fold(f64::NEG_INFINITY, f64::max);
        Capsule::new(a, b, (self.excess - level).max(0.0))
    }

    /// Capsules through a centre: its ball, and long ones of some radii in some directions.
    fn through(&self, Centre { at, level, along }: Centre) -> impl Iterator<Item = Ends> {
        let largest = self.excess - level;
        let radii =
            [largest - 0.15 * self.excess, largest - 0.5 * self.excess, 0.75 * largest, 0.5 * largest];
        let all = along.into_iter().chain(directions());
        let both = all.flat_map(move |direction| radii.map(|radius| (direction, radius)));
        let long = both.map(move |(direction, radius)| {
            [-direction, direction].map(|direction| self.reach(&at, &direction, radius))
        });
        core::iter::once([at; 2]).chain(long)
    }

    /// Candidates through all centres, the best last. Their gains are estimates.
    pub(super) fn pool(&self) -> Vec<Candidate> {
        let stride = self.open.all().len().div_ceil(SAMPLE).max(1);
        let sample = Groups::of(self.open.all().iter().step_by(stride).copied().collect());
        let mut pool = Vec::new();
        for centre in &self.centres {
            let here = self
                .through(*centre)
                .map(|ends| Candidate { ends, gain: stride as f64 * sample.gain(&self.about(ends)) });
            let mut here: Vec<Candidate> = here.collect();
            sort(&mut here);
            pool.extend(here.into_iter().take(KEPT));
        }
        sort(&mut pool);
        pool.reverse();
        pool
    }

    /// The best capsule of the pool, taken out of it and improved, if its gain is above `least`.
    pub(super) fn best(&self, pool: &mut Vec<Candidate>, least: f64) -> Option<Ends> {
        // Gains only become less, so one that is still larger than the next was before is the largest.
        while let Some(mut last) = pool.pop() {
            last.gain = self.open.gain(&self.about(last.ends));
            if pool.last().is_none_or(|next| last.gain >= next.gain) {
                return (last.gain > least).then(|| self.improved(last, None).ends);
            }
            let place = pool.partition_point(|other| other.gain < last.gain);
            pool.insert(place, last);
        }
        None
    }

    /// The candidate with its ends moved as long as that covers more; it must hold a patch, where one is given.
    fn improved(&self, mut best: Candidate, holding: Option<&Patch>) -> Candidate {
        for step in [2.0, 1.0, 0.5].map(|part| part * self.excess) {
            for _ in 0..4 {
                let before = best.gain;
                for (axis, sign) in (0..6).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
                    let mut ends = best.ends;
                    ends[axis / 3][axis % 3] += sign * step;
                    let capsule = self.about(ends);
                    if holding.is_some_and(|patch| !Holder::of(&capsule).holds(patch)) {
                        continue;
                    }
                    let gain = self.open.gain(&capsule);
                    if gain > best.gain {
                        best = Candidate { ends, gain };
                    }
                }
                if best.gain == before {
                    break;
                }
            }
        }
        best
    }

    /// The capsule with these ends, its radius proven.
    pub(super) fn proven(&self, ends: Ends) -> Option<Capsule> {
        let radius = radius(&self.solid, ends, self.excess, TOLERANCE * self.excess)?;
        Some(Capsule { ends, radius })
    }

    /// Marks what a capsule holds as covered; whether that is anything.
    pub(super) fn take(&mut self, capsule: &Capsule) -> bool {
        let taken = self.open.take(capsule);
        let is_some = !taken.is_empty();
        self.held.extend(taken);
        is_some
    }

    /// Cuts what is left into parts that these capsules may hold.
    pub(super) fn refine(&mut self, capsules: &[Capsule]) {
        let left = core::mem::replace(&mut self.open, Groups::of(Vec::new())).into_all();
        self.open = Groups::of(cut(left, 0.5 * self.edge, MOST_PATCHES));
        for capsule in capsules {
            self.take(capsule);
        }
    }

    /// The patch that is hardest to cover.
    pub(super) fn hardest(&self) -> Option<Patch> {
        let hardness = |patch: &Patch| patch.weight / patch.area;
        self.open.all().iter().max_by(|a, b| hardness(a).total_cmp(&hardness(b))).copied()
    }

    /// Cuts a patch into two.
    pub(super) fn split(&mut self, patch: &Patch) {
        let left = core::mem::replace(&mut self.open, Groups::of(Vec::new())).into_all();
        let (mut left, one): (Vec<Patch>, Vec<Patch>) = left.into_iter().partition(|other| other != patch);
        left.extend(one.iter().flat_map(|patch| patch.halves().0));
        self.open = Groups::of(left);
    }

    /// A capsule that holds this patch and much else; `None` where it is too large for those that are tried. A ball of the excess around
    /// its centre is one of them.
    pub(super) fn around(&self, patch: &Patch) -> Option<Capsule> {
        let at = patch.centre();
        let near = self.centres.iter().filter(|centre| (centre.at - at).norm() < self.excess - centre.level);
        let own = Centre { at, level: 0.0, along: None };
        let balls = near.copied().chain([own]).filter_map(|centre| {
            let ball = centre.ball(self.excess);
            Holder::of(&ball).holds(patch).then(|| (self.open.gain(&ball), centre))
        });
        let mut balls: Vec<(f64, Centre)> = balls.collect();
        balls.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut all: Vec<Candidate> = Vec::new();
        for (of_ball, centre) in balls.into_iter().take(BALLS) {
            all.push(Candidate { ends: [centre.at; 2], gain: of_ball });
            for ends in self.through(centre).skip(1) {
                let capsule = self.about(ends);
                if Holder::of(&capsule).holds(patch) {
                    all.push(Candidate { ends, gain: self.open.gain(&capsule) });
                }
            }
        }
        sort(&mut all);
        let improved = all.first().map(|best| self.improved(*best, Some(patch)));
        // The proven radius may be less than what it was about.
        let proven = improved.into_iter().chain(all).filter_map(|one| self.proven(one.ends));
        let own = self.proven([at; 2]);
        proven.chain(own).find(|capsule| Holder::of(capsule).holds(patch))
    }
}
