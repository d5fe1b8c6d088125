//! A robot in eight postures at once: where its balls are, and how far each of its links may still get.
//!
//! In: joint positions, and by how much each may be off, either way. Out: frames of links, and a bound of the distance that any point
//! of a link is from where it stands: `D_i = D_i+1 + w_i (d_i + D_i+1)` as in [`mrroc_robots::clearance`].
//!
//! Where all joints move together on a line, motions that cancel count as such: a point that passes the middle with velocity `v`, times the
//! time to an end, gets no farther than `|v| + A / 2`. A point `x` behind a joint that turns by `w` has, seen from before the joint, the
//! acceleration `w z x (w z x x) + 2 w z x x' + x''`, so with distances from the axes as above,
//! `A_i = A_i+1 + w_i^2 (d_i + D_i+1) + 2 w_i D_i+1`.
//!
//! An arm whose outline is a [`Chain`] is computed in all lanes together; others posture by posture.

use mrroc::fault::Name;
use mrroc::random::halton;
use mrroc::robot::{JointKind, MAX_JOINTS};
use mrroc_robots::clearance::{Capsule, Chain, Joints, Link, Motion, RobotPart};
use nalgebra::Vector3;

use crate::balls::{Ball, BallTree, around, count, covering};
use crate::lanes::{Frames, LANES, Lanes, Points};

/// Capsules of a robot that move as one body.
#[derive(Clone, Debug)]
pub(crate) struct Limb {
    /// The links, by their numbers.
    pub(crate) links: Vec<usize>,
    /// How many joints of the chain move it.
    pub(crate) joints: usize,
    /// Which motions of the outline move it.
    pub(crate) moved_by: u32,
    /// Balls in the limb's frame; of an arm that is no chain their number alone matters.
    pub(crate) tree: BallTree,
    /// The joints from which on its travel is asked for: bit `i` for the `i`th.
    pub(crate) asked: u32,
}

/// By how much joints may be off a posture, either way.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Around<'a> {
    /// Not at all.
    Nothing,
    /// Each by so much, alone [rad or m, >= 0].
    Box(&'a [Lanes]),
    /// All together by the same share, -1 to 1, of so much [rad or m]: they are on a line.
    Line(&'a [Lanes]),
}

impl<'a> Around<'a> {
    /// Of some of the joints.
    fn of(self, joints: core::ops::Range<usize>) -> Self {
        match self {
            Around::Nothing => Around::Nothing,
            Around::Box(half) => Around::Box(&half[joints]),
            Around::Line(half) => Around::Line(&half[joints]),
        }
    }

    fn half(self) -> Option<&'a [Lanes]> {
        match self {
            Around::Nothing => None,
            Around::Box(half) | Around::Line(half) => Some(half),
        }
    }
}

/// How a limb moves where all joints move together: times the time to either end of the motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sweep {
    /// Velocity of the centre of the ball around it \[m\].
    velocity: Points,
    /// Angular velocity [rad], and its size.
    turn: Points,
    turning: Lanes,
    /// How far acceleration takes any of its points \[m\].
    bend: Lanes,
}

/// A joint of a chain, in single precision.
#[derive(Clone, Copy, Debug)]
struct Joint {
    rotation: [[f32; 3]; 3],
    offset: [f32; 3],
    kind: JointKind,
    leader: usize,
    multiplier: f32,
    zero: f32,
}

#[derive(Clone)]
enum Kinematics {
    Chain(Vec<Joint>),
    /// Any other outline, and how many balls cover each of its capsules.
    Outline(Vec<usize>),
}

/// A robot.
#[derive(Clone)]
pub(crate) struct Arm {
    pub(crate) part: RobotPart,
    /// Its first joint among those of all robots.
    pub(crate) first: usize,
    /// Its first limb among those of all robots.
    pub(crate) first_limb: usize,
    /// How many joints it has.
    pub(crate) joints: usize,
    pub(crate) limbs: Vec<Limb>,
    kinematics: Kinematics,
}

