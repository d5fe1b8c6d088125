//! A robot where it stands: its capsules in rigid parts, and how far each may still get.
//!
//! In: joint positions, and by how much they may still move. Out: balls and capsules in the world. Those of a part that is known in a frame are
//! placed when they are first asked for; the others are placed by the outline, each a part of its own.

use std::ops::Range;
use std::sync::Arc;

use mrroc::fault::Name;
use mrroc::pose::Pose;
use nalgebra::{Matrix3, Point3, Vector3};

use super::cover::{self, Node, ROUNDING};
use super::posture::{Joints, Shape};
use crate::models::{Capsule, Link, Motion};

/// The most motions that a robot's outline may have.
pub(super) const MOTIONS: usize = 17;

/// How far a body may still get \[m\] by the motions from the `i`th on.
pub(super) type Travel = [f64; MOTIONS + 1];

/// A node of a part where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// In which posture of the robot it was placed.
    posture: u64,
    pub(super) centre: Vector3<f64>,
    pub(super) around: f64,
    /// The capsule of a leaf, or the ball of a node.
    pub(super) capsule: Capsule,
    /// How far any of its points may still get \[m\] by the motions from the `i`th on.
    pub(super) travel: Travel,
}

impl Placed {
    const NOWHERE: Placed = Placed {
        posture: 0,
        centre: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        around: 0.0,
        capsule: Capsule::new(Vector3::new(f64::NAN, f64::NAN, f64::NAN), Vector3::new(0.0, 0.0, 0.0), 0.0),
        travel: [0.0; MOTIONS + 1],
    };
}

/// How far any point of a capsule that these motions move may get \[m\] by the motions from the `i`th on.
pub(super) fn travel(moved_by: u32, capsule: &Capsule, motions: &[Motion]) -> Travel {
    let mut travel = [0.0; MOTIONS + 1];
    // Seen from now, the last joint moves first; those before carry on what it did.
    for (i, motion) in motions.iter().enumerate().take(MOTIONS).rev() {
        let moved = travel[i + 1];
        let is_moved = moved_by >> i & 1 == 1;
        travel[i] = moved + if is_moved { motion.travel(capsule, moved) } else { 0.0 };
    }
    travel
}

/// Capsules of one link that stand still to one another.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// The nodes of its tree.
    pub(super) nodes: Range<usize>,
    /// One of its links, which stands for all: they have the same name and rank, and the same motions move them.
    pub(super) link: usize,
    /// The number of its frame.
    frame: Option<usize>,
}

/// A robot, what it carries, and where it is.
#[derive(Clone)]
pub(super) struct Placement {
    pub(super) name: Name,
    shape: Arc<dyn Shape>,
    /// The robot's own links, then what it carries.
    pub(super) links: Vec<Link>,
    own: usize,
    /// Capsules in the flange's frame.
    carried: Vec<Capsule>,
    /// The number of the frame of each capsule, and the capsule in it; not of those that the outline places.
    rigid: Vec<(usize, Capsule)>,
    /// In the order of their first links.
    pub(super) parts: Vec<Part>,
    pub(super) nodes: Vec<Node>,
    /// The leaf of each link.
    leaves: Vec<usize>,
    /// The frame of the flange, then those of the outline, and their rotations.
    frames: Vec<Pose>,
    turns: Vec<Matrix3<f64>>,
    motions: Vec<Motion>,
    /// Whether its joints may still move.
    is_moving: bool,
    /// The nodes where they are, or were in an earlier posture.
    placed: Vec<Placed>,
    posture: u64,
}

impl Placement {
    pub(super) fn new(name: Name, shape: Arc<dyn Shape>) -> Self {
        let links = shape.links();
        // The first frame is the flange's.
        let rigid = shape.rigid().unwrap_or_default();
        let rigid = rigid.into_iter().map(|(frame, capsule)| (frame + 1, capsule)).collect();
        let mut placement = Self {
            name,
            shape,
            own: links.len(),
            links,
            carried: Vec::new(),
            rigid,
            parts: Vec::new(),
            nodes: Vec::new(),
            leaves: Vec::new(),
            frames: Vec::new(),
            turns: Vec::new(),
            motions: Vec::with_capacity(MOTIONS),
            placed: Vec::new(),
            is_moving: false,
            posture: 0,
        };
        placement.divide();
        placement
    }

