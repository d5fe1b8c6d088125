//! A tree of boxes over many small things, eight under each node: which of them may be near a segment or a ball.
//!
//! In: the box around each thing. Out: the order in which the things have to be stored, and a search that visits blocks of
//! neighbours, the nearest first, and leaves out what is farther away than what was found. A node is divided at the
//! median along its longest edge, so that all blocks but the last are full. A search allocates nothing.

use nalgebra::Vector3;

use super::bounds::Bounds;

/// Children of a node.
const WIDTH: usize = 8;

/// What is nearer than a nanometre counts as meeting: round-off moves the nearest point of a segment out of a box that it
/// meets \[m²\].
const TOUCHING: f64 = 1e-18;

/// The child is a block of things, not a node.
const BLOCK: u32 = 1 << 31;
/// There is no such child.
const NONE: u32 = u32::MAX;

/// The boxes of a node's children, rounded outwards to single precision, and where they are.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
    children: [u32; WIDTH],
}

impl Node {
    const EMPTY: Node = Node {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [NONE; WIDTH],
    };

    fn set(&mut self, place: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.low[axis][place] = down(bounds.low[axis]);
            self.high[axis][place] = -down(-bounds.high[axis]);
        }
        self.children[place] = child;
    }

    fn bounds(&self, place: usize) -> Bounds {
        let of = |faces: &[[f32; WIDTH]; 3]| Vector3::from_fn(|axis, _| f64::from(faces[axis][place]));
        Bounds { low: of(&self.low), high: of(&self.high) }
    }

    /// The squared distance of each child's box from a box \[m²\], infinite where there is no child.
    fn distances_squared(&self, from: &Bounds) -> [f64; WIDTH] {
        let mut sum = [0.0; WIDTH];
        for axis in 0..3 {
            let (low, high) = (from.low[axis], from.high[axis]);
            for (place, sum) in sum.iter_mut().enumerate() {
                let before = f64::from(self.low[axis][place]) - high;
                let behind = low - f64::from(self.high[axis][place]);
                let apart = before.max(behind).max(0.0);
                *sum += apart * apart;
            }
        }
        sum
    }
}

/// The greatest number of single precision that is not above `x`.
fn down(x: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounded downwards just below")]
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// The tree; its root is the last node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    whole: Bounds,
}

impl Tree {
    /// The tree over things with these boxes, at least one, and the order of the things: block `k` has those from `k size` on.
    pub(super) fn over(boxes: &[Bounds], size: usize) -> (Tree, Vec<u32>) {
        let count = u32::try_from(boxes.len()).expect("what has a tree has at most 2^24 things");
        let mut order: Vec<u32> = (0..count).collect();
        let whole = boxes.iter().fold(Bounds::NOTHING, |all, one| all.and(one));
        let mut tree = Tree { nodes: Vec::new(), whole };
        tree.divide(boxes, &mut order, 0, size);
        (tree, order)
    }

    /// The box around all things.
    pub(super) const fn whole(&self) -> &Bounds {
        &self.whole
    }

    /// Bytes that it holds.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Makes the node over the things of `order`, the first of which is in block `first`, and returns its place.
    fn divide(&mut self, boxes: &[Bounds], order: &mut [u32], first: usize, size: usize) -> u32 {
        // What is below one child when all nodes below it are full.
        let mut share = size;
        while share * WIDTH < order.len() {
            share *= WIDTH;
        }
        split(boxes, order, share);
        let mut node = Node::EMPTY;
        for (place, part) in order.chunks_mut(share).enumerate() {
            let bounds = around(boxes, part);
            let first = first + place * (share / size);
            let child = if share == size {
                BLOCK | u32::try_from(first).expect("as many blocks as things at most")
            } else {
                self.divide(boxes, part, first, size)
            };
            node.set(place, &bounds, child);
        }
        self.nodes.push(node);
        u32::try_from(self.nodes.len() - 1).expect("fewer nodes than things")
    }

