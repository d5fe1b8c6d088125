//! Which boxes of joint positions are proven clear: many of them at once, down the trees of balls.
//!
//! In: boxes, and which pairs are looked at. Out: in which boxes not all of these are proven apart, wherever the joints are. The proof is that of
//! [`check`](crate::check). Two nodes that are proven apart in a box need no second look in its halves; the others are looked at from there on, not
//! from the roots of their trees. A box that one pair does not prove is halved anyway, so no other pair is looked at in it.

use crate::arm::{Around, Standing};
use crate::balls::Node;
use crate::check::{Among, Checker};
use crate::lanes::{Frames, LANES, Lanes, Mask, Points};
use crate::pairing::{Against, Pairing};
use crate::plane::{farthest, find};

/// Where fewer nodes are below the first child of a node, no plane is looked for: to compare them takes less.
const FEW: u32 = 16;

/// Which boxes: bit `i` for the `i`th.
pub(crate) type Boxes = u64;

/// Two nodes of the trees of a pair, and the boxes in which what is below them is not proven apart. Against an obstacle the second one is 0.
#[derive(Clone, Copy, Debug)]
struct Open {
    pair: u32,
    nodes: [u32; 2],
    boxes: Boxes,
}

/// A proof for some pairs.
pub(crate) struct Proof {
    pub(crate) among: Among,
    pairs: Vec<u32>,
    /// Where the arms stand, eight boxes after the other.
    standing: Vec<Vec<Standing>>,
    batches: usize,
    /// The pair whose first limb is taken relative to the second one; for each eight boxes its frames so, and how much is taken off the distance.
    relative_of: Option<u32>,
    relative: Vec<(Frames, Lanes)>,
    /// Directions of length 1, along which limbs of each pair were last found apart, relative to the second one.
    directions: Vec<[f32; 3]>,
    /// For each eight boxes what a direction is relative to the first limb, and what its points must be beyond along it.
    planes: Vec<(Points, Lanes)>,
    rising: Vec<(u32, Boxes)>,
    open: Vec<Open>,
    /// What stays open; those that left boxes unproven, and the others.
    failed: Vec<Open>,
    kept: Vec<Open>,
    stack: Vec<([u32; 2], Boxes)>,
    near: Vec<Mask>,
    q: Vec<Lanes>,
    half: Vec<Lanes>,
}

impl Proof {
    /// Of the pairs among these.
    pub(crate) fn new(checker: &Checker, among: Among) -> Self {
        let pairs = 0..checker.pairings.len() as u32;
        let joints = checker.offset.len();
        Proof {
            among,
            pairs: pairs.filter(|pair| among.has(&checker.pairings[*pair as usize])).collect(),
            standing: Vec::new(),
            batches: 0,
            relative_of: None,
            relative: Vec::new(),
            directions: vec![[1.0, 0.0, 0.0]; checker.pairings.len()],
            planes: Vec::new(),
            rising: Vec::new(),
            open: Vec::new(),
            failed: Vec::new(),
            kept: Vec::new(),
            stack: Vec::new(),
            near: Vec::new(),
            q: vec![Lanes::default(); joints],
            half: vec![Lanes::default(); joints],
        }
    }

    /// Begins with `count` boxes; `place` tells the middle of the positions of a joint in a box, and by how much they are off it at
    /// most [rad or m]. Those that are not proven clear.
    pub(crate) fn begin(
        &mut self,
        checker: &Checker,
        count: usize,
        place: impl Fn(usize, usize) -> [f64; 2],
    ) -> Boxes {
        self.open.clear();
        self.stand(checker, count, place, |_, _| true);
        let boxes = Boxes::MAX >> (Boxes::BITS as usize - count);
        // Which obstacles the limbs of the arm may come near in any of the boxes: only one that is alone is compared with them.
        self.near.clear();
        if let Among::Alone(arm) = self.among {
            for standing in &self.standing[..self.batches] {
                let mut near = Vec::new();
                checker.near_obstacles(arm, &standing[arm], true, &mut near);
                self.near.resize(near.len(), 0);
                self.near.iter_mut().zip(near).for_each(|(all, near)| *all |= near);
            }
        }
        for &pair in &self.pairs {
            let pairing = &checker.pairings[pair as usize];
            if let (Against::Obstacle(body), Among::Alone(_)) = (pairing.against, self.among) {
                let near = self.near[pairing.limb * checker.bounds.len() + body / LANES];
                if near >> (body % LANES) & 1 == 0 {
                    continue;
                }
            }
            self.open.push(Open { pair, nodes: [0, 0], boxes });
        }
        self.look(checker)
    }

