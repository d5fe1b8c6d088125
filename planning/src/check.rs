//! Whether robots are clear of everything: in eight postures at once, and all around each of them.
//!
//! In: positions of the joints of all robots, and by how much each may be off, either way. Out: for each posture whether **all**
//! positions within that are proven clear by the margins ([`Verdict::proven`]), and whether the posture itself is
//! ([`Verdict::clear`]). The proof is the one of [`mrroc_robots::clearance`]: no point of a link gets farther than its travel `D`,
//! so balls that are `D` larger and still apart are apart wherever the joints are.
//!
//! Single precision: what rounding may cost is added to every distance ([`ROUNDING`]).

use std::sync::Arc;

use mrroc_robots::clearance::{Capsule, Clearance, Obstacle};
use nalgebra::Vector3;

use crate::arm::{Arm, Around, Standing};
use crate::balls::BallTree;
use crate::lanes::{ALL, LANES, Lanes, Mask, Points};
use crate::pairing::{Against, Pairing, pairings};
use crate::plane::DEPTH;
use crate::upright::Uprights;

/// What the rounding of positions in single precision may cost \[m\]: a few units in the last place at some ten metres.
const ROUNDING: f32 = 2e-5;

/// Which pairs are checked. Only the arms of these pairs are looked at; the others may be anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Among {
    /// All.
    All,
    /// Those of one arm with obstacles and with itself.
    Alone(usize),
    /// Those of one arm, with the other arms as well.
    Of(usize),
    /// Those of one arm with another.
    Two(usize, usize),
}

impl Among {
    pub(crate) fn has_arm(self, arm: usize) -> bool {
        match self {
            Among::All | Among::Of(_) => true,
            Among::Alone(one) => arm == one,
            Among::Two(a, b) => arm == a || arm == b,
        }
    }

    pub(crate) fn has(self, pairing: &Pairing) -> bool {
        let arms = (pairing.arm, pairing.other());
        match self {
            Among::All => true,
            Among::Alone(arm) => arms == (arm, arm),
            Among::Of(arm) => arms.0 == arm || arms.1 == arm,
            Among::Two(a, b) => arms == (a, b) || arms == (b, a),
        }
    }
}

/// An obstacle in single precision.
#[derive(Clone)]
pub(crate) enum Body {
    HalfSpace {
        normal: [f32; 3],
        height: f32,
    },
    Capsule {
        a: [f32; 3],
        along: [f32; 3],
        squared: f32,
        radius: f32,
    },
    Box {
        axes: [[f32; 3]; 3],
        centre: [f32; 3],
        half: [f32; 3],
    },
    Cylinder {
        axis: [f32; 3],
        centre: [f32; 3],
        radius: f32,
        half: f32,
    },
    /// Balls around many capsules.
    Balls(Arc<BallTree>),
    /// Any other, asked posture by posture.
    Other(Obstacle),
}

impl Body {
    fn new(obstacle: &Obstacle) -> Self {
        let single = |v: &Vector3<f64>| [0, 1, 2].map(|i| v[i] as f32);
        match obstacle {
            Obstacle::HalfSpace { normal, height } => {
                Body::HalfSpace { normal: single(normal), height: *height as f32 }
            }
            Obstacle::Capsule(capsule) => Body::capsule(capsule),
            Obstacle::Box { X_WO, half } => {
                let axes = X_WO.rotation.to_rotation_matrix();
                Body::Box {
                    axes: [0, 1, 2].map(|k| [0, 1, 2].map(|i| axes[(i, k)] as f32)),
                    centre: single(&X_WO.translation.vector),
                    half: single(half),
                }
            }
            Obstacle::Cylinder { X_WO, radius, half_length } => Body::Cylinder {
                axis: single(&(X_WO.rotation * Vector3::z())),
                centre: single(&X_WO.translation.vector),
                radius: *radius as f32,
                half: *half_length as f32,
            },
            Obstacle::Bodies(bodies) if let [capsule] = bodies.capsules() => Body::capsule(capsule),
            Obstacle::Bodies(bodies) => Body::Balls(Arc::new(BallTree::standing(bodies.capsules()))),
            Obstacle::Cloud(_) | Obstacle::HeightField(_) => Body::Other(obstacle.clone()),
        }
    }

    fn capsule(capsule: &Capsule) -> Self {
        let single = |v: &Vector3<f64>| [0, 1, 2].map(|i| v[i] as f32);
        let along = capsule.ends[1] - capsule.ends[0];
        Body::Capsule {
            a: single(&capsule.ends[0]),
            along: single(&along),
            squared: along.norm_squared() as f32,
            radius: capsule.radius as f32,
        }
    }