    /// Number of the robot's own links.
    pub(super) const fn own(&self) -> usize {
        self.own
    }

    pub(super) fn shape(&self) -> &Arc<dyn Shape> {
        &self.shape
    }

    /// What it carries, in the flange's frame.
    pub(super) fn carried(&self) -> &[Capsule] {
        &self.carried
    }

    /// Fixes capsules of one body, given in F, to the flange.
    pub(super) fn carry(&mut self, link: &Link, capsules: &[Capsule]) {
        self.links.extend(capsules.iter().map(|_| link.clone()));
        self.carried.extend(capsules);
        self.divide();
    }

    /// Takes away what is carried under this name; whether there was any.
    pub(super) fn drop_carried(&mut self, name: &str) -> bool {
        let before = self.carried.len();
        for i in (self.own..self.links.len()).rev() {
            if &*self.links[i].name == name {
                self.links.remove(i);
                self.carried.remove(i - self.own);
            }
        }
        self.divide();
        self.carried.len() != before
    }

    /// The frame of a link's capsule and the capsule in it, if the outline does not place it.
    fn fixed(&self, link: usize) -> Option<(usize, Capsule)> {
        match link.checked_sub(self.own) {
            Some(carried) => Some((0, *self.carried.get(carried)?)),
            None => self.rigid.get(link).copied(),
        }
    }

    /// Divides the capsules into parts, with a tree over each.
    fn divide(&mut self) {
        let mut of_parts: Vec<Vec<(u32, Capsule)>> = Vec::new();
        self.parts.clear();
        for (i, link) in self.links.iter().enumerate() {
            let number = u32::try_from(i).expect("a robot has fewer than 2^31 capsules");
            let (frame, capsule) = match self.fixed(i) {
                Some((frame, capsule)) => (Some(frame), capsule),
                None => (None, Capsule::new(Vector3::zeros(), Vector3::zeros(), 0.0)),
            };
            let same = |part: &Part| frame.is_some() && part.frame == frame && self.links[part.link] == *link;
            match self.parts.iter().rposition(same) {
                Some(part) => of_parts[part].push((number, capsule)),
                None => {
                    of_parts.push(vec![(number, capsule)]);
                    self.parts.push(Part { nodes: 0..0, link: i, frame });
                }
            }
        }
        self.nodes.clear();
        for (part, capsules) in self.parts.iter_mut().zip(&mut of_parts) {
            let first = self.nodes.len();
            cover::add(&mut self.nodes, capsules);
            part.nodes = first..self.nodes.len();
        }
        self.leaves = vec![0; self.links.len()];
        for (at, node) in self.nodes.iter().enumerate().filter(|(_, node)| node.is_leaf()) {
            self.leaves[node.link as usize] = at;
        }
        // It has stood nowhere with these.
        self.posture = 0;
        self.placed = vec![Placed::NOWHERE; self.nodes.len()];
        self.frames.clear();
    }

