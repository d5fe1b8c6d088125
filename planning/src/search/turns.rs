//! Robots that move one after the other, each while the others stand.
//!
//! In: positions of all robots at the start and at the goal. Out: a path on which one robot moves at a time. Shortcuts then join what need
//! not wait for one another.
//!
//! Each robot has places: its start, its goal, and from the second round on places aside, which are drawn at random and keep clear of as
//! many places of the others as possible. A state tells at which place each robot stands. The states are searched by A*, the cost of a
//! motion being one, so that few robots move, and those that have nothing to do stay. A motion is looked for only when its state is
//! reached: first as if the robot were alone; then, where none that is known between the same places is clear of the others, among them. Both by
//! [`connect`] in the joints of this robot.

use core::ops::Range;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use mrroc::random::Random;

use super::sampling::Samples;
use super::{Joints, Points, connect, rooted, shorten, straight};
use crate::check::{Among, Checker};
use crate::edge::Edges;
use crate::stop::ROBOTS;
use crate::upright::Uprights;

/// The effort for a motion of one robot in the first round, in checks; in each further round it is twice that.
const FIRST: u64 = 500;
/// How many times that is the effort for a motion of a robot as if it were alone, which is looked for but once.
const ALONE: u64 = 16;
/// The effort for making a motion of one robot shorter.
const SHORTENING: u64 = 200;
/// The most rounds; in each but the first every robot gets a place aside.
const ROUNDS: usize = 6;
/// How many places aside are drawn for each one that is taken, and how far each joint is from the start or the goal at most [rad or m].
const DRAWN: usize = 40;
const ASIDE: f64 = 2.5;

/// At which of its places each robot stands.
type State = [u8; ROBOTS];

/// A state to be looked at: its cost with what is at least left, how many motions lead to it, a number that tells which was found first,
/// and the motion to it: the state before, the robot, and its place.
type Open = (Reverse<u32>, u32, Reverse<u32>, State, Option<(State, usize)>);

/// What is known of the robots' motions.
struct Turns<'a> {
    checker: &'a mut Checker,
    edges: &'a mut Edges,
    samples: &'a Samples,
    /// What all robots keep upright.
    uprights: Uprights,
    /// The places of each robot: first its start.
    places: Vec<Points>,
    /// Which of them is its goal.
    goals: State,
    /// Whether two robots are clear of one another, each at one of its places.
    fits: BTreeMap<[(usize, u8); 2], bool>,
    /// Motions of a robot from one place to another, in its joints.
    known: BTreeMap<(usize, u8, u8), Vec<Points>>,
    /// The effort by which a motion of a robot was not found even alone.
    stuck: BTreeMap<(usize, u8, u8), u64>,
    /// The effort by which a motion from a state was not found.
    failed: BTreeMap<(State, usize, u8), u64>,
    end: u64,
}

/// A path from `start` to `goal`, both of them clear, on which one robot moves at a time; `None` where at most about `effort` checks find none.
pub(crate) fn in_turns(
    checker: &mut Checker,
    edges: &mut Edges,
    samples: &Samples,
    start: &[f32],
    goal: &[f32],
    effort: u64,
) -> Option<Points> {
    let mut goals = [0; ROBOTS];
    let mut places = Vec::new();
    for (i, arm) in checker.arms.iter().enumerate() {
        let [from, to] = [start, goal].map(|q| q[arm.first..arm.first + arm.joints].to_vec());
        goals[i] = u8::from(from != to);
        places.push(if from == to { vec![from] } else { vec![from, to] });
    }
    let end = checker.batches + effort;
    let uprights = checker.uprights.clone();
    let mut turns = Turns {
        uprights,
        checker,
        edges,
        samples,
        places,
        goals,
        fits: BTreeMap::new(),
        known: BTreeMap::new(),
        stuck: BTreeMap::new(),
        failed: BTreeMap::new(),
        end,
    };
    let path = turns.find();
    turns.checker.among = Among::All;
    turns.checker.uprights = turns.uprights;
    path
}