/// In how many postures an arm is tried to stand.
const TRIES: usize = 100;

/// The most motions of an outline.
pub(crate) const MOTIONS: usize = 17;

/// Where an arm stands in each lane.
#[derive(Clone, Default)]
pub(crate) struct Standing {
    /// The limbs whose roots and travel are wanted, and those from the 64th on: bit `i` for the `i`th. Others of a chain stay as they are.
    pub(crate) wanted: u64,
    /// The world, then the frame of each joint of a chain.
    frames: Vec<Frames>,
    /// The balls of each limb of an arm that is no chain.
    placed: Vec<Vec<(Points, Lanes)>>,
    /// The ball around each limb.
    pub(crate) roots: Vec<(Points, Lanes)>,
    /// How far a limb may still get by the motions from the `i`th on \[m\].
    pub(crate) travel: Vec<[Lanes; MOTIONS + 1]>,
    /// How each limb of a chain moves, where all joints move together.
    pub(crate) sweeps: Vec<Sweep>,
}

impl Standing {
    /// Wants a limb.
    pub(crate) fn want(&mut self, limb: usize) {
        self.wanted |= 1u64.checked_shl(limb as u32).unwrap_or(0);
    }

    fn is_wanted(wanted: u64, limb: usize) -> bool {
        wanted.checked_shr(limb as u32).is_none_or(|rest| rest & 1 == 1)
    }
}

impl Arm {
    /// The robot `part`, whose first joint is the `first` of all, and its first limb the `first_limb`.
    pub(crate) fn new(part: RobotPart, first: usize, first_limb: usize) -> Self {
        let joints = part.shape.kinds().len();
        let chain = part.shape.chain();
        let own = part.links.len() - part.carried.len();
        let mut limbs: Vec<Limb> = Vec::new();
        for (i, link) in part.links.iter().enumerate() {
            let last = chain.as_ref().map_or(0, |chain| chain.joints.len());
            let moved =
                chain.as_ref().map_or(0, |chain| chain.bodies.get(i).map_or(last, |body| body.joints));
            let same = |limb: &&mut Limb| {
                let other: &Link = &part.links[limb.links[0]];
                // What is carried is a limb of its own: it comes and goes.
                (limb.links[0] < own) == (i < own)
                    && other.name == link.name
                    && limb.moved_by == link.moved_by
            };
            match limbs.iter_mut().find(same) {
                Some(limb) => limb.links.push(i),
                None => {
                    let tree = BallTree::default();
                    let asked = 1;
                    limbs.push(Limb { links: vec![i], joints: moved, moved_by: link.moved_by, tree, asked });
                }
            }
        }
        let mut arm =
            Arm { part, first, first_limb, joints, limbs, kinematics: Kinematics::Outline(Vec::new()) };
        match chain {
            Some(chain) => arm.take_chain(&chain, own),
            None => arm.take_outline(),
        }
        arm
    }

    fn take_chain(&mut self, chain: &Chain, own: usize) {
        for limb in &mut self.limbs {
            let capsules: Vec<Capsule> = limb
                .links
                .iter()
                .map(|&link| match chain.bodies.get(link).filter(|_| link < own) {
                    Some(body) => body.capsule,
                    None => self.part.carried[link - own].moved(&chain.X_tip),
                })
                .collect();
            limb.tree = BallTree::of(&capsules);
        }
        let joint = |joint: &mrroc_robots::clearance::ChainJoint| {
            let rotation = joint.X_before.rotation.to_rotation_matrix();
            let column = |k: usize| [0, 1, 2].map(|i| rotation[(i, k)] as f32);
            Joint {
                rotation: [column(0), column(1), column(2)],
                offset: [0, 1, 2].map(|i| joint.X_before.translation.vector[i] as f32),
                kind: joint.kind,
                leader: joint.leader,
                multiplier: joint.multiplier as f32,
                zero: joint.offset as f32,
            }
        };
        self.kinematics = Kinematics::Chain(chain.joints.iter().map(joint).collect());
    }