    /// Goes on with the two halves of each box that was not proven clear: `place` tells the positions in the first half of the first of them, in its second
    /// half, in the first half of the second, and so on.
    pub(crate) fn go_on(
        &mut self,
        checker: &Checker,
        unproven: Boxes,
        place: impl Fn(usize, usize) -> [f64; 2],
    ) -> Boxes {
        self.open.clear();
        for open in self.failed.drain(..).chain(self.kept.drain(..)) {
            let boxes = halved(open.boxes, unproven);
            if boxes != 0 {
                self.open.push(Open { boxes, ..open });
            }
        }
        let mut wanted = vec![0_u64; checker.arms.len()];
        for open in &self.open {
            let pairing = &checker.pairings[open.pair as usize];
            let bit = |limb: usize| 1_u64.checked_shl(limb as u32).unwrap_or(0);
            wanted[pairing.arm] |= bit(pairing.limb);
            if let Against::Limb(arm, limb) = pairing.against {
                wanted[arm] |= bit(limb);
            }
        }
        self.stand(checker, 2 * unproven.count_ones() as usize, place, |arm, limb| {
            wanted[arm].checked_shr(limb as u32).is_none_or(|rest| rest & 1 == 1)
        });
        self.look(checker)
    }

    /// Stands the arms in all boxes.
    fn stand(
        &mut self,
        checker: &Checker,
        count: usize,
        place: impl Fn(usize, usize) -> [f64; 2],
        is_wanted: impl Fn(usize, usize) -> bool,
    ) {
        let batches = count.div_ceil(LANES);
        self.batches = batches;
        self.relative_of = None;
        let Proof { standing, q, half, among, .. } = self;
        if standing.len() < batches {
            standing.resize(batches, vec![Standing::default(); checker.arms.len()]);
        }
        for (k, standing) in standing.iter_mut().enumerate().take(batches) {
            let looked_at = checker.arms.iter().zip(standing).enumerate();
            for (i, (arm, standing)) in looked_at.filter(|(i, _)| among.has_arm(*i)) {
                for j in arm.first..arm.first + arm.joints {
                    // Lanes that are too many are like the last.
                    let places = core::array::from_fn(|lane| place((LANES * k + lane).min(count - 1), j));
                    q[j] = Lanes::new(places.map(|[middle, _]: [f64; 2]| middle as f32));
                    half[j] = Lanes::new(places.map(|[_, half]| (half * (1.0 + 1e-6)) as f32));
                }
                standing.wanted = 0;
                (0..arm.limbs.len()).filter(|limb| is_wanted(i, *limb)).for_each(|limb| standing.want(limb));
                arm.stand(q, Around::Box(half), standing);
                arm.sweep(Around::Box(half), standing);
            }
        }
    }

    /// Looks at all that is open; in which boxes not all is proven apart.
    fn look(&mut self, checker: &Checker) -> Boxes {
        let mut unproven = 0;
        self.failed.clear();
        self.kept.clear();
        let open = core::mem::take(&mut self.open);
        for open in &open {
            self.look_below(checker, open, &mut unproven);
        }
        self.open = open;
        unproven
    }

    fn look_below(&mut self, checker: &Checker, open: &Open, unproven: &mut Boxes) {
        let pairing = &checker.pairings[open.pair as usize];
        let keep = |nodes, boxes| Open { nodes, boxes, ..*open };
        let idle = open.boxes & *unproven;
        if idle != 0 {
            self.kept.push(keep(open.nodes, idle));
        }
        // Most are far apart, which the balls around them show.
        let near = self.unproven_by_balls(checker, pairing, open.nodes, open.boxes & !idle);
        if near == 0 {
            return;
        }
        let first = &checker.arms[pairing.arm].limbs[pairing.limb].tree.nodes;
        let second = match pairing.against {
            Against::Limb(arm, limb) => &checker.arms[arm].limbs[limb].tree.nodes,
            Against::Obstacle(_) => [].as_slice(),
        };
        let is_rigid = self.relate(checker, open.pair);
        let near = if is_rigid { self.unproven_by_planes(open, [first, second], near) } else { near };
        self.stack.push((open.nodes, near));
        while let Some((nodes, boxes)) = self.stack.pop() {
            let idle = boxes & *unproven;
            if idle != 0 {
                self.kept.push(keep(nodes, idle));
            }
            let boxes = boxes & !idle;
            if boxes == 0 {
                continue;
            }
            let [a, b] = nodes;
            let one = &first[a as usize];
            let two = second.get(b as usize).filter(|node| node.second != 0);
            let children = match two {
                Some(two) if one.second == 0 || one.radius < two.radius => [[a, two.second], [a, b + 1]],
                _ if one.second != 0 => [[one.second, b], [a + 1, b]],
                _ => {
                    *unproven |= boxes;
                    self.failed.push(keep(nodes, boxes));
                    continue;
                }
            };
            for nodes in children.into_iter().filter(|nodes| pairing.has(nodes[0], nodes[1])) {
                let near = if is_rigid {
                    let [one, two] = [&first[nodes[0] as usize], &second[nodes[1] as usize]];
                    self.unproven_relative(one, two, boxes)
                } else {
                    self.unproven_by_balls(checker, pairing, nodes, boxes)
                };
                if near != 0 {
                    self.stack.push((nodes, near));
                }
            }
        }
    }