impl Turns<'_> {
    fn find(&mut self) -> Option<Points> {
        for round in 0..ROUNDS {
            if round > 0 {
                for robot in 0..self.places.len() {
                    self.step_aside(robot, round);
                }
            }
            let path = self.search(FIRST << round);
            if path.is_some() || self.is_over() {
                return path;
            }
        }
        None
    }

    fn is_over(&self) -> bool {
        self.checker.batches >= self.end
    }

    /// A* over states, by so many checks for each motion.
    fn search(&mut self, effort: u64) -> Option<Points> {
        let mut reached = BTreeMap::<State, Option<(State, Points)>>::new();
        let mut found = 0;
        let mut open = BinaryHeap::<Open>::new();
        open.push((Reverse(self.left(&[0; ROBOTS])), 0, Reverse(found), [0; ROBOTS], None));
        while let Some((_, moves, _, state, from)) = open.pop() {
            if self.is_over() {
                return None;
            }
            if reached.contains_key(&state) {
                continue;
            }
            let by = match from {
                None => None,
                Some((before, robot)) => match self.motion(&before, robot, state[robot], effort) {
                    Some(path) => Some((before, path)),
                    None => continue,
                },
            };
            reached.insert(state, by);
            if self.left(&state) == 0 {
                return Some(self.path_to(&reached, state));
            }
            for robot in 0..self.places.len() {
                for place in 0..self.places[robot].len() as u8 {
                    let mut next = state;
                    next[robot] = place;
                    if place == state[robot] || reached.contains_key(&next) || !self.fit(&next, robot) {
                        continue;
                    }
                    found += 1;
                    let least = moves + 1 + self.left(&next);
                    open.push((Reverse(least), moves + 1, Reverse(found), next, Some((state, robot))));
                }
            }
        }
        None
    }

    /// How many robots are not at their goals.
    fn left(&self, state: &State) -> u32 {
        (0..self.places.len()).map(|robot| u32::from(state[robot] != self.goals[robot])).sum()
    }

    /// Positions of all robots.
    fn at(&self, state: &State) -> Vec<f32> {
        self.places
            .iter()
            .zip(state)
            .flat_map(|(places, place)| places[usize::from(*place)].clone())
            .collect()
    }

    /// Whether a robot is clear of the others where they stand.
    fn fit(&mut self, state: &State, robot: usize) -> bool {
        (0..self.places.len()).filter(|other| *other != robot).all(|other| {
            let (a, b) = (robot.min(other), robot.max(other));
            let pair = [(a, state[a]), (b, state[b])];
            if let Some(fits) = self.fits.get(&pair) {
                return *fits;
            }
            self.checker.among = Among::Two(a, b);
            let fits = self.is_clear(&self.at(state));
            self.fits.insert(pair, fits);
            fits
        })
    }

    /// Whether joints that share limits allow a posture.
    fn is_possible(&self, q: &[f32]) -> bool {
        let q: Vec<f64> =
            q.iter().zip(&self.checker.offset).map(|(q, offset)| f64::from(*q) + offset).collect();
        self.checker.is_possible(&q)
    }

    fn is_clear(&mut self, q: &[f32]) -> bool {
        let q: Vec<f64> = q.iter().map(|q| f64::from(*q)).collect();
        self.checker.is_clear(&q)
    }

    /// A motion of one robot to a place, while the others stand; in its joints.
    fn motion(&mut self, state: &State, robot: usize, to: u8, effort: u64) -> Option<Points> {
        let key = (robot, state[robot], to);
        if !self.known.contains_key(&key) {
            // What it cannot do alone it cannot do among the others.
            if self.stuck.get(&key).is_some_and(|tried| *tried >= effort) {
                return None;
            }
            if self.planned(Among::Alone(robot), state, robot, to, ALONE * effort).is_none() {
                self.stuck.insert(key, effort);
                return None;
            }
        }
        if let Some(path) = self.known_clear(state, key) {
            return Some(path);
        }
        if self.failed.get(&(*state, robot, to)).is_some_and(|tried| *tried >= effort) {
            return None;
        }
        if self.planned(Among::Of(robot), state, robot, to, effort).is_none() {
            self.failed.insert((*state, robot, to), effort);
            return None;
        }
        self.known_clear(state, key)
    }

    /// The first known motion that is clear of the others where they stand.
    fn known_clear(&mut self, state: &State, key: (usize, u8, u8)) -> Option<Points> {
        let mut at = self.at(state);
        let mut to = at.clone();
        let joints = self.joints(key.0);
        self.attend(Among::Of(key.0), key.0);
        let Turns { checker, edges, known, .. } = self;
        let is_clear = |path: &&Points| {
            path.windows(2).all(|leg| {
                at[joints.clone()].copy_from_slice(&leg[0]);
                to[joints.clone()].copy_from_slice(&leg[1]);
                edges.is_clear(checker, &at, &to)
            })
        };
        known.get(&key)?.iter().find(is_clear).cloned()
    }

    /// Looks for a motion, `among` others or alone, and remembers it in both directions.
    fn planned(&mut self, among: Among, state: &State, robot: usize, to: u8, effort: u64) -> Option<Points> {
        let start = self.at(state);
        let mut end = *state;
        end[robot] = to;
        let goal = [self.at(&end)];
        let joints = self.joints(robot);
        // Samples that did not help once are not tried again, but others.
        let mut samples = self.samples.of(joints.clone(), &start, effort);
        let end = self.end.min(self.checker.batches + effort);
        self.attend(among, robot);
        let space = &mut Joints { checker: self.checker, edges: self.edges };
        let path = straight(space, &start, &goal);
        let left = end.saturating_sub(space.checker.batches);
        let mut trees = rooted(&start, &goal);
        let grown = || connect(space, &mut samples, &mut trees, &goal, left).ok();
        let mut path = path.or_else(grown)?;
        shorten(self.checker, self.edges, robot as u64, &mut path, SHORTENING);
        let own: Points = path.iter().map(|q| q[joints.clone()].to_vec()).collect();
        let back = own.iter().rev().cloned().collect();
        self.known.entry((robot, state[robot], to)).or_default().push(own.clone());
        self.known.entry((robot, to, state[robot])).or_default().push(back);
        Some(own)
    }

    /// Has the pairs of a robot checked, and kept upright what it holds: those that stand are where they may be.
    fn attend(&mut self, among: Among, robot: usize) {
        self.checker.among = among;
        let name = self.checker.arms[robot].name();
        let own = self.uprights.0.iter().filter(|upright| upright.robot == name);
        self.checker.uprights = Uprights(own.cloned().collect());
    }

    fn joints(&self, robot: usize) -> Range<usize> {
        let arm = &self.checker.arms[robot];
        arm.first..arm.first + arm.joints
    }

    /// Adds a place aside, the best of some.
    fn step_aside(&mut self, robot: usize, round: usize) {
        let mut random = Random::seeded(self.samples.seed() ^ (ROBOTS * round + robot) as u64);
        let joints = self.joints(robot);
        let ranges = self.samples.ranges(joints.clone());
        let own = self.places[robot].len() as u8;
        let mut best: Option<(usize, Vec<f32>)> = None;
        for k in 0..DRAWN {
            let far = ASIDE * (k + 1) as f64 / DRAWN as f64;
            let near = random.below(1 + usize::from(self.goals[robot])) as u8;
            let mut state = [0; ROBOTS];
            state[robot] = near;
            let mut q = self.at(&state);
            for (q, [lower, upper]) in q[joints.clone()].iter_mut().zip(&ranges) {
                *q = (*q + random.within(far) as f32).clamp(*lower, *upper);
            }
            self.attend(Among::Alone(robot), robot);
            let may_stand = self.checker.uprights.project(&self.checker.arms, &mut q)
                && self.is_possible(&q)
                && self.is_clear(&q);
            if may_stand {
                self.places[robot].push(q[joints.clone()].to_vec());
                let fits = self.fits_of(robot, own);
                let place = self.places[robot].pop();
                // Those that are drawn first are nearer.
                if best.as_ref().is_none_or(|(most, _)| fits > *most) {
                    best = place.map(|place| (fits, place));
                }
            }
        }
        if let Some((_, place)) = best {
            self.places[robot].push(place);
        }
    }

    /// Of how many places of others a robot is clear at a place.
    fn fits_of(&mut self, robot: usize, place: u8) -> usize {
        let mut state = [0; ROBOTS];
        state[robot] = place;
        let mut fits = 0;
        for other in (0..self.places.len()).filter(|other| *other != robot) {
            self.checker.among = Among::Two(robot, other);
            for place in 0..self.places[other].len() as u8 {
                state[other] = place;
                fits += usize::from(self.is_clear(&self.at(&state)));
            }
            state[other] = 0;
        }
        fits
    }

    /// The positions of all robots on the path to a state.
    fn path_to(&self, reached: &BTreeMap<State, Option<(State, Points)>>, last: State) -> Points {
        let mut path = vec![self.at(&last)];
        let mut state = last;
        while let Some(Some((before, own))) = reached.get(&state) {
            let at = self.at(before);
            let robot = (0..self.places.len()).find(|robot| before[*robot] != state[*robot]).unwrap_or(0);
            let first = self.checker.arms[robot].first;
            for own in own.iter().rev().skip(1) {
                let mut q = at.clone();
                q[first..first + own.len()].copy_from_slice(own);
                path.push(q);
            }
            state = *before;
        }
        path.reverse();
        path
    }
}