    /// As many balls for each capsule as it needs in the middle of the joints' ranges, or where else the arm can stand: one that is
    /// stretched later is covered by as many larger ones.
    fn take_outline(&mut self) {
        let part = |sample: usize, joint: usize| if sample == 0 { 0.5 } else { halton(sample, joint) };
        let stands = (0..TRIES).find_map(|sample| {
            self.part.capsules(&self.part.shape.between_limits(&|joint| part(sample, joint)))
        });
        let some = Capsule::new(Vector3::zeros(), Vector3::x() * 0.3, 0.05);
        let capsules = stands.unwrap_or_else(|| vec![some; self.part.links.len()]);
        for limb in &mut self.limbs {
            // What is needed of the tree is which node stands above which.
            limb.tree = BallTree::of(&limb.links.iter().map(|&link| capsules[link]).collect::<Vec<_>>());
        }
        self.kinematics = Kinematics::Outline(capsules.iter().map(count).collect());
    }

    /// The joint from which on one of two limbs moves alone.
    pub(crate) fn apart(&self, a: usize, b: usize, since: usize) -> usize {
        match self.kinematics {
            Kinematics::Chain(_) => self.limbs[a].joints.min(self.limbs[b].joints),
            Kinematics::Outline(_) => since,
        }
    }

    /// Stands in all lanes: `q` and `around` are the positions of all robots' joints, and by how much they may be off. How far limbs may get
    /// is known after [`sweep`](Self::sweep).
    #[inline]
    pub(crate) fn stand(&self, q: &[Lanes], around: Around<'_>, standing: &mut Standing) {
        let own = self.first..self.first + self.joints;
        let (q, around) = (&q[own.clone()], around.of(own));
        match &self.kinematics {
            Kinematics::Chain(joints) => self.stand_chain(joints, q, standing),
            Kinematics::Outline(counts) => {
                let sizes = around.half().map(|half| half.iter().map(|half| half.abs()).collect::<Vec<_>>());
                self.stand_outline(counts, q, sizes.as_deref(), standing);
            }
        }
    }

    /// Finds how far limbs may get `around` where it stands.
    #[inline]
    pub(crate) fn sweep(&self, around: Around<'_>, standing: &mut Standing) {
        let around = around.of(self.first..self.first + self.joints);
        if let (Kinematics::Chain(joints), Some(half)) = (&self.kinematics, around.half()) {
            self.sweep_chain(joints, half, matches!(around, Around::Line(_)), standing);
        }
    }

    #[inline]
    fn stand_chain(&self, joints: &[Joint], q: &[Lanes], standing: &mut Standing) {
        let frames = &mut standing.frames;
        frames.clear();
        let mut frame = Frames::world();
        frames.push(frame);
        for joint in joints {
            let origin = frame.place(joint.offset);
            let [x, y, z] = &joint.rotation;
            let [x, y, z] = [frame.direction(*x), frame.direction(*y), frame.direction(*z)];
            frame = Frames { x, y, z, origin };
            let value = q[joint.leader] * joint.multiplier + Lanes::splat(joint.zero);
            match joint.kind {
                JointKind::Revolute => {
                    let (s, c) = value.sin_cos();
                    frame.x = x * c + y * s;
                    frame.y = y * c - x * s;
                }
                JointKind::Prismatic => frame.origin = origin + z * value,
            }
            frames.push(frame);
        }
        let wanted = standing.wanted;
        standing.roots.resize(self.limbs.len(), Default::default());
        for (i, (limb, placed)) in self.limbs.iter().zip(&mut standing.roots).enumerate() {
            if Standing::is_wanted(wanted, i) {
                let root = &limb.tree.nodes[0];
                *placed = (frames[limb.joints].place(root.centre), Lanes::splat(root.radius));
            }
        }
    }