    /// Visits the blocks that may have something nearer to a segment than `least` \[m\], the nearest first. `visit` is given a
    /// block and the least distance so far, and returns the least one with that block; minus infinity ends the search.
    pub(super) fn nearest(
        &self,
        segment: &[Vector3<f64>; 2],
        least: f64,
        visit: &mut impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        self.nearest_below(self.nodes.len() - 1, segment, &Bounds::around(segment, 0.0), least, visit)
    }

    fn nearest_below(
        &self,
        node: usize,
        segment: &[Vector3<f64>; 2],
        around: &Bounds,
        mut least: f64,
        visit: &mut impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        let Some(node) = self.nodes.get(node) else { return least };
        // What the segment meets is looked at even where something overlaps it: something else may overlap it more.
        let is_beyond = |squared: f64, least: f64| {
            squared > TOUCHING && squared >= least * least.abs() || least == f64::NEG_INFINITY
        };
        let is_ball = segment[0] == segment[1];
        let mut found = [(0.0, NONE); WIDTH];
        let mut count = 0;
        for (place, squared) in node.distances_squared(around).into_iter().enumerate() {
            if node.children[place] == NONE || is_beyond(squared, least) {
                continue;
            }
            let squared = if is_ball {
                squared
            } else {
                let bounds = node.bounds(place);
                bounds.distance_squared(&bounds.nearest_of(segment))
            };
            if is_beyond(squared, least) {
                continue;
            }
            // Sorted as they come: there are eight at most.
            let mut at = count;
            while at > 0 && found[at - 1].0 > squared {
                found[at] = found[at - 1];
                at -= 1;
            }
            found[at] = (squared, node.children[place]);
            count += 1;
        }
        for (squared, child) in &found[..count] {
            if is_beyond(*squared, least) {
                break;
            }
            least = if child & BLOCK == 0 {
                self.nearest_below(*child as usize, segment, around, least, visit)
            } else {
                visit((child & !BLOCK) as usize, least)
            };
        }
        least
    }

    /// Whether `is_in` is true of a block that reaches within `radius` \[m\] of a point.
    pub(super) fn any(
        &self,
        point: &Vector3<f64>,
        radius: f64,
        is_in: &mut impl FnMut(usize) -> bool,
    ) -> bool {
        let around = Bounds { low: *point, high: *point };
        radius >= 0.0 && self.any_below(self.nodes.len() - 1, &around, radius * radius, is_in)
    }

    fn any_below(
        &self,
        node: usize,
        point: &Bounds,
        squared: f64,
        is_in: &mut impl FnMut(usize) -> bool,
    ) -> bool {
        let Some(node) = self.nodes.get(node) else { return false };
        let distances = node.distances_squared(point);
        for (distance, child) in distances.into_iter().zip(node.children) {
            if distance > squared || child == NONE {
                continue;
            }
            let is_there = if child & BLOCK == 0 {
                self.any_below(child as usize, point, squared, is_in)
            } else {
                is_in((child & !BLOCK) as usize)
            };
            if is_there {
                return true;
            }
        }
        false
    }
}

/// The box around some of the things.
fn around(boxes: &[Bounds], part: &[u32]) -> Bounds {
    part.iter().fold(Bounds::NOTHING, |all, thing| all.and(&boxes[*thing as usize]))
}

/// Orders the things so that each chunk of `share` of them lies together.
fn split(boxes: &[Bounds], order: &mut [u32], share: usize) {
    let chunks = order.len().div_ceil(share);
    if chunks < 2 {
        return;
    }
    let middle = chunks / 2 * share;
    let edges = around(boxes, order);
    let axis = (edges.high - edges.low).imax();
    let place = |thing: &u32| boxes[*thing as usize].low[axis] + boxes[*thing as usize].high[axis];
    // Things in one place keep the order of their numbers: the tree is the same in every run.
    order.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(middle);
    split(boxes, left, share);
    split(boxes, right, share);
}
