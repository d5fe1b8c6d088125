//! A map that grows by contact: where the ball has been is free, what it touched is wall, and all else is unknown.
//!
//! ```text
//! touched      a point and the direction in which the wall lies: blocked within `SURE`, and between two touches of one wall
//! believed     on along the wall, less and less surely: a price, no obstacle
//! passed       free: no wall is where the ball has been, so what is believed ends there
//! unknown      free, optimistically: planning through it is how it becomes known
//! ```
//!
//! No grid of cells is known: walls are level or upright in the map's frame, straight, and passages at least [`Knowledge::passage`] wide.

use nalgebra::Vector2;

use crate::contact::{Contact, Knowledge};
use crate::spacing::spacing;
use crate::walls::Place;

/// What is thought of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thought {
    /// Nothing is known.
    Unknown,
    /// The ball has been there.
    Passed,
}

/// The map.
#[derive(Clone, Debug)]
pub struct Map {
    known: Knowledge,
    /// By squares, row by row.
    thoughts: Vec<Thought>,
    columns: usize,
    rows: usize,
    contacts: Vec<Contact>,
    moves: Vec<[Place; 2]>,
    spacing: Option<f64>,
}

impl Map {
    /// Nothing but the frame is known. Up to 10,000 squares along a side.
    #[must_use]
    pub fn new(known: Knowledge) -> Self {
        let squares = |length: f64| (length / known.square()).ceil().clamp(1.0, 1e4) as usize;
        let (columns, rows) = (squares(known.size[0]), squares(known.size[1]));
        Self {
            known,
            thoughts: vec![Thought::Unknown; columns * rows],
            columns,
            rows,
            contacts: Vec::new(),
            moves: Vec::new(),
            spacing: None,
        }
    }

    /// What was known beforehand.
    #[must_use]
    pub const fn knowledge(&self) -> &Knowledge {
        &self.known
    }

    /// All touches, in their order.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The spacing at whose multiples walls stand \[m\], once touches have borne one out.
    #[must_use]
    pub const fn spacing(&self) -> Option<f64> {
        self.spacing
    }

    /// All straight moves of the ball, in their order.
    #[must_use]
    pub fn moves(&self) -> &[[Place; 2]] {
        &self.moves
    }

