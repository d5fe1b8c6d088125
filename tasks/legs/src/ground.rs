//! The ground: two lanes of treads, one under the left feet and one under the right ones.
//!
//! In: a place. Out: how high the ground is there, how far edges are, and what a ball touches.
//!
//! ```text
//!            h_k+1  +---------          side view of a lane: x ahead, treads that are level, risers that are upright
//!    h_k            |
//!   ----------------+ e_k
//! ```

use mrroc::random::Random;
use nalgebra::Vector3;

/// One lane.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// Where one tread ends and the next one begins, in order [m, along x].
    pub edges: Vec<f64>,
    /// Height of each tread \[m\]: one more than there are edges.
    pub heights: Vec<f64>,
}

/// Both lanes, which meet at y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// Where y > 0.
    pub left: Lane,
    /// Where y <= 0.
    pub right: Lane,
}

/// Where a ball touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// How far the ball is in the ground \[m\], > 0.
    pub depth: f64,
    /// Unit vector out of the ground.
    pub normal: Vector3<f64>,
}

impl Lane {
    /// The tread at `x`.
    fn tread(&self, x: f64) -> usize {
        self.edges.partition_point(|edge| *edge <= x)
    }

    /// Height at `x` \[m\].
    #[must_use]
    pub fn height(&self, x: f64) -> f64 {
        self.heights[self.tread(x)]
    }

    /// The highest tread between two places \[m\].
    #[must_use]
    pub fn highest(&self, from: f64, to: f64) -> f64 {
        let (from, to) = (self.tread(from.min(to)), self.tread(from.max(to)));
        self.heights[from..=to].iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far the nearest edge is at which the height changes \[m\].
    #[must_use]
    pub fn clearance(&self, x: f64) -> f64 {
        let steps = self.edges.iter().zip(self.heights.windows(2));
        let real = steps.filter(|(_, heights)| (heights[1] - heights[0]).abs() > 1e-9);
        real.map(|(edge, _)| (edge - x).abs()).fold(f64::INFINITY, f64::min)
    }

    /// The point of the ground nearest to a place over it, as (x, z).
    fn nearest(&self, x: f64, z: f64) -> (f64, f64) {
        let middle = self.tread(x);
        let mut best = (x, self.heights[middle]);
        let mut least = (z - best.1).abs();
        let mut look = |at: (f64, f64)| {
            let far = (x - at.0).hypot(z - at.1);
            if far < least {
                (best, least) = (at, far);
            }
        };
        // The risers beside this tread; a ball is smaller than a tread.
        if middle > 0 {
            let (a, b) = (self.heights[middle - 1], self.heights[middle]);
            look((self.edges[middle - 1], z.clamp(a.min(b), a.max(b))));
        }
        if let (Some(edge), Some(next)) = (self.edges.get(middle), self.heights.get(middle + 1)) {
            let here = self.heights[middle];
            look((*edge, z.clamp(here.min(*next), here.max(*next))));
        }
        best
    }
}

impl Ground {
    /// Level ground.
    #[must_use]
    pub fn level() -> Self {
        let lane = Lane { edges: Vec::new(), heights: vec![0.0] };
        Self { left: lane.clone(), right: lane }
    }

    /// Steps by chance: level before `from` \[m\], then treads of 0.26 to 0.4 m with steps of `step` \[m\] up, down or none between
    /// them, for about `length` \[m\]. Treads of one number differ by one step at most, and none is below the start.
    #[must_use]
    pub fn random(from: f64, length: f64, step: f64, chance: &mut Random) -> Self {
        let count = (length / 0.33).ceil() as usize;
        let level = Lane { edges: Vec::new(), heights: vec![0.0] };
        let mut ground = Self { left: level.clone(), right: level };
        let mut at = [from; 2];
        let mut levels = [0_usize; 2];
        for _ in 0..count {
            let next = |level: usize, chance: &mut Random| (level + chance.below(3)).saturating_sub(1);
            let left = next(levels[0], chance);
            let mut right = next(levels[1], chance);
            right = right.clamp(left.saturating_sub(1), left + 1);
            levels = [left, right];
            for (i, lane) in [&mut ground.left, &mut ground.right].into_iter().enumerate() {
                lane.edges.push(at[i]);
                lane.heights.push(levels[i] as f64 * step);
                at[i] += 0.26 + 0.14 * chance.unit();
            }
        }
        ground
    }

