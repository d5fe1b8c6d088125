//! Links of a robot in clusters of neighbours, with the pairs between two clusters: where those are far apart, so are all pairs.
//!
//! In: links where they stand in one posture, and pairs of them. Out: the pairs, cluster by cluster, and in every posture a ball around each
//! cluster.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::posture::{Placed, Placement};

/// The most links of a cluster.
const MOST: usize = 8;

/// The clusters of a robot's links.
pub(super) struct Clusters {
    members: Vec<Vec<usize>>,
}

/// A pair of links: its number among all pairs, and theirs.
pub(super) type Numbered = (usize, [usize; 2]);

/// Pairs of links of two clusters, or within one.
pub(super) struct Group {
    /// Both clusters.
    pub(super) sides: [usize; 2],
    /// The pairs that are looked at.
    pub(super) pairs: Vec<Numbered>,
    /// Whether all of them are known to be apart in some posture.
    pub(super) all_apart: bool,
}

/// A ball around a cluster: centre and radius \[m\].
pub(super) type Around = (Vector3<f64>, f64);

impl Clusters {
    /// Links that the same motions move, in clusters of neighbours where they stand now.
    pub(super) fn new(placement: &Placement) -> Self {
        let mut together = BTreeMap::<u32, Vec<usize>>::new();
        for (i, link) in placement.links.iter().enumerate() {
            together.entry(link.moved_by).or_default().push(i);
        }
        let (mut left, mut members): (Vec<_>, _) = (together.into_values().collect(), Vec::new());
        while let Some(mut links) = left.pop() {
            if links.len() <= MOST {
                members.push(links);
                continue;
            }
            // In two, across the longest side of the box around the centres.
            let centre = |link: &usize| placement.placed[*link].centre;
            let corner = |pick: fn(f64, f64) -> f64| {
                links.iter().map(centre).reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default()
            };
            let side = (corner(f64::max) - corner(f64::min)).imax();
            links.sort_by(|a, b| centre(a)[side].total_cmp(&centre(b)[side]));
            left.push(links.split_off(links.len() / 2));
            left.push(links);
        }
        Self { members }
    }

    /// Pairs of links by their clusters.
    pub(super) fn groups(&self, pairs: &[Numbered]) -> Vec<Group> {
        let mut cluster_of = BTreeMap::new();
        for (cluster, links) in self.members.iter().enumerate() {
            cluster_of.extend(links.iter().map(|link| (*link, cluster)));
        }
        let mut groups = BTreeMap::<[usize; 2], Vec<Numbered>>::new();
        for (pair, links) in pairs {
            let sides = links.map(|link| *cluster_of.get(&link).expect("every link is in a cluster"));
            groups.entry(sides).or_default().push((*pair, *links));
        }
        let group = |(sides, pairs)| Group { sides, pairs, all_apart: false };
        groups.into_iter().map(group).collect()
    }

    /// The ball around each cluster where the links stand now.
    pub(super) fn around(&self, placed: &[Placed]) -> Vec<Around> {
        let ball = |links: &Vec<usize>| {
            let sum: Vector3<f64> = links.iter().map(|link| placed[*link].centre).sum();
            let centre = sum / links.len() as f64;
            let far = |link: &usize| (placed[*link].centre - centre).norm() + placed[*link].around;
            (centre, links.iter().map(far).fold(0.0, f64::max))
        };
        self.members.iter().map(ball).collect()
    }
}
