//! Optimistic planning: the cheapest path to the goal through what is not known to be wall.
//!
//! ```text
//! nodes      a lattice, eight neighbours; not within the ball's radius and a margin of a sure wall
//! price      length, and for a believed wall its thickness of `price * P(wall)`
//! path       A* (the crate `pathfinding`), then pulled straight where that crosses no more belief
//! ```

use nalgebra::Vector2;
use pathfinding::prelude::astar;

use crate::cells::panels_to;
use crate::contact::{Contact, Knowledge};
use crate::map::Map;
use crate::panels::Panels;
use crate::portals::Portals;
use crate::shortest::Region;
use crate::walls::Place;

/// How paths are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planner {
    /// How far the ball's surface keeps from a sure wall \[m\].
    pub margin: f64,
    /// What trying a place costs where a wall is sure to be, as a length \[m\]: a little more than there and back.
    pub price: f64,
    /// Distance of the nodes of the lattice \[m\].
    pub lattice: f64,
    /// A touch alone is sure to block so far to either side \[m\].
    pub sure: f64,
}

/// What the lattice is made of.
struct Lattice<'m> {
    map: &'m Map,
    columns: i32,
    rows: i32,
    apart: f64,
    blocked: Vec<bool>,
    /// Price per length of path through the node.
    belief: Vec<f32>,
}

/// Micrometres: costs of A* must be whole numbers.
type Cost = u32;

impl Planner {
    /// In mazes that are known so, keeping `margin` \[m\] from walls.
    #[must_use]
    pub fn of(known: &Knowledge, margin: f64) -> Self {
        // What goes through a passage with little room must not find it closed by the touches beside it.
        let room = (known.passage - 2.0 * (known.radius + margin)).max(0.0);
        let sure = (0.1 * known.wall).min(0.25 * room);
        Self { margin, price: 0.48 * known.wall, lattice: 0.1 * known.wall, sure }
    }

    /// The path from a place to a region, first and last place included; `None` where the touches leave none.
    #[must_use]
    pub fn path(&self, map: &Map, from: &Place, goal: &Region) -> Option<Vec<Place>> {
        let known = map.knowledge();
        let half = 0.5 * known.thickness;
        if let Some(spacing) = map.spacing() {
            let panels = Panels::of(map, spacing);
            let keep = known.radius + half + self.margin;
            if let Some(through) = panels_to(&panels, from, goal) {
                return Some(Portals { panels: &panels, keep, half }.path(from, &through, goal));
            }
        }
        let lattice = self.lattice(map);
        let start = lattice.nearest_free(from)?;
        let successors = |&(x, y): &(i32, i32)| {
            let lattice = &lattice;
            NEIGHBOURS.iter().filter_map(move |&(dx, dy)| {
                let next = (x + dx, y + dy);
                let index = lattice.index(next)?;
                if lattice.blocked[index] {
                    return None;
                }
                let length = self.lattice * if dx == 0 || dy == 0 { 1.0 } else { core::f64::consts::SQRT_2 };
                let share = 1.0 + f64::from(lattice.belief[index]);
                Some((next, (1e6 * length * share) as Cost))
            })
        };
        let left = |&(x, y): &(i32, i32)| {
            let at = lattice.place((x, y));
            let near = goal.nearest(&at);
            let (dx, dy) = ((near.x - at.x).abs(), (near.y - at.y).abs());
            // On the lattice: as many diagonals as go, and the rest straight.
            (1e6 * (dx.max(dy) + (core::f64::consts::SQRT_2 - 1.0) * dx.min(dy))) as Cost
        };
        let (nodes, _) = astar(&start, successors, left, |node| goal.distance(&lattice.place(*node)) <= 0.0)?;
        let mut places = vec![*from];
        // It may stand on the first node.
        places.extend(
            nodes
                .into_iter()
                .map(|node| lattice.place(node))
                .skip_while(|at| (at - from).norm() < 0.1 * self.lattice),
        );
        if places.len() == 1 {
            places.push(goal.nearest(from));
        }
        Some(lattice.pulled(&places))
    }

    fn lattice<'m>(&self, map: &'m Map) -> Lattice<'m> {
        let known = map.knowledge();
        let nodes = |length: f64| (length / self.lattice).floor() as i32 + 1;
        let (columns, rows) = (nodes(known.size[0]), nodes(known.size[1]));
        let count = (columns * rows) as usize;
        let mut lattice = Lattice {
            map,
            columns,
            rows,
            apart: self.lattice,
            blocked: vec![false; count],
            belief: vec![0.0; count],
        };
        let keep = known.radius + self.margin;
        let frame = 0.5 * known.thickness + keep;
        for x in 0..columns {
            for y in 0..rows {
                let at = lattice.place((x, y));
                let inside = |v: f64, length: f64| v >= frame && v <= length - frame;
                if !(inside(at.x, known.size[0]) && inside(at.y, known.size[1]))
                    && let Some(index) = lattice.index((x, y))
                {
                    lattice.blocked[index] = true;
                }
            }
        }
        let contacts = map.contacts();
        for (number, contact) in contacts.iter().enumerate() {
            let beside = Vector2::new(-contact.into.y, contact.into.x);
            let middle = contact.at + contact.into * (0.5 * known.thickness);
            for beside in [beside, -beside] {
                let belief = map.belief(contact, &beside);
                // Sure until the next touch of the same wall, if no passage fits between.
                let next = contacts.iter().enumerate().filter(|(other, _)| *other != number).filter_map(
                    |(_, one)| {
                        let s = (one.at - contact.at).dot(&beside);
                        (one.is_of_the_wall_of(contact, known.wall) && s > 0.0 && s < known.passage)
                            .then_some(s)
                    },
                );
                let joined = next.fold(f64::INFINITY, f64::min);
                let sure = if joined < belief { joined } else { self.sure.min(belief) };
                lattice.block(&middle, &(middle + beside * sure), keep + 0.5 * known.thickness);
                if joined >= belief {
                    let dear = |s: f64| self.price * (1.0 - s / known.wall);
                    lattice.believe(&middle, &beside, [sure, belief], keep + 0.5 * known.thickness, dear);
                }
            }
        }
        lattice
    }
}