    /// In which lanes a ball of this radius, >= 0, is clear of it.
    #[inline]
    pub(crate) fn clear_of(&self, centre: Points, radius: Lanes) -> Mask {
        match self {
            Body::HalfSpace { normal, height } => {
                (centre.dot(Points::splat(*normal)) - Lanes::splat(*height)).above(radius)
            }
            Body::Capsule { a, along, squared, radius: own } => {
                let from = centre - Points::splat(*a);
                let along = Points::splat(*along);
                let share = if *squared > 0.0 { from.dot(along) * (1.0 / squared) } else { Lanes::default() };
                let share = share.max(Lanes::default()).min(Lanes::splat(1.0));
                let apart = radius + Lanes::splat(*own);
                (from - along * share).squared().above(apart * apart)
            }
            Body::Box { axes, centre: middle, half } => {
                let from = centre - Points::splat(*middle);
                let mut squared = Lanes::default();
                for (axis, half) in axes.iter().zip(half) {
                    let beyond = from.dot(Points::splat(*axis)).abs() - Lanes::splat(*half);
                    let beyond = beyond.max(Lanes::default());
                    squared = squared + beyond * beyond;
                }
                squared.above(radius * radius)
            }
            Body::Cylinder { axis, centre: middle, radius: own, half } => {
                let from = centre - Points::splat(*middle);
                let along = from.dot(Points::splat(*axis));
                let across = (from.squared() - along * along).max(Lanes::default()).sqrt();
                let ends = (along.abs() - Lanes::splat(*half)).max(Lanes::default());
                let side = (across - Lanes::splat(*own)).max(Lanes::default());
                (ends * ends + side * side).above(radius * radius)
            }
            Body::Balls(tree) => {
                let mut hit: Mask = 0;
                let mut stack = [0_u32; DEPTH];
                let mut depth = 1;
                while depth > 0 && hit != ALL {
                    depth -= 1;
                    let at = stack[depth];
                    let node = &tree.nodes[at as usize];
                    let apart = radius + Lanes::splat(node.radius);
                    let near = !(centre - Points::splat(node.centre)).squared().above(apart * apart) & !hit;
                    if node.second == 0 {
                        hit |= near;
                    } else if near != 0 {
                        [stack[depth], stack[depth + 1]] = [node.second, at + 1];
                        depth += 2;
                    }
                }
                !hit
            }
            Body::Other(obstacle) => {
                let mut mask = 0;
                for lane in 0..LANES {
                    let at = Vector3::from(centre.0.map(|x| f64::from(x.lane(lane))));
                    let radius = f64::from(radius.lane(lane));
                    mask |= Mask::from(obstacle.ball_clear(&at, radius)) << lane;
                }
                mask
            }
        }
    }
}

/// What a check of eight postures says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Verdict {
    /// The lanes in which all positions around the posture are clear.
    pub(crate) proven: Mask,
    /// The lanes whose postures themselves are clear.
    pub(crate) clear: Mask,
}

/// Robots and what is around them.
#[derive(Clone)]
pub(crate) struct Checker {
    pub(crate) arms: Vec<Arm>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) pairings: Vec<Pairing>,
    /// Their numbers, in the order in which they are checked.
    order: Vec<u32>,
    standing: Vec<Standing>,
    /// Boxes around the obstacles, eight at a time: their lower and upper corners.
    pub(crate) bounds: Vec<[Points; 2]>,
    /// Which obstacles of each eight a limb may come near, in the last check of all pairs; limb by limb.
    near: Vec<Mask>,
    /// The largest margin of all pairs \[m\].
    margin: f32,
    /// Which pairs are checked at all.
    pub(crate) among: Among,
    /// Whether all of these are listed.
    is_all: bool,
    /// The pairs that are checked; those that are not proven clear in the checks since [`narrow`](Self::narrow).
    listed: Vec<u32>,
    unproven: Vec<bool>,
    /// How much more than the margins is kept \[m\], >= 0.
    pub(crate) more: f32,
    /// What motions keep upright. Stops do not, so it is no part of a check.
    pub(crate) uprights: Uprights,
    /// Whole turns of endless joints that positions in lanes lack, which limits that joints share count \[rad\].
    pub(crate) offset: Vec<f64>,
    /// How many batches of eight it has checked.
    pub(crate) batches: u64,
}