    /// Takes the first limb of a pair relative to the second one, in all boxes; `false` where these are no limbs with frames.
    fn relate(&mut self, checker: &Checker, pair: u32) -> bool {
        if self.relative_of == Some(pair) {
            return true;
        }
        let pairing = &checker.pairings[pair as usize];
        let Pairing { arm, limb, since, .. } = *pairing;
        let Against::Limb(other_arm, other_limb) = pairing.against else { return false };
        let margin = Lanes::splat(checker.kept_apart(pairing));
        self.relative_of = None;
        self.relative.clear();
        for standing in &self.standing[..self.batches] {
            let [one, other] = [&standing[arm], &standing[other_arm]];
            let frames =
                (checker.arms[arm].frame(one, limb), checker.arms[other_arm].frame(other, other_limb));
            let (Some(frame), Some(beside)) = frames else { return false };
            let far = margin + one.travel[limb][since] + other.travel[other_limb][since];
            self.relative.push((frame.relative_to(beside), far));
        }
        self.relative_of = Some(pair);
        true
    }

    /// As [`unproven_by_balls`](Self::unproven_by_balls), of all that is below two nodes of limbs that are [related](Self::relate): where no plane is found
    /// between them, in some boxes.
    fn unproven_by_planes(&mut self, open: &Open, trees: [&[Node]; 2], boxes: Boxes) -> Boxes {
        let nodes = open.nodes;
        let is_small = |(tree, node): (&[Node], u32)| tree[node as usize].second < node + FEW;
        if trees.into_iter().zip(nodes).any(is_small) {
            return boxes;
        }
        let last = self.directions[open.pair as usize];
        let unproven = self.unproven_along(trees, nodes, last, boxes);
        if unproven == 0 {
            return 0;
        }
        let first = unproven.trailing_zeros() as usize;
        let (frame, far) = &self.relative[first / LANES];
        let lane = first % LANES;
        match find(trees, nodes, frame, lane, far.lane(lane), last) {
            Some(direction) => {
                self.directions[open.pair as usize] = direction;
                self.unproven_along(trees, nodes, direction, unproven)
            }
            None => unproven,
        }
    }

    /// The same along a direction of length 1.
    fn unproven_along(
        &mut self,
        trees: [&[Node]; 2],
        nodes: [u32; 2],
        direction: [f32; 3],
        boxes: Boxes,
    ) -> Boxes {
        let Self { planes, relative, rising, .. } = self;
        let (height, _) = farthest(trees[1], nodes[1], direction);
        planes.clear();
        planes.extend(relative.iter().map(|(frame, far)| {
            let along = Points::splat(direction);
            let slopes = [frame.x, frame.y, frame.z].map(|axis| axis.dot(along));
            (Points(slopes), Lanes::splat(height) + *far - frame.origin.dot(along))
        }));
        let mut unproven = 0;
        rising.push((nodes[0], boxes));
        while let Some((node, boxes)) = rising.pop() {
            let Node { centre, radius, second, .. } = trees[0][node as usize];
            let (centre, radius) = (Points::splat(centre), Lanes::splat(radius));
            let mut below = 0;
            let mut rest = boxes & !unproven;
            while rest != 0 {
                let first = rest.trailing_zeros() as usize / LANES * LANES;
                let mask = (rest >> first) as Mask;
                let (slopes, least) = &planes[first / LANES];
                below |= Boxes::from(mask & !slopes.dot(centre).above(*least + radius)) << first;
                rest &= !(Boxes::from(Mask::MAX) << first);
            }
            if second == 0 {
                unproven |= below;
            } else if below != 0 {
                rising.extend([(second, below), (node + 1, below)]);
            }
        }
        unproven
    }

    /// As [`unproven_by_balls`](Self::unproven_by_balls), of nodes of limbs that are [related](Self::relate).
    #[inline]
    fn unproven_relative(&self, one: &Node, two: &Node, boxes: Boxes) -> Boxes {
        let radius = Lanes::splat(one.radius + two.radius);
        let centre = Points::splat(two.centre);
        let mut unproven = 0;
        let mut rest = boxes;
        while rest != 0 {
            let first = rest.trailing_zeros() as usize / LANES * LANES;
            let mask = (rest >> first) as Mask;
            let (frame, far) = &self.relative[first / LANES];
            let far = radius + *far;
            let clear = (frame.place(one.centre) - centre).squared().above(far * far);
            unproven |= Boxes::from(mask & !clear) << first;
            rest &= !(Boxes::from(Mask::MAX) << first);
        }
        unproven
    }