    fn sweep_chain(&self, joints: &[Joint], half: &[Lanes], together: bool, standing: &mut Standing) {
        let wanted = standing.wanted;
        let frames = &standing.frames;
        standing.sweeps.resize(if together { self.limbs.len() } else { 0 }, Sweep::default());
        standing.travel.resize(self.limbs.len(), [Lanes::default(); MOTIONS + 1]);
        for (i, ((limb, travel), (centre, radius))) in
            self.limbs.iter().zip(&mut standing.travel).zip(&standing.roots).enumerate()
        {
            if !Standing::is_wanted(wanted, i) {
                continue;
            }
            let mut moved = Lanes::default();
            let mut bend = Lanes::default();
            let mut sweep = Sweep::default();
            travel[limb.joints] = moved;
            for (j, joint) in joints[..limb.joints].iter().enumerate().rev() {
                let by = half[joint.leader] * joint.multiplier;
                let size = by.abs();
                let axis = frames[j + 1].z;
                match joint.kind {
                    JointKind::Revolute => {
                        let across = axis.cross(*centre - frames[j + 1].origin);
                        let arm = across.squared().sqrt() + *radius + moved;
                        bend = bend + size * (size * arm + moved * 2.0);
                        moved = moved + size * arm;
                        sweep.velocity = sweep.velocity + across * by;
                        sweep.turn = sweep.turn + axis * by;
                    }
                    JointKind::Prismatic => {
                        moved = moved + size;
                        sweep.velocity = sweep.velocity + axis * by;
                    }
                }
                travel[j] = moved;
                if together && limb.asked >> j & 1 == 1 {
                    sweep.turning = sweep.turn.squared().sqrt();
                    // With what rounding may cost where the joints' motions all but cancel.
                    sweep.bend = bend * 0.5 + moved * 1e-5;
                    let swept = sweep.velocity.squared().sqrt() + sweep.turning * *radius + sweep.bend;
                    travel[j] = moved.min(swept);
                }
            }
            if let Some(kept) = standing.sweeps.get_mut(i) {
                *kept = sweep;
            }
        }
    }

    /// How far a ball of a limb may get by all joints, which is at most that of the ball around it \[m\].
    #[inline]
    pub(crate) fn travel(&self, standing: &Standing, limb: usize, centre: Points, radius: Lanes) -> Lanes {
        let travel = standing.travel[limb][0];
        let Some(sweep) = standing.sweeps.get(limb) else { return travel };
        let velocity = sweep.velocity + sweep.turn.cross(centre - standing.roots[limb].0);
        travel.min(velocity.squared().sqrt() + sweep.turning * radius + sweep.bend)
    }

    fn stand_outline(&self, counts: &[usize], q: &[Lanes], half: Option<&[Lanes]>, standing: &mut Standing) {
        let Standing { placed, travel, roots, .. } = standing;
        placed.resize(self.limbs.len(), Vec::new());
        travel.resize(self.limbs.len(), [Lanes::default(); MOTIONS + 1]);
        for (limb, placed) in self.limbs.iter().zip(placed.iter_mut()) {
            placed.clear();
            placed.resize(limb.tree.nodes.len(), (Points::default(), Lanes::splat(f32::NAN)));
        }
        for lane in 0..LANES {
            let of = |values: &[Lanes]| -> Joints {
                core::array::from_fn(|i| values.get(i).map_or(0.0, |value| f64::from(value.lane(lane))))
            };
            let at = of(q);
            // A posture in which it cannot stand keeps balls that are no numbers, which are clear of nothing.
            roots.resize(self.limbs.len(), (Points::default(), Lanes::splat(f32::NAN)));
            let Some(capsules) = self.part.capsules(&at) else { continue };
            for (limb, placed) in self.limbs.iter().zip(placed.iter_mut()) {
                let groups = limb.links.iter().map(|&link| (&capsules[link], counts[link]));
                let balls: Vec<Vec<Ball>> =
                    groups.map(|(capsule, n)| covering(capsule, n).collect()).collect();
                place(&limb.tree, &balls, lane, placed);
            }
            roots.clear();
            roots.extend(placed.iter().map(|placed| placed[0]));
            let Some(half) = half else { continue };
            let mut motions = Vec::with_capacity(MOTIONS);
            self.part.shape.motions(&at, &of(half), &mut |motion| motions.push(motion));
            motions.truncate(MOTIONS);
            for ((limb, travel), placed) in self.limbs.iter().zip(travel.iter_mut()).zip(placed.iter()) {
                let (centre, radius) = &placed[0];
                let centre = Vector3::from(centre.0.map(|x| f64::from(x.lane(lane))));
                let mut moved = 0.0;
                travel[motions.len()].set(lane, 0.0);
                for (i, motion) in motions.iter().enumerate().rev() {
                    if limb.moved_by >> i & 1 == 1 {
                        moved += moved_by(motion, &centre, f64::from(radius.lane(lane)), moved);
                    }
                    travel[i].set(lane, moved as f32);
                }
            }
        }
    }