const NEIGHBOURS: [(i32, i32); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

impl Lattice<'_> {
    fn place(&self, (x, y): (i32, i32)) -> Place {
        Place::new(f64::from(x), f64::from(y)) * self.apart
    }

    fn node(&self, at: &Place) -> (i32, i32) {
        ((at.x / self.apart).round() as i32, (at.y / self.apart).round() as i32)
    }

    fn index(&self, (x, y): (i32, i32)) -> Option<usize> {
        (x >= 0 && y >= 0 && x < self.columns && y < self.rows).then(|| (y * self.columns + x) as usize)
    }

    /// Visits the nodes of a rectangle around two places.
    fn around(&mut self, a: &Place, b: &Place, within: f64, mut visit: impl FnMut(&mut Self, usize, Place)) {
        let reach = Place::new(within, within);
        let (low, high) = (self.node(&(a.inf(b) - reach)), self.node(&(a.sup(b) + reach)));
        for x in low.0..=high.0 {
            for y in low.1..=high.1 {
                if let Some(index) = self.index((x, y)) {
                    let at = self.place((x, y));
                    visit(self, index, at);
                }
            }
        }
    }

    fn block(&mut self, a: &Place, b: &Place, within: f64) {
        let (a, b) = (*a, *b);
        self.around(&a, &b, within, |lattice, index, at| {
            if distance(&a, &b, &at) < within {
                lattice.blocked[index] = true;
            }
        });
    }

    /// What crossing a believed wall costs, `dear` at so far from its touch, is spread over its thickness.
    fn believe(
        &mut self,
        middle: &Place,
        beside: &Vector2<f64>,
        [sure, to]: [f64; 2],
        within: f64,
        dear: impl Fn(f64) -> f64,
    ) {
        let (middle, beside) = (*middle, *beside);
        let end = middle + beside * to;
        self.around(&middle, &end, within, |lattice, index, at| {
            let s = (at - middle).dot(&beside);
            let off = (at - middle - beside * s).norm();
            if s >= sure && s <= to && off <= within {
                let density = (dear(s) / (2.0 * within)) as f32;
                lattice.belief[index] = lattice.belief[index].max(density);
            }
        });
    }

    /// The nearest free node, without crossing what is blocked for long.
    fn nearest_free(&self, from: &Place) -> Option<(i32, i32)> {
        let (cx, cy) = self.node(from);
        let mut best: Option<((i32, i32), f64)> = None;
        for x in cx - 4..=cx + 4 {
            for y in cy - 4..=cy + 4 {
                let Some(index) = self.index((x, y)) else { continue };
                let away = (self.place((x, y)) - from).norm();
                if !self.blocked[index]
                    && best.is_none_or(|(_, least)| away < least)
                    && self.crosses_no_contact(from, &self.place((x, y)))
                {
                    best = Some(((x, y), away));
                }
            }
        }
        best.map(|(node, _)| node)
    }

    fn crosses_no_contact(&self, from: &Place, to: &Place) -> bool {
        self.map.contacts().iter().all(|contact: &Contact| {
            let side = |at: &Place| (at - contact.at).dot(&contact.into);
            let beside = Vector2::new(-contact.into.y, contact.into.x);
            let (a, b) = (side(from), side(to));
            let near = ((from + to) * 0.5 - contact.at).dot(&beside).abs() < 0.24 * self.map.knowledge().wall;
            !(near && a < 0.0 && b > 0.0)
        })
    }

    /// What a straight line costs beyond its length; `None` where it is blocked.
    fn price(&self, from: &Place, to: &Place) -> Option<f64> {
        let leg = to - from;
        let steps = (leg.norm() / (0.4 * self.apart)).ceil().max(1.0);
        let mut price = 0.0;
        for i in 1..=steps as u32 {
            let at = from + leg * (f64::from(i) / steps);
            let index = self.index(self.node(&at))?;
            if self.blocked[index] {
                return None;
            }
            price += f64::from(self.belief[index]) * leg.norm() / steps;
        }
        Some(price)
    }

    /// Leaves out places where straight on is no dearer.
    fn pulled(&self, places: &[Place]) -> Vec<Place> {
        let mut path = vec![places[0]];
        let mut at = 0;
        while at + 1 < places.len() {
            let mut next = at + 1;
            let mut so_far = self.price(&places[at], &places[next]).unwrap_or(0.0);
            let mut last = next;
            while last + 1 < places.len() {
                so_far += self.price(&places[last], &places[last + 1]).unwrap_or(0.0);
                last += 1;
                match self.price(&places[at], &places[last]) {
                    Some(price) if price <= so_far * 1.02 + 1e-4 => next = last,
                    Some(_) => {}
                    None if (places[last] - places[at]).norm() > 8.0 * self.apart => break,
                    None => {}
                }
            }
            path.push(places[next]);
            at = next;
        }
        path
    }
}

/// How far a place is from a straight piece \[m\].
fn distance(a: &Place, b: &Place, at: &Place) -> f64 {
    let piece = b - a;
    let length = piece.norm_squared();
    let s = if length > 0.0 { ((at - a).dot(&piece) / length).clamp(0.0, 1.0) } else { 0.0 };
    (at - a - piece * s).norm()
}