    /// In which of some boxes the balls of two nodes are not proven apart.
    fn unproven_by_balls(
        &self,
        checker: &Checker,
        pairing: &Pairing,
        [a, b]: [u32; 2],
        boxes: Boxes,
    ) -> Boxes {
        let Pairing { arm, limb, since, .. } = *pairing;
        let margin = Lanes::splat(checker.kept_apart(pairing));
        let mut unproven = 0;
        for (k, standing) in self.standing[..self.batches].iter().enumerate() {
            let mask = (boxes >> (LANES * k)) as Mask;
            if mask == 0 {
                continue;
            }
            let one = &standing[arm];
            let (p, r) = checker.arms[arm].ball(one, limb, a as usize);
            let apart = r + margin + one.travel[limb][since];
            let clear = match pairing.against {
                Against::Obstacle(body) => checker.bodies[body].clear_of(p, apart),
                Against::Limb(other_arm, other_limb) => {
                    let other = &standing[other_arm];
                    let (q, s) = checker.arms[other_arm].ball(other, other_limb, b as usize);
                    let far = apart + s + other.travel[other_limb][since];
                    (p - q).squared().above(far * far)
                }
            };
            unproven |= Boxes::from(mask & !clear) << (LANES * k);
        }
        unproven
    }
}

/// Those of some boxes that are among `parted`, as their halves: of the `i`th of these the boxes `2 i` and `2 i + 1`.
fn halved(boxes: Boxes, parted: Boxes) -> Boxes {
    let mut halves = 0;
    let mut rest = parted;
    let mut i = 0;
    while rest != 0 {
        if boxes & rest & rest.wrapping_neg() != 0 {
            halves |= 3 << (2 * i);
        }
        rest &= rest - 1;
        i += 1;
    }
    halves
}

#[cfg(test)]
mod tests {
    use mrroc::random::Random;
    use mrroc_robots::clearance::Capsule;
    use nalgebra::Vector3;

    use super::*;
    use crate::lanes::ALL;
    use crate::usage::cells::{stopping, two_arms};

    #[test]
    fn what_is_proven_of_arms_that_hold_bodies_of_many_capsules_is_what_a_check_proves_pair_by_pair() {
        let mut clearance = two_arms().build(stopping()).expect("a clearance");
        let capsule = |i: i32| {
            let at = Vector3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) * 0.03;
            Capsule::new(at, at + Vector3::x() * 0.02, 0.015)
        };
        let body: Vec<Capsule> = (0..75).map(capsule).collect();
        for robot in ["left", "right"] {
            clearance.grasp(robot, "body", &body).expect("a body");
        }
        let mut checker = Checker::new(&clearance);
        let mut proof = Proof::new(&checker, Among::Two(0, 1));
        let mut random = Random::seeded(7);
        let [mut proven, mut unproven] = [0, 0];
        for _ in 0..4000 {
            let joints: Vec<f64> = (0..12).map(|_| random.within(2.0)).collect();
            let places: Vec<Vec<[f64; 2]>> = (0..LANES)
                .map(|_| joints.iter().map(|q| [q + random.within(0.05), 0.05 * random.unit()]).collect())
                .collect();
            let lanes = |i: usize, more: f64| -> Vec<Lanes> {
                let of = |j: usize| places.iter().map(move |place| (place[j][i] * more) as f32);
                let lanes = |j| Lanes::new(core::array::from_fn(|lane| of(j).nth(lane).unwrap_or_default()));
                (0..12).map(lanes).collect()
            };
            checker.among = Among::Two(0, 1);
            let (q, half) = (lanes(0, 1.0), lanes(1, 1.0 + 1e-6));
            let verdict = checker.check(&q, Around::Box(&half), ALL);
            if verdict.clear != ALL {
                continue;
            }
            let left = proof.begin(&checker, LANES, |part, j| places[part][j]) as Mask;
            assert_eq!(verdict.proven, !left);
            [proven, unproven] = [proven + left.count_zeros(), unproven + left.count_ones()];
        }
        assert!(proven > 1000 && unproven > 300, "{proven} {unproven}");
    }

    #[test]
    fn boxes_that_are_parted_have_two_halves_each_in_their_order() {
        // Boxes 1, 3 and 4 are parted: their halves are 0 and 1, 2 and 3, 4 and 5. Box 2 is not.
        assert_eq!(halved(0b0_1110, 0b1_1010), 0b00_1111);
        assert_eq!(halved(0b1_0000, 0b1_1010), 0b11_0000);
    }
}
