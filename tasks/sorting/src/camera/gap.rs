//! Where on the belt there are things, and whether a part can be put back between them.
//!
//! In: what the sensor over the belt says, which parts arms have taken. Out: whether a place of the belt stays clear until a hand has gone
//! down there, has let go its part, and is above all parts again, after `CLEAR` \[s\]. The part lies there from the moment at which it is let go, and
//! goes with the belt. So no thing may be, now, at
//!
//! ```text
//! s - APART - v CLEAR  ..  s + APART
//! ```
//!
//! The belt may change its speed meanwhile, so `v` is the largest that it may have: the one that its coordinator asks for, with what a worn drive
//! adds to that, however slowly it runs at first; or what it has had so far, if that is larger. One that has run back brings things from ahead as
//! well.

use std::collections::VecDeque;

use mrroc_sensors::virtual_sensors::Spotted;

/// A thing on the belt: a part by its number, 0 of one that is none of the kinds; and from where to where its frame may be, along the belt
/// where that had run 0 \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Thing {
    number: u32,
    from: f64,
    to: f64,
}

/// Things on the belt.
#[derive(Clone, Debug, Default)]
pub struct Things {
    all: VecDeque<Thing>,
    unknown: u32,
    /// The lowest speed of the belt so far, or 0, and the highest that it may have [m/s].
    speeds: [f64; 2],
}

impl Things {
    /// Frames of two parts that are clear of each other, turned anyhow, are so far apart \[m\]: the farthest corner of a part is 75 mm from its
    /// frame.
    pub const APART: f64 = 0.16;
    /// A hand that puts a part back is above all parts again after this time \[s\]: down in 0.57 s, open 0.8 s later, 20 mm higher in 0.16 s, and
    /// some to spare.
    pub const CLEAR: f64 = 1.7;
    /// A thing that is none of the kinds is told of without its place. It is here then, along s \[m\]: below the sensor, or just past it.
    const UNKNOWN: [f64; 2] = [-0.65, -0.2];
    /// From here on the sensor has told of all that comes, along s \[m\]. An arm lifts no part nearer to this than it needs, `APART + v CLEAR`:
    /// it has gone with the part for 1.5 s by then, from s = 0 on.
    const TOLD: f64 = -0.22;
    /// So many things are remembered: more than there is room for on the belt.
    const MOST: usize = 64;

    /// On a belt that may run so fast [m/s].
    #[must_use]
    pub fn on_belt(fastest: f64) -> Self {
        Self { speeds: [0.0, fastest], ..Self::default() }
    }

    /// Takes in what the sensor says; `newest` is the number of the newest part that is known. Things beyond `end`, along s \[m\], are of no
    /// interest any more.
    pub fn take(&mut self, seen: &Spotted, newest: u32, end: f64) {
        self.speeds = self.speeds_with(seen);
        for part in seen.newest.iter().rev().filter(|part| part.number > newest) {
            self.push(Thing { number: part.number, from: part.along, to: part.along });
        }
        if seen.unknown != self.unknown {
            self.unknown = seen.unknown;
            let [from, to] = Self::UNKNOWN.map(|place| place - seen.travel);
            self.push(Thing { number: 0, from, to });
        }
        self.all.retain(|thing| thing.from + seen.travel < end);
    }

    fn push(&mut self, thing: Thing) {
        if self.all.len() == Self::MOST {
            self.all.pop_front();
        }
        self.all.push_back(thing);
    }

    /// A part is in a hand.
    pub fn lift(&mut self, number: u32) {
        self.all.retain(|thing| thing.number != number);
    }

    /// A part is put back at a place along s \[m\], from now on within [`CLEAR`](Self::CLEAR): until it is let go the belt runs on below it.
    pub fn put_back(&mut self, number: u32, s: f64, seen: &Spotted) {
        let now = s - seen.travel;
        let [back, forth] = self.speeds_with(seen).map(|speed| speed * Self::CLEAR);
        self.push(Thing { number, from: now - forth, to: now - back });
    }

    fn speeds_with(&self, seen: &Spotted) -> [f64; 2] {
        [self.speeds[0].min(seen.speed), self.speeds[1].max(seen.speed)]
    }

