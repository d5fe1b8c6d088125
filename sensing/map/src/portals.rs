//! The shortest path through given panels: through portals, which are places in the openings between posts.
//!
//! ```text
//! portals    so many places in each panel, clear of its posts
//! legs       straight within a room between posts, clear of them
//! path       the shortest over all choices of portals (dynamic programming), then pulled straight where that is clear
//! ```

use crate::panels::Which;
use crate::panels::{Panel, Panels};
use crate::shortest::Region;
use crate::walls::{Place, Wall};

/// Places in a panel.
const PLACES: usize = 7;
/// So many panels ahead the path is planned out.
const AHEAD: usize = 12;

/// What paths are planned by.
#[derive(Debug)]
pub struct Portals<'p> {
    /// What is known.
    pub panels: &'p Panels,
    /// How far the ball's middle keeps from the lines of walls \[m\].
    pub keep: f64,
    /// Half a wall's thickness \[m\].
    pub half: f64,
}

impl Portals<'_> {
    /// The path from a place through panels, and the room behind each, to a region; first and last place included.
    #[must_use]
    pub fn path(&self, from: &Place, through: &[(Which, (usize, usize))], goal: &Region) -> Vec<Place> {
        // For each portal of the last panel the length to it, and for all panels where each came from.
        let mut lengths = vec![0.0];
        let mut places = vec![*from];
        let mut rooms = vec![];
        let mut came: Vec<Vec<(usize, Place)>> = vec![];
        let mut room = self.panels.room(from);
        for (which, next) in through.iter().take(AHEAD) {
            let portals: Vec<Place> = (0..PLACES).map(|number| self.portal(*which, number)).collect();
            let best = self.joined(&places, &lengths, &portals, room);
            lengths = best.iter().map(|(length, _)| *length).collect();
            came.push(best.iter().map(|(_, before)| (*before, places[*before])).collect());
            places = portals;
            rooms.push(room);
            room = *next;
        }
        let mut number = (0..places.len()).min_by(|a, b| lengths[*a].total_cmp(&lengths[*b])).unwrap_or(0);
        let mut path = vec![];
        if through.len() <= AHEAD {
            // A little within: what is reached to rounding errors counts.
            let half = (goal.upper - goal.lower) * 0.5;
            let inset = half.inf(&Place::new(0.02, 0.02).scale(self.panels.spacing));
            let within = Region { lower: goal.lower + inset, upper: goal.upper - inset };
            let ends: Vec<Place> = places.iter().map(|place| within.nearest(place)).collect();
            let whole = |number: usize| lengths[number] + (ends[number] - places[number]).norm();
            number = (0..places.len()).min_by(|a, b| whole(*a).total_cmp(&whole(*b))).unwrap_or(0);
            path.push(ends[number]);
        }
        if !came.is_empty() {
            path.push(places[number]);
        }
        for step in came.iter().rev() {
            let (before, place) = step[number];
            path.push(place);
            number = before;
        }
        if came.is_empty() {
            path.push(*from);
        }
        path.reverse();
        let fixed = self.squarely(&mut path, through, &rooms);
        // It may stand in a portal.
        let mut path = self.pulled(&path, &fixed);
        path.dedup_by(|next, at| (*next - *at).norm() < 1e-6);
        path
    }

    /// Where a body met a post as it tried a panel: through the middle of that panel, from the middle of
    /// the room before it to that of the room behind. Returns which places of the path must stay.
    fn squarely(
        &self,
        path: &mut Vec<Place>,
        through: &[(Which, (usize, usize))],
        rooms: &[(usize, usize)],
    ) -> Vec<bool> {
        let s = self.panels.spacing;
        let middle = |(x, y): (usize, usize)| Place::new(x as f64 + 0.5, y as f64 + 0.5) * s;
        let mut fixed = vec![false; path.len()];
        for (number, before) in rooms.iter().enumerate().rev() {
            let (which, behind) = through[number];
            if !self.panels.is_beside_a_post(which) {
                continue;
            }
            let (before, behind) = (middle(*before), middle(behind));
            // It may stand there already, or between.
            let aside =
                (path[0] - before).dot(&Place::new(behind.y - before.y, before.x - behind.x)).abs() / s;
            let middles = if number == 0 && aside < 0.05 * s { vec![behind] } else { vec![before, behind] };
            // The place in the panel stands after those in the panels before it, and that where the path begins.
            fixed.splice(number + 1..number + 2, vec![true; middles.len()]);
            path.splice(number + 1..number + 2, middles);
        }
        fixed
    }

    /// For each of `portals` the shortest length to it, and over which of `places`.
    fn joined(
        &self,
        places: &[Place],
        lengths: &[f64],
        portals: &[Place],
        room: (usize, usize),
    ) -> Vec<(f64, usize)> {
        let one = |to: &Place| {
            let by = |(number, from): (usize, &Place)| {
                // A leg too near to a post is the last choice.
                let near = if self.is_clear(from, to, room) { 0.0 } else { self.panels.spacing };
                (lengths[number] + (to - from).norm() + near, number)
            };
            places.iter().enumerate().map(by).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
        };
        portals.iter().map(one).collect()
    }

    fn portal(&self, (upright, line, along): Which, number: usize) -> Place {
        let s = self.panels.spacing;
        let share = 2.0 * number as f64 / (PLACES - 1) as f64 - 1.0;
        let (across, along) = (line as f64 * s, (along as f64 + 0.5) * s + share * (0.5 * s - self.keep));
        if upright { Place::new(across, along) } else { Place::new(along, across) }
    }

    /// Whether a straight line within a room is clear of its posts.
    fn is_clear(&self, from: &Place, to: &Place, (x, y): (usize, usize)) -> bool {
        [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].into_iter().all(|post| self.passes(post, from, to))
    }

    /// Whether a straight line keeps away from a post; one that begins near it may lead away.
    fn passes(&self, (x, y): (usize, usize), from: &Place, to: &Place) -> bool {
        let middle = Place::new(x as f64, y as f64) * self.panels.spacing;
        let half = Place::new(self.half, self.half);
        let post = Wall { lower: middle - half, upper: middle + half };
        // The post is so small that the place of the line nearest to its middle is near enough.
        let leg = to - from;
        let length = leg.norm_squared();
        let share = if length > 0.0 { ((middle - from).dot(&leg) / length).clamp(0.0, 1.0) } else { 0.0 };
        let need = (self.keep - self.half).min(post.distance(from));
        post.distance(&(from + leg * share)) >= need - 1e-9
    }

    /// Whether a straight line is clear of posts and known walls, and how many panels it tries of which nothing is known.
    fn straight(&self, from: &Place, to: &Place) -> Option<usize> {
        let s = self.panels.spacing;
        let mut tried = 0;
        for which in self.panels.crossings(from, to) {
            match self.panels.get(which) {
                Panel::Wall => return None,
                Panel::Unknown => tried += 1,
                Panel::Open => {}
            }
        }
        let (low, high) = (from.inf(to), from.sup(to));
        let post = |v: f64| (v / s).round().max(0.0) as usize;
        let mut posts =
            (post(low.x)..=post(high.x)).flat_map(|x| (post(low.y)..=post(high.y)).map(move |y| (x, y)));
        posts.all(|post| self.passes(post, from, to)).then_some(tried)
    }

    /// Leaves out places that are not fixed, where straight on is clear, and tries no more panels.
    fn pulled(&self, places: &[Place], fixed: &[bool]) -> Vec<Place> {
        let mut path = vec![places[0]];
        let mut at = 0;
        while at + 1 < places.len() {
            let mut next = at + 1;
            let mut so_far = self.straight(&places[at], &places[next]).unwrap_or(0);
            for last in at + 2..places.len() {
                if fixed[last - 1] {
                    break;
                }
                so_far += self.straight(&places[last - 1], &places[last]).unwrap_or(0);
                if self.straight(&places[at], &places[last]).is_some_and(|tried| tried <= so_far) {
                    next = last;
                }
            }
            path.push(places[next]);
            at = next;
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Knowledge;
    use crate::map::Map;

    #[test]
    fn where_a_post_was_touched_the_path_leads_squarely_through_the_middle_of_the_panel_beside_it() {
        let known =
            Knowledge { size: [0.36, 0.18], radius: 0.045, thickness: 0.012, passage: 0.15, wall: 0.18 };
        let mut map = Map::new(known);
        // Two rooms side by side; the path from one to the other is straight, and beside their middles.
        let (from, goal) =
            (Place::new(0.12, 0.07), Region { lower: Place::new(0.26, 0.1), upper: Place::new(0.3, 0.12) });
        let path = |map: &Map| {
            let panels = Panels::of(map, 0.18);
            let through = crate::cells::panels_to(&panels, &from, &goal).expect("it may be open");
            Portals { panels: &panels, keep: 0.063, half: 0.006 }.path(&from, &through, &goal)
        };
        let straight = path(&map);
        assert_eq!(straight.len(), 2, "{straight:?}");
        // On this path it comes upon the post at (0.18, 0.18), of which only the corner is before it.
        let corner = Place::new(0.174, 0.174);
        let ball = corner - Place::new(0.7, 0.7).normalize() * 0.045;
        map.meet(&ball, &corner, &(straight[1] - straight[0]));
        let after = path(&map);
        let middles = [Place::new(0.09, 0.09), Place::new(0.27, 0.09)];
        assert!((after[1] - middles[0]).norm() < 1e-9 && (after[2] - middles[1]).norm() < 1e-9, "{after:?}");
    }

    #[test]
    fn what_was_seen_of_a_wall_beside_a_post_makes_no_doubt() {
        let known =
            Knowledge { size: [0.54, 0.54], radius: 0.045, thickness: 0.012, passage: 0.15, wall: 0.18 };
        let mut map = Map::new(known);
        // The face of a level wall from post to post, and a little beyond.
        map.see(&Place::new(0.17, 0.174), &Place::new(0.366, 0.174), &Place::new(0.0, 1.0));
        let panels = Panels::of(&map, 0.18);
        let level = |cell| (panels.get((false, 1, cell)), panels.doubts((false, 1, cell)));
        assert_eq!([0, 1, 2].map(level), [(Panel::Unknown, 0.0), (Panel::Wall, 0.0), (Panel::Unknown, 0.0)]);
        for line in 0..4 {
            assert!((0..3).all(|cell| panels.doubts((true, line, cell)) == 0.0));
        }
    }
}