impl Checker {
    /// The robots, obstacles, pairs and margins of a clearance.
    pub(crate) fn new(clearance: &Clearance) -> Self {
        let mut arms = Vec::<Arm>::new();
        let (mut joints, mut limbs) = (0, 0);
        for part in clearance.robot_parts() {
            let arm = Arm::new(part, joints, limbs);
            joints += arm.joints;
            limbs += arm.limbs.len();
            arms.push(arm);
        }
        let bodies: Vec<Body> = clearance.obstacle_parts().map(|(_, obstacle)| Body::new(obstacle)).collect();
        let pairings = pairings(&arms, clearance.checked_pairs());
        for pairing in &pairings {
            if let Against::Limb(other, limb) = pairing.against {
                arms[pairing.arm].limbs[pairing.limb].asked |= 1 << pairing.since;
                arms[other].limbs[limb].asked |= 1 << pairing.since;
            }
        }
        let bounds = bounds(clearance.obstacle_parts().map(|(_, obstacle)| obstacle));
        let margin = pairings.iter().map(|pairing| pairing.margin).fold(0.0, f32::max);
        Checker {
            standing: vec![Standing::default(); arms.len()],
            order: (0..pairings.len() as u32).collect(),
            near: Vec::new(),
            among: Among::All,
            is_all: false,
            listed: Vec::new(),
            unproven: vec![false; pairings.len()],
            more: 0.0,
            uprights: Uprights::default(),
            offset: vec![0.0; joints],
            batches: 0,
            arms,
            bodies,
            pairings,
            bounds,
            margin,
        }
    }

    /// Checks eight postures at `q` [rad or m], and all positions `around` them. Ends as soon as a wanted lane is found not to be clear.
    pub(crate) fn check(&mut self, q: &[Lanes], around: Around<'_>, wanted: Mask) -> Verdict {
        self.list_all();
        self.check_listed(q, around, wanted)
    }

    /// Lists all pairs that are checked.
    pub(crate) fn list_all(&mut self) {
        self.is_all = true;
        self.listed.clear();
        let Checker { listed, order, pairings, among, .. } = self;
        listed.extend(order.iter().filter(|pair| among.has(&pairings[**pair as usize])));
        for standing in &mut self.standing {
            standing.wanted = u64::MAX;
        }
    }

    /// Leaves those on the list that were not proven clear, in any lane, since it was made or narrowed: what was proven for all of some
    /// intervals needs no proof on parts of them.
    pub(crate) fn narrow(&mut self) {
        self.is_all = false;
        let Checker { listed, unproven, pairings, standing, .. } = self;
        for standing in standing.iter_mut() {
            standing.wanted = 0;
        }
        listed.retain(|&pair| {
            let Pairing { arm, limb, against, .. } = pairings[pair as usize];
            let is_left = core::mem::take(&mut unproven[pair as usize]);
            if is_left {
                standing[arm].want(limb);
                if let Against::Limb(arm, limb) = against {
                    standing[arm].want(limb);
                }
            }
            is_left
        });
    }

    /// [`check`](Self::check) of the pairs on the list alone.
    pub(crate) fn check_listed(&mut self, q: &[Lanes], around: Around<'_>, wanted: Mask) -> Verdict {
        self.batches += 1;
        let among = self.among;
        let looked_at = |(i, _): &(usize, (&Arm, &mut Standing))| among.has_arm(*i);
        for (_, (arm, standing)) in self.arms.iter().zip(&mut self.standing).enumerate().filter(looked_at) {
            arm.stand(q, around, standing);
        }
        let all = Verdict { proven: wanted, clear: wanted };
        // Most motions that are not clear hit at once: of all pairs, the postures are checked first, which takes less.
        if self.is_all {
            self.look_around(false);
            let verdict = self.check_pairs(false, all);
            if verdict.clear != wanted || matches!(around, Around::Nothing) {
                return verdict;
            }
        }
        for (_, (arm, standing)) in self.arms.iter().zip(&mut self.standing).enumerate().filter(looked_at) {
            arm.sweep(around, standing);
        }
        if self.is_all {
            self.look_around(true);
        }
        self.check_pairs(true, all)
    }

    /// Checks the listed pairs where the arms stand, with what may move `around` it or not.
    #[inline]
    fn check_pairs(&mut self, moving: bool, mut verdict: Verdict) -> Verdict {
        let wanted = verdict.clear;
        for &listed in &self.listed {
            let i = listed as usize;
            let pairing = &self.pairings[i];
            if self.is_all && self.is_far(pairing) {
                continue;
            }
            let (unproven, hit) = self.compare(pairing, moving, wanted);
            verdict.proven &= !unproven;
            verdict.clear &= !hit;
            self.unproven[i] |= unproven != 0;
            if verdict.clear != wanted {
                // What hits once is likely to hit again: it is asked sooner.
                if let Some(place) = self.order.iter().position(|pair| *pair == listed) {
                    self.order.swap(place, place / 2);
                }
                self.unproven.fill(false);
                break;
            }
        }
        verdict
    }