    /// Whether a part can be put back at a place along s \[m\].
    #[must_use]
    pub fn is_clear(&self, s: f64, seen: &Spotted) -> bool {
        let [back, forth] = self.speeds_with(seen).map(|speed| speed * Self::CLEAR);
        let (from, to) = (s - Self::APART - forth, s + Self::APART - back);
        let is_there = |thing: &Thing| thing.to + seen.travel > from && thing.from + seen.travel < to;
        let is_told = s - Self::APART - seen.speed.max(0.0) * Self::CLEAR > Self::TOLD;
        is_told && !self.all.iter().any(is_there)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::kinds::{kinds, strangers};
    use mrroc_sensors::virtual_sensors::OnBelt;

    /// A part that is told of at a place along s \[m\], where the belt has run so far.
    fn told(number: u32, s: f64, travel: f64) -> Spotted {
        let mut seen = Spotted { parts: number, travel, speed: 0.1, ..Spotted::default() };
        seen.newest[0] = OnBelt { number, along: s - travel, ..OnBelt::default() };
        seen
    }

    #[test]
    fn a_place_is_clear_where_nothing_is_and_nothing_comes_until_the_hand_is_up_again() {
        let mut things = Things::default();
        things.take(&told(1, -0.3, 5.0), 0, 1.0);
        let place = |s: f64| Spotted { travel: 5.0 + s + 0.3, speed: 0.1, ..Spotted::default() };
        // It is 0.16 m + 0.1 m/s 1.7 s = 0.33 m and more upstream, and comes nearer, and has gone on by 0.16 m.
        for (s, wanted) in
            [(0.1, true), (0.169, true), (0.171, false), (0.5, false), (0.659, false), (0.661, true)]
        {
            assert_eq!(things.is_clear(0.5, &place(s)), wanted, "{s}");
        }
        // A belt that turns back brings it from ahead.
        let back = Spotted { speed: -0.1, ..place(0.8) };
        assert!(things.is_clear(0.5, &place(0.8)) && !things.is_clear(0.5, &back));
        // So does one that stands and may turn back again, as one that starts again brings what is upstream.
        let mut turned = things.clone();
        turned.take(&back, 1, 1.0);
        let standing = |s: f64| Spotted { speed: 0.0, ..place(s) };
        assert!(!turned.is_clear(0.5, &standing(0.8)) && !things.is_clear(0.5, &standing(0.2)));
        // What is in a hand is in nobody's way; what was put back is.
        things.lift(1);
        assert!(things.is_clear(0.5, &place(0.5)));
        things.put_back(1, 0.5, &place(0.5));
        // When the belt has run 0.2 m on, it is 0.2 m farther, less up to 0.17 m for the time until it was let go.
        for (s, wanted) in [(0.36, true), (0.38, false), (0.5, false), (1.02, false), (1.04, true)] {
            assert_eq!(things.is_clear(s, &place(0.7)), wanted, "{s}");
        }
    }

    #[test]
    fn a_thing_that_is_none_of_the_kinds_is_somewhere_below_the_sensor_when_it_is_told_of() {
        let mut things = Things::default();
        things.take(&Spotted { unknown: 1, travel: 5.0, speed: 0.1, ..Spotted::default() }, 0, 1.0);
        let after = |run: f64| Spotted { unknown: 1, travel: 5.0 + run, speed: 0.1, ..Spotted::default() };
        // From -0.65 to -0.2 m: it may come from 0.37 m on, and has gone after 1.31 m.
        for (run, wanted) in [(0.36, true), (0.38, false), (1.3, false), (1.32, true)] {
            assert_eq!(things.is_clear(0.5, &after(run)), wanted, "{run}");
        }
        // Nobody knows yet what comes from upstream of the sensor.
        assert!(!Things::default().is_clear(0.1, &after(0.0)));
        // It is forgotten where no arm is any more.
        things.take(&after(1.7), 0, 1.0);
        assert!(things.all.is_empty());
    }

    #[test]
    fn a_gap_is_as_long_as_a_belt_that_begins_slowly_may_need_later() {
        let slow = |things: &mut Things| {
            let seen = Spotted { speed: 0.02, ..told(1, -0.3, 5.0) };
            things.take(&seen, 0, 1.0);
        };
        let (mut known, mut asked) = (Things::default(), Things::on_belt(0.122));
        slow(&mut known);
        slow(&mut asked);
        let place = |s: f64| Spotted { travel: 5.0 + s + 0.3, speed: 0.02, ..Spotted::default() };
        // A thing 0.16 m + 0.02 m/s 1.7 s upstream is clear of a belt that stays as slow; at 0.122 m/s it comes 0.21 m nearer.
        for (s, wanted) in
            [(0.5 - 0.2, [true, false]), (0.5 - 0.36, [true, false]), (0.5 - 0.37, [true, true])]
        {
            assert_eq!([&known, &asked].map(|things| things.is_clear(0.5, &place(s))), wanted, "{s}");
        }
    }

    #[test]
    fn two_parts_whose_frames_are_apart_do_not_touch() {
        let corners = kinds().into_iter().chain(strangers());
        let farthest =
            corners.flat_map(|kind| kind.outline().to_vec()).map(|[x, y]| x.hypot(y)).fold(0.0, f64::max);
        assert!(2.0 * farthest < Things::APART, "{farthest}");
    }
}