    /// Stands the robot at `q`, its joints moving by at most `distances` more; whether it can stand there.
    #[allow(non_snake_case)]
    pub(super) fn stand(&mut self, q: &Joints, distances: Option<&Joints>) -> bool {
        let Self { shape, own, carried, rigid, frames, turns, placed, motions, leaves, parts, nodes, .. } =
            self;
        self.posture += 1;
        frames.clear();
        frames.push(if carried.is_empty() { Pose::identity() } else { shape.flange(q) });
        if rigid.is_empty() {
            let mut count = 0;
            shape.capsules(q, &mut |capsule| {
                if count < *own {
                    placed[leaves[count]].capsule = capsule;
                }
                count += 1;
            });
            if count < *own {
                return false;
            }
        } else {
            shape.link_frames(q, &mut |frame| frames.push(*frame));
        }
        turns.clear();
        // They tell how far boxes reach; a part of one capsule has no box.
        if nodes.len() > parts.len() {
            turns.extend(frames.iter().map(|frame| *frame.rotation.to_rotation_matrix().matrix()));
        }
        self.is_moving = distances.is_some();
        motions.clear();
        if let Some(distances) = distances {
            shape.motions(q, distances, &mut |motion| {
                if motions.len() < MOTIONS {
                    motions.push(motion);
                }
            });
        }
        (0..self.parts.len()).all(|part| {
            let Part { nodes, frame, .. } = &self.parts[part];
            let root = nodes.start;
            if frame.is_some_and(|frame| frame >= self.frames.len()) {
                return false;
            }
            self.place_anew(part, root);
            let Placed { centre, around, travel, .. } = &self.placed[root];
            centre.sum().is_finite() && around.is_finite() && travel[0].is_finite()
        })
    }

    /// A node of a part where it is.
    #[inline]
    pub(super) fn place(&mut self, part: usize, at: usize) -> &Placed {
        if self.placed[at].posture != self.posture {
            self.place_anew(part, at);
        }
        &self.placed[at]
    }

    /// Puts a node to where it is now, and finds how far it may still get.
    #[inline]
    fn place_anew(&mut self, part: usize, at: usize) {
        match self.parts[part].frame {
            Some(frame) => self.move_with(frame, at),
            // The outline has placed its capsule.
            None => {
                let placed = &mut self.placed[at];
                let (centre, around) = placed.capsule.ball();
                (placed.centre, placed.around) = (centre, around + ROUNDING);
            }
        }
        let placed = &mut self.placed[at];
        placed.posture = self.posture;
        if self.is_moving {
            let link = self.nodes[at].link as usize;
            placed.travel = travel(self.links[link].moved_by, &placed.capsule, &self.motions);
        } else if placed.travel[0] != 0.0 {
            placed.travel = [0.0; MOTIONS + 1];
        }
    }

    /// Puts a node to where its frame is.
    #[allow(non_snake_case)]
    fn move_with(&mut self, frame: usize, at: usize) {
        let Some(X_WA) = self.frames.get(frame) else { return };
        let node = &self.nodes[at];
        let fixed = if node.is_leaf() { self.fixed(node.link as usize) } else { None };
        let placed = &mut self.placed[at];
        if let Some((_, capsule)) = fixed {
            placed.capsule = capsule.moved(X_WA);
            placed.centre = 0.5 * (placed.capsule.ends[0] + placed.capsule.ends[1]);
        } else {
            placed.centre = X_WA.transform_point(&Point3::from(node.centre)).coords;
            placed.capsule = Capsule::new(placed.centre, placed.centre, node.radius);
        }
        placed.around = node.radius;
    }

    /// The rotation of a part's frame.
    pub(super) fn turn(&self, part: usize) -> Matrix3<f64> {
        let turn = self.parts[part].frame.and_then(|frame| self.turns.get(frame));
        turn.copied().unwrap_or_else(Matrix3::identity)
    }

    /// The node of a part where it was placed in this posture.
    #[inline]
    pub(super) fn placed(&self, at: usize) -> &Placed {
        &self.placed[at]
    }

    /// The part of a link.
    pub(super) fn part_of(&self, link: usize) -> usize {
        let at = self.leaves[link];
        self.parts.partition_point(|part| part.nodes.end <= at)
    }

    /// The place of the leaf of a link.
    pub(super) fn leaf(&self, link: usize) -> usize {
        self.leaves[link]
    }

    /// The capsule of a link where the robot stands; `None` before it stood anywhere.
    pub(super) fn capsule(&self, link: usize) -> Option<Capsule> {
        match self.fixed(link) {
            Some((frame, capsule)) => Some(capsule.moved(self.frames.get(frame)?)),
            None => (self.posture > 0).then(|| self.placed[self.leaves[link]].capsule),
        }
    }
}

#[cfg(test)]
mod tests;