    /// The same ground as it truly is: every edge and every tread but the first is off by up to so much \[m\].
    #[must_use]
    pub fn disturbed(mut self, edge: f64, height: f64, chance: &mut Random) -> Self {
        for lane in [&mut self.left, &mut self.right] {
            lane.edges.iter_mut().for_each(|x| *x += chance.within(edge));
            lane.heights.iter_mut().skip(1).for_each(|z| *z += chance.within(height));
        }
        self
    }

    /// The lane at `y`.
    #[must_use]
    pub fn lane(&self, y: f64) -> &Lane {
        if y > 0.0 { &self.left } else { &self.right }
    }

    /// What a ball of this radius at `centre` \[m\] touches.
    #[must_use]
    pub fn touch(&self, centre: &Vector3<f64>, radius: f64) -> Option<Contact> {
        let lane = self.lane(centre.y);
        let floor = lane.height(centre.x);
        if centre.z <= floor {
            // Its middle is in the ground.
            return Some(Contact { depth: radius + floor - centre.z, normal: Vector3::z() });
        }
        let (x, z) = lane.nearest(centre.x, centre.z);
        let out = Vector3::new(centre.x - x, 0.0, centre.z - z);
        let far = out.norm();
        (far < radius).then(|| Contact { depth: radius - far, normal: out / far })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of 20 mm up at 1 m, and down again at 1.3 m.
    fn step() -> Ground {
        let lane = Lane { edges: vec![1.0, 1.3], heights: vec![0.0, 0.02, 0.0] };
        Ground { left: lane.clone(), right: lane }
    }

    #[test]
    fn heights_and_edges_are_those_of_the_treads() {
        let lane = step().left;
        assert_eq!((lane.height(0.99), lane.height(1.0), lane.height(1.31)), (0.0, 0.02, 0.0));
        assert_eq!((lane.highest(1.4, 0.9), lane.highest(1.4, 1.35)), (0.02, 0.0));
        assert!((lane.clearance(1.1) - 0.1).abs() < 1e-15 && (lane.clearance(1.26) - 0.04).abs() < 1e-15);
    }

    #[test]
    fn a_ball_touches_the_tread_the_riser_and_the_edge_along_the_path_to_its_middle() {
        let ground = step();
        let touch = |x, z| ground.touch(&Vector3::new(x, 0.2, z), 0.02);
        assert_eq!(touch(0.5, 0.0201), None);
        let tread = touch(0.5, 0.019).expect("in it");
        assert!((tread.depth - 1e-3).abs() < 1e-15 && tread.normal == Vector3::z());
        // 15 mm before the riser, its middle below the upper tread: the riser pushes back.
        let riser = touch(0.985, 0.0201).expect("against it");
        assert!(
            (riser.normal + Vector3::x()).norm() < 0.01 && (riser.depth - 5e-3).abs() < 1e-4,
            "{riser:?}"
        );
        // 6 mm before the edge and 8 mm over it: 10 mm away.
        let edge = touch(0.994, 0.028).expect("on the edge");
        assert!((edge.depth - 0.01).abs() < 1e-12, "{edge:?}");
        assert!((edge.normal - Vector3::new(-0.6, 0.0, 0.8)).norm() < 1e-12, "{edge:?}");
        let deep = touch(1.1, 0.019).expect("its middle is in the ground");
        assert!((deep.depth - 0.021).abs() < 1e-15 && deep.normal == Vector3::z());
    }

    #[test]
    fn steps_by_chance_are_of_one_height_and_both_lanes_stay_together() {
        for seed in 0..50 {
            let ground = Ground::random(0.5, 2.4, 0.02, &mut Random::seeded(seed));
            for (left, right) in ground.left.heights.iter().zip(&ground.right.heights) {
                assert!((left - right).abs() < 0.021 && *left > -1e-9 && *right > -1e-9);
            }
            for lane in [&ground.left, &ground.right] {
                assert!(lane.edges.windows(2).all(|edges| (0.26..0.401).contains(&(edges[1] - edges[0]))));
                assert!(lane.heights.windows(2).all(|heights| (heights[1] - heights[0]).abs() < 0.041));
            }
        }
    }
}
