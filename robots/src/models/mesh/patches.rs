//! The triangles of a mesh in patches, each of which lies in one capsule of a cover.
//!
//! A capsule is convex: it holds a patch that is a triangle if it holds its three corners. That is all of the proof that a surface is covered,
//! however large the patches are; small ones can be told apart better.

use nalgebra::Vector3;

use crate::models::shape::Capsule;

/// By how much of its radius a corner must be inside a capsule: round-off.
const ROUND_OFF: f64 = 1e-9;

/// A triangle of the surface, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patch {
    pub(super) corners: [Vector3<f64>; 3],
    /// Its area \[m²\], > 0.
    pub(super) area: f64,
    /// What it counts for, > 0.
    pub(super) weight: f64,
}

impl Patch {
    pub(super) fn of(corners: [Vector3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        Self { corners, area, weight: area }
    }

    pub(super) fn centre(&self) -> Vector3<f64> {
        self.corners.iter().sum::<Vector3<f64>>() / 3.0
    }

    /// The direction across it, of length 1; either of the two.
    pub(super) fn normal(&self) -> Option<Vector3<f64>> {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a)).try_normalize(0.0)
    }

    /// Its two halves, cut across its longest edge, and the length of that \[m\].
    pub(super) fn halves(&self) -> ([Self; 2], f64) {
        let length = |i: usize| (self.corners[(i + 1) % 3] - self.corners[i]).norm();
        let longest = (1..3).fold(0, |best, i| if length(i) > length(best) { i } else { best });
        let [a, b, c] = [longest, longest + 1, longest + 2].map(|i| self.corners[i % 3]);
        let middle = (a + b) * 0.5;
        let half = |corners| Self { weight: 0.5 * self.weight, ..Self::of(corners) };
        ([half([a, middle, c]), half([middle, b, c])], length(longest))
    }
}

/// Patches cut into parts whose edges are at most `edge` \[m\] long, as far as `most` parts go.
pub(super) fn cut(mut open: Vec<Patch>, edge: f64, most: usize) -> Vec<Patch> {
    let mut small = Vec::new();
    while !open.is_empty() {
        let mut next = Vec::new();
        for patch in &open {
            let (halves, longest) = patch.halves();
            if longest <= edge { small.push(*patch) } else { next.extend(halves) }
        }
        if small.len() + next.len() > most {
            small.append(&mut next);
        }
        open = next;
    }
    small
}

/// A capsule, made ready to be asked whether it holds points.
pub(super) struct Holder {
    from: Vector3<f64>,
    along: Vector3<f64>,
    /// 1 by the square of its length, 0 of a ball.
    inverse: f64,
    /// The radius \[m\], less round-off, and its square.
    radius: f64,
    square: f64,
}

impl Holder {
    pub(super) fn of(capsule: &Capsule) -> Self {
        let along = capsule.ends[1] - capsule.ends[0];
        let square = along.norm_squared();
        let inverse = if square > 0.0 { 1.0 / square } else { 0.0 };
        let radius = capsule.radius * (1.0 - ROUND_OFF);
        Self { from: capsule.ends[0], along, inverse, radius, square: radius * radius }
    }

    pub(super) fn holds(&self, patch: &Patch) -> bool {
        patch.corners.iter().all(|corner| self.square_from(corner) <= self.square)
    }

    /// Whether it meets a ball.
    fn is_near(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let apart = self.radius + radius;
        self.square_from(centre) <= apart * apart
    }

    /// The square of the distance of a point from the segment \[m²\].
    fn square_from(&self, point: &Vector3<f64>) -> f64 {
        let to = point - self.from;
        let part = (to.dot(&self.along) * self.inverse).clamp(0.0, 1.0);
        (to - self.along * part).norm_squared()
    }
}

/// Patches in groups of neighbours, each with a ball around it, so that a capsule need not be compared with all.
pub(super) struct Groups {
    patches: Vec<Patch>,
    /// Centre and radius \[m\] of a ball around each group.
    balls: Vec<(Vector3<f64>, f64)>,
}

/// Most patches of a group.
const GROUP: usize = 48;

impl Groups {
    /// These patches, in their order, of which neighbours should stand together.
    pub(super) fn of(patches: Vec<Patch>) -> Self {
        let ball = |group: &[Patch]| {
            let centre = group.iter().map(Patch::centre).sum::<Vector3<f64>>() / group.len() as f64;
            let corners = group.iter().flat_map(|patch| patch.corners);
            let square = corners.map(|corner| (corner - centre).norm_squared()).fold(0.0, f64::max);
            (centre, square.sqrt())
        };
        let balls = patches.chunks(GROUP).map(ball).collect();
        Self { patches, balls }
    }

    pub(super) fn all(&self) -> &[Patch] {
        &self.patches
    }

    pub(super) fn into_all(self) -> Vec<Patch> {
        self.patches
    }

    /// What the patches that a capsule holds count for.
    pub(super) fn gain(&self, capsule: &Capsule) -> f64 {
        let holder = Holder::of(capsule);
        let groups = self.patches.chunks(GROUP).zip(&self.balls);
        let near = groups.filter(|(_, (centre, radius))| holder.is_near(centre, *radius));
        near.flat_map(|(group, _)| group).filter(|patch| holder.holds(patch)).map(|patch| patch.weight).sum()
    }

    /// Takes out what a capsule holds.
    pub(super) fn take(&mut self, capsule: &Capsule) -> Vec<Patch> {
        let holder = Holder::of(capsule);
        let (held, left) =
            core::mem::take(&mut self.patches).into_iter().partition(|patch| holder.holds(patch));
        *self = Self::of(left);
        held
    }
}

/// Sorts patches so that neighbours stand together: by large cubes, and in each by small ones.
pub(super) fn sort_by_place(patches: &mut [Patch], edge: f64) {
    let cell = |patch: &Patch, size: f64| patch.centre().map(|x| (x / size).floor() as i64).into();
    patches
        .sort_by_cached_key(|patch| -> [[i64; 3]; 2] { [cell(patch, 16.0 * edge), cell(patch, 4.0 * edge)] });
}