    /// Finds which obstacles the limbs may come near, in all lanes together.
    fn look_around(&mut self, moving: bool) {
        let mut near = core::mem::take(&mut self.near);
        near.clear();
        for (i, (arm, standing)) in self.arms.iter().zip(&self.standing).enumerate() {
            // Only where it is alone or among all it is compared with obstacles.
            if matches!(self.among, Among::Two(..)) || !self.among.has_arm(i) {
                near.extend(core::iter::repeat_n(0, arm.limbs.len() * self.bounds.len()));
            } else {
                self.near_obstacles(i, standing, moving, &mut near);
            }
        }
        self.near = near;
    }

    /// Adds which obstacles of each eight each limb of an arm may come near, in all lanes together, by boxes around both.
    pub(crate) fn near_obstacles(&self, arm: usize, standing: &Standing, moving: bool, near: &mut Vec<Mask>) {
        let more = self.margin + self.more + ROUNDING;
        for limb in 0..self.arms[arm].limbs.len() {
            let (centre, radius) = standing.roots[limb];
            let travel = if moving { standing.travel[limb][0] } else { Lanes::default() };
            let far = (radius + travel + Lanes::splat(more)).array();
            let mut lower = [f32::INFINITY; 3];
            let mut upper = [f32::NEG_INFINITY; 3];
            let mut is_known = true;
            for (i, lanes) in centre.0.iter().enumerate() {
                for (at, far) in lanes.array().into_iter().zip(far) {
                    is_known &= (at - far).is_finite() && (at + far).is_finite();
                    lower[i] = lower[i].min(at - far);
                    upper[i] = upper[i].max(at + far);
                }
            }
            let (lower, upper) = (Points::splat(lower), Points::splat(upper));
            for [from, to] in &self.bounds {
                let apart = |i: usize| from.0[i].above(upper.0[i]) | lower.0[i].above(to.0[i]);
                let far = if is_known { apart(0) | apart(1) | apart(2) } else { 0 };
                near.push(!far);
            }
        }
    }

    /// What the balls of a pair are kept apart \[m\], with what rounding may cost.
    #[inline]
    pub(crate) fn kept_apart(&self, pairing: &Pairing) -> f32 {
        pairing.margin + self.more + ROUNDING
    }

    /// Whether a limb is far from an obstacle in all lanes.
    #[inline]
    fn is_far(&self, pairing: &Pairing) -> bool {
        match pairing.against {
            Against::Obstacle(body) => {
                let first = (self.arms[pairing.arm].first_limb + pairing.limb) * self.bounds.len();
                self.near[first + body / LANES] >> (body % LANES) & 1 == 0
            }
            Against::Limb(..) => false,
        }
    }