    fn index(&self, at: &Place) -> Option<usize> {
        let square = self.known.square();
        let (x, y) = ((at.x / square).floor(), (at.y / square).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64;
        inside.then(|| y as usize * self.columns + x as usize)
    }

    /// What is thought of a place; beyond the frame nothing is known.
    #[must_use]
    pub fn thought(&self, at: &Place) -> Thought {
        self.index(at).map_or(Thought::Unknown, |index| self.thoughts[index])
    }

    /// The ball has gone straight from one place to another: nothing is there.
    pub fn pass(&mut self, from: &Place, to: &Place) {
        self.moves.push([*from, *to]);
        let (leg, square) = (to - from, self.known.square());
        let steps = (leg.norm() / (0.5 * square)).ceil().max(1.0);
        // What the ball's middle half has swept: a place at the rim may be beside a wall that it slid along.
        let reach = (0.5 * self.known.radius / square).floor() as i32;
        for step in 0..=steps as u32 {
            let at = from + leg * (f64::from(step) / steps);
            for dx in -reach..=reach {
                for dy in -reach..=reach {
                    let beside = at + Place::new(f64::from(dx), f64::from(dy)) * square;
                    if let Some(index) = self.index(&beside) {
                        self.thoughts[index] = Thought::Passed;
                    }
                }
            }
        }
    }

    /// The ball, its centre at `ball`, touches something while it moves along `moving`: in which direction does the wall lie?
    ///
    /// The wall is level or upright, and can only be ahead. Of the two, a wall that would lie where the ball has passed is none; of what
    /// remains the one that is met more squarely is believed.
    pub fn touch(&mut self, ball: &Place, moving: &Vector2<f64>) -> Contact {
        let across = Vector2::new(moving.x.signum(), 0.0);
        let along = Vector2::new(0.0, moving.y.signum());
        let (better, other) =
            if moving.x.abs() >= moving.y.abs() { (across, along) } else { (along, across) };
        let lies = |into: Vector2<f64>| Contact {
            at: ball + into * self.known.radius,
            into,
            moving: *moving,
            ball: *ball,
        };
        let share = moving.x.abs().min(moving.y.abs()) / moving.norm().max(1e-12);
        let length = |contact: Contact| {
            let beside = Vector2::new(-contact.into.y, contact.into.x);
            self.belief(&contact, &beside) + self.belief(&contact, &-beside)
        };
        let (first, second) = (lies(better), lies(other));
        // A wall that is known on this line, and goes on to here.
        let goes_on = |contact: &Contact| {
            self.contacts.iter().any(|one| {
                let beside = contact.at - one.at;
                let apart = beside.norm();
                one.is_of_the_wall_of(contact, self.known.wall)
                    && one.into == contact.into
                    && apart < self.known.wall
                    && self.belief(one, &(beside / apart.max(1e-9))) >= apart
            })
        };
        // Once the spacing of walls is learned, the one on a line of it.
        let off_line = |contact: &Contact| {
            let middle = contact.at + contact.into * (0.5 * self.known.thickness);
            let c = if contact.into.x.abs() > 0.5 { middle.x } else { middle.y };
            self.spacing.map(|s| (c - (c / s).round() * s).abs())
        };
        let clearly = 0.04 * self.known.wall;
        let by_line = match (off_line(&first), off_line(&second)) {
            (Some(a), Some(b)) if a + clearly < b => Some(first),
            (Some(a), Some(b)) if b + clearly < a && share > 1e-6 => Some(second),
            _ => None,
        };
        let contact = by_line.unwrap_or_else(|| match (goes_on(&first), goes_on(&second)) {
            (true, _) if share > 0.1 => first,
            (_, true) => second,
            (_, false) if share > 0.1 && length(first) < 0.5 * length(second) => second,
            (_, false) => first,
        });
        self.contacts.push(contact);
        self.spacing = spacing(&self.contacts, &self.known, self.spacing);
        contact
    }

    /// A body of the ball's radius, its middle at `ball`, would touch a wall at a place `at` that was seen, while it moves along `moving`.
    ///
    /// At the corner of a wall its middle is straight before neither face. The one is believed that it meets more squarely, of those that are
    /// ahead.
    ///
    /// ```
    /// use mrroc_map::{Knowledge, Map, Place};
    /// let known = Knowledge { size: [2.88, 2.88], radius: 0.045, thickness: 0.012, passage: 0.15, wall: 0.18 };
    /// let mut map = Map::new(known);
    /// // It goes up and to the left, more to the left, towards a level wall above it.
    /// let contact = map.meet(&Place::new(1.96, 0.309), &Place::new(1.95, 0.353), &Place::new(-0.8, 0.6));
    /// assert_eq!((contact.at, contact.into), (Place::new(1.95, 0.353), Place::new(0.0, 1.0)));
    /// ```
    pub fn meet(&mut self, ball: &Place, at: &Place, moving: &Vector2<f64>) -> Contact {
        let normal = at - ball;
        let ahead = |axis: usize| if normal[axis] * moving[axis] > 0.0 { normal[axis].abs() } else { 0.0 };
        let into = if ahead(0) > ahead(1) {
            Vector2::new(normal.x.signum(), 0.0)
        } else {
            Vector2::new(0.0, normal.y.signum())
        };
        let contact = Contact { at: *at, into, moving: *moving, ball: *ball };
        self.contacts.push(contact);
        self.spacing = spacing(&self.contacts, &self.known, self.spacing);
        contact
    }

    /// A face of a wall was seen from one place to another, level or upright; `into` leads into it. It counts as touches, no farther apart
    /// than a passage is wide, where nothing of it was known.
    pub fn see(&mut self, from: &Place, to: &Place, into: &Vector2<f64>) {
        let along = to - from;
        let before = self.contacts.len();
        let pieces = (along.norm() / (0.6 * self.known.passage)).ceil().max(1.0);
        for piece in 0..=pieces as u32 {
            let at = from + along * (f64::from(piece) / pieces);
            let ball = at - into * self.known.radius;
            let contact = Contact { at, into: *into, moving: Vector2::zeros(), ball };
            let is_known = self.contacts.iter().any(|one| {
                one.into == contact.into
                    && one.is_of_the_wall_of(&contact, self.known.wall)
                    && (one.at - contact.at).norm() < 0.3 * self.known.passage
            });
            if !is_known {
                self.contacts.push(contact);
            }
        }
        if self.contacts.len() > before {
            self.spacing = spacing(&self.contacts, &self.known, self.spacing);
        }
    }

    /// The ball slid along a wall, its centre from one place to another; `into` leads into the wall, level or upright. All between counts
    /// as touched. Unlike of a [`touch`](Self::touch), it is known in which direction the wall lies: by the force that the ball felt.
    ///
    /// ```
    /// use mrroc_map::{Knowledge, Map, Place};
    /// let known = Knowledge { size: [0.4, 0.4], radius: 0.002, thickness: 0.002, passage: 0.015, wall: 0.025 };
    /// let mut map = Map::new(known);
    /// // 60 mm along a level wall above, whose face is at y = 49 mm.
    /// map.slide(&Place::new(0.02, 0.047), &Place::new(0.08, 0.047), &Place::new(0.0, 1.0));
    /// assert!(map.contacts().iter().all(|contact| (contact.at.y - 0.049).abs() < 1e-12));
    /// assert!(map.contacts().windows(2).all(|two| (two[1].at - two[0].at).norm() < known.passage));
    /// ```
    pub fn slide(&mut self, from: &Place, to: &Place, into: &Vector2<f64>) {
        let (face, along) = (into * self.known.radius, to - from);
        let pieces = (along.norm() / (0.4 * self.known.passage)).ceil().max(1.0);
        for piece in 0..=pieces as u32 {
            let ball = from + along * (f64::from(piece) / pieces);
            let at = ball + face;
            let is_known =
                |one: &Contact| one.into == *into && (one.at - at).norm() < 0.1 * self.known.passage;
            // The first one always: what is touched again and again is remembered as often.
            if piece == 0 || !self.contacts.iter().any(is_known) {
                self.contacts.push(Contact { at, into: *into, moving: *into, ball });
            }
        }
        self.spacing = spacing(&self.contacts, &self.known, self.spacing);
    }

    /// How far on from a contact, along `beside`, a wall may go \[m\]: as far as it is believed to, or to where the ball has passed.
    pub(crate) fn belief(&self, contact: &Contact, beside: &Vector2<f64>) -> f64 {
        let middle = contact.at + contact.into * (0.5 * self.known.thickness);
        let (most, square) = (self.known.wall, self.known.square());
        let mut s = square;
        while s < most {
            let at = middle + beside * s;
            if self.index(&at).is_none() || self.thought(&at) == Thought::Passed {
                return s;
            }
            s += square;
        }
        most
    }
}