    /// The frame of a limb; none of an arm that is no chain.
    #[inline]
    pub(crate) fn frame<'a>(&self, standing: &'a Standing, limb: usize) -> Option<&'a Frames> {
        match self.kinematics {
            Kinematics::Chain(_) => standing.frames.get(self.limbs[limb].joints),
            Kinematics::Outline(_) => None,
        }
    }

    /// The ball of a node of a limb.
    #[inline(always)]
    pub(crate) fn ball(&self, standing: &Standing, limb: usize, node: usize) -> (Points, Lanes) {
        match self.kinematics {
            Kinematics::Chain(_) => {
                let limb = &self.limbs[limb];
                let node = &limb.tree.nodes[node];
                (standing.frames[limb.joints].place(node.centre), Lanes::splat(node.radius))
            }
            Kinematics::Outline(_) => standing.placed[limb][node],
        }
    }

    /// Its name.
    pub(crate) fn name(&self) -> Name {
        self.part.name
    }

    /// Of the joints of all robots, those of this one.
    pub(crate) fn own<T: Copy + Default>(&self, all: &[T]) -> [T; MAX_JOINTS] {
        core::array::from_fn(|i| if i < self.joints { all[self.first + i] } else { T::default() })
    }
}

/// How far a ball may get by a motion, when those behind it may have moved it by `moved` \[m\].
fn moved_by(motion: &Motion, centre: &Vector3<f64>, radius: f64, moved: f64) -> f64 {
    match motion {
        Motion::Slide { bound } => *bound,
        Motion::Turn { point, axis, bound } => {
            let from = centre - point;
            let arm = axis.map_or(from, |axis| from.cross(&axis)).norm();
            bound * (arm + radius + moved)
        }
    }
}

/// Places the balls of a limb's capsules, and those around them, in one lane of the nodes of a tree of the same shape.
fn place(tree: &BallTree, balls: &[Vec<Ball>], lane: usize, placed: &mut [(Points, Lanes)]) {
    let mut set = |node: usize, ball: &Ball| {
        for (i, lanes) in placed[node].0.0.iter_mut().enumerate() {
            lanes.set(lane, ball.centre[i] as f32);
        }
        placed[node].1.set(lane, (ball.radius + 1e-6 * (1.0 + ball.centre.norm())) as f32);
    };
    // Nodes stand before what is below them, so from the last to the first what is below is known.
    let mut below: Vec<Option<Ball>> = vec![None; tree.nodes.len()];
    for (root, balls) in tree.roots.iter().zip(balls) {
        let mut leaf = *root as usize;
        for ball in balls {
            while tree.nodes.get(leaf).is_some_and(|node| node.second != 0) {
                leaf += 1;
            }
            if let Some(place) = below.get_mut(leaf) {
                *place = Some(*ball);
            }
            leaf += 1;
        }
    }
    for node in (0..tree.nodes.len()).rev() {
        let second = tree.nodes[node].second as usize;
        if second != 0 {
            let both: Vec<Ball> = [node + 1, second].into_iter().filter_map(|child| below[child]).collect();
            below[node] = (!both.is_empty()).then(|| around(&both));
        }
        if let Some(ball) = &below[node] {
            set(node, ball);
        }
    }
}