    /// The wanted lanes in which a pair is not proven clear, and in which it hits.
    #[inline]
    fn compare(&self, pairing: &Pairing, moving: bool, wanted: Mask) -> (Mask, Mask) {
        let Pairing { arm, limb, since, .. } = *pairing;
        let margin = Lanes::splat(self.kept_apart(pairing));
        let standing = &self.standing[arm];
        let travel = if moving { standing.travel[limb][since] } else { Lanes::default() };
        let (mut unproven, mut hit) = (0, 0);
        match pairing.against {
            Against::Obstacle(body) => {
                let body = &self.bodies[body];
                // Most are far apart, which the ball around the limb shows.
                let (centre, radius) = standing.roots[limb];
                let wanted = wanted & !body.clear_of(centre, radius + margin + travel);
                if wanted == 0 {
                    return (0, 0);
                }
                let mut stack = [(0u32, 0 as Mask); DEPTH];
                stack[0] = (0, wanted);
                let mut depth = 1;
                while depth > 0 {
                    depth -= 1;
                    let (node, mask) = stack[depth];
                    if !pairing.has(node, 0) {
                        continue;
                    }
                    let (centre, radius) = self.arms[arm].ball(standing, limb, node as usize);
                    let apart = radius + margin;
                    let mut left = mask & !body.clear_of(centre, apart + travel);
                    // Of lanes that are not proven only hits are still wanted.
                    if left & unproven != 0 {
                        left &= !(unproven & body.clear_of(centre, apart));
                    }
                    if left == 0 {
                        continue;
                    }
                    let second = self.arms[arm].limbs[limb].tree.nodes[node as usize].second;
                    if second == 0 {
                        if moving {
                            let travel = self.arms[arm].travel(standing, limb, centre, radius);
                            unproven |= left & !body.clear_of(centre, apart + travel);
                        } else {
                            unproven |= left;
                        }
                        hit |= if moving { left & !body.clear_of(centre, apart) } else { left };
                    } else {
                        stack[depth] = (node + 1, left);
                        stack[depth + 1] = (second, left);
                        depth += 2;
                    }
                }
            }
            Against::Limb(other_arm, other_limb) => {
                let other = &self.standing[other_arm];
                let travel = travel + if moving { other.travel[other_limb][since] } else { Lanes::default() };
                let ((p, r), (q, s)) = (standing.roots[limb], other.roots[other_limb]);
                let far = r + s + margin + travel;
                let wanted = wanted & !(p - q).squared().above(far * far);
                if wanted == 0 {
                    return (0, 0);
                }
                let mut stack = [(0u32, 0u32, 0 as Mask); 2 * DEPTH];
                stack[0] = (0, 0, wanted);
                let mut depth = 1;
                while depth > 0 {
                    depth -= 1;
                    let (a, b, mask) = stack[depth];
                    if !pairing.has(a, b) {
                        continue;
                    }
                    let (p, r) = self.arms[arm].ball(standing, limb, a as usize);
                    let (q, s) = self.arms[other_arm].ball(other, other_limb, b as usize);
                    let squared = (p - q).squared();
                    let apart = r + s + margin;
                    let far = apart + travel;
                    let mut left = mask & !squared.above(far * far);
                    if left & unproven != 0 {
                        left &= !(unproven & squared.above(apart * apart));
                    }
                    if left == 0 {
                        continue;
                    }
                    let [one, two] = [
                        self.arms[arm].limbs[limb].tree.nodes[a as usize],
                        self.arms[other_arm].limbs[other_limb].tree.nodes[b as usize],
                    ];
                    if one.second == 0 && two.second == 0 {
                        unproven |= left;
                        hit |= if moving { left & !squared.above(apart * apart) } else { left };
                    } else if two.second == 0 || (one.second != 0 && one.radius >= two.radius) {
                        stack[depth] = (a + 1, b, left);
                        stack[depth + 1] = (one.second, b, left);
                        depth += 2;
                    } else {
                        stack[depth] = (a, b + 1, left);
                        stack[depth + 1] = (a, two.second, left);
                        depth += 2;
                    }
                }
            }
        }
        (unproven, hit)
    }

    /// Whether joints that share limits allow a posture, in double precision.
    pub(crate) fn is_possible(&self, q: &[f64]) -> bool {
        self.arms.iter().all(|arm| !arm.part.shape.is_coupled() || arm.part.shape.is_possible(&arm.own(q)))
    }

    /// Whether positions, as they are computed with, are within the limits of each joint.
    pub(crate) fn is_within(&self, q: &[f64]) -> bool {
        self.arms.iter().all(|arm| {
            let limits = arm.part.shape.limits();
            (0..arm.joints).all(|j| {
                let at = q[arm.first + j] + self.offset[arm.first + j];
                limits.lower[j] <= at && at <= limits.upper[j]
            })
        })
    }

    /// Whether a posture that joints which share limits allow is clear.
    pub(crate) fn is_clear(&mut self, q: &[f64]) -> bool {
        let lanes: Vec<Lanes> = q.iter().map(|q| Lanes::splat(*q as f32)).collect();
        self.check(&lanes, Around::Nothing, ALL).clear == ALL
    }
}

/// Boxes around obstacles, eight at a time.
fn bounds<'a>(obstacles: impl ExactSizeIterator<Item = &'a Obstacle>) -> Vec<[Points; 2]> {
    let mut bounds = vec![[Points::default(); 2]; obstacles.len().div_ceil(LANES)];
    for (i, obstacle) in obstacles.enumerate() {
        let endless = Vector3::repeat(f64::INFINITY);
        let (lower, upper) = obstacle.bounds().unwrap_or((-endless, endless));
        let [lower, upper] = [lower.map(|at| at as f32 - ROUNDING), upper.map(|at| at as f32 + ROUNDING)];
        for (corner, at) in bounds[i / LANES].iter_mut().zip([lower, upper]) {
            for (lanes, at) in corner.0.iter_mut().zip(&at) {
                lanes.set(i % LANES, *at);
            }
        }
    }
    bounds
}
