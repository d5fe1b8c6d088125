//! Coordinate systems: the origins of G54 to G59.3, and the shift that G92 and G52 lay over them.
//!
//! A place of the machine is `work + system + shift`. The machine's own zero is where the plate's surface and the
//! corner of all drawings is: all origins are there until the program moves them.

use crate::drawing::Vec3;

/// The systems' names, by index.
pub const NAMES: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// All systems and which is active.
#[derive(Clone, Debug, Default)]
pub struct Coordinates {
    /// Origins in machine coordinates \[mm\].
    pub systems: [Vec3; 9],
    /// Which of them the program has set.
    pub set: [bool; 9],
    /// Which of them the program has chosen.
    pub chosen: [bool; 9],
    /// The active one, from 0.
    pub active: usize,
    shift: Vec3,
    /// Whether the shift counts: G92.2 puts it by, G92.3 takes it up again.
    shifted: bool,
}

impl Coordinates {
    /// The shift that counts \[mm\].
    pub fn shift(&self) -> Vec3 {
        if self.shifted { self.shift } else { Vec3::zeros() }
    }

    /// Where the active coordinates are zero \[mm, machine\].
    pub fn origin(&self) -> Vec3 {
        self.systems[self.active] + self.shift()
    }

    /// Chooses a system, from 0.
    pub fn choose(&mut self, system: usize) {
        self.active = system;
        self.chosen[system] = true;
    }

    /// G10 L2: an axis of a system's origin \[mm, machine\].
    pub fn set_origin(&mut self, system: usize, axis: usize, origin: f64) {
        self.systems[system][axis] = origin;
        self.set[system] = true;
    }

    /// G10 L20: the origin with which the machine's place \[mm\] has this coordinate \[mm\].
    pub fn set_here(&mut self, system: usize, axis: usize, place: f64, coordinate: f64) {
        self.set_origin(system, axis, place - self.shift()[axis] - coordinate);
    }

    /// G92: the shift with which the machine's place \[mm\] has this coordinate \[mm\].
    pub fn shift_here(&mut self, axis: usize, place: f64, coordinate: f64) {
        self.shift_by(axis, place - self.systems[self.active][axis] - coordinate);
    }

    /// G52: the shift of an axis \[mm\].
    pub fn shift_by(&mut self, axis: usize, shift: f64) {
        self.shift = self.shift();
        self.shifted = true;
        self.shift[axis] = shift;
    }

    /// G92.1: no shift.
    pub fn forget_shift(&mut self) {
        self.shift = Vec3::zeros();
    }

    /// G92.2 puts the shift by, G92.3 takes it up again.
    pub fn keep_shift(&mut self, counts: bool) {
        self.shifted = counts;
    }

    /// What the program leaves open: systems that it uses beside another one and does not place.
    pub fn unplaced(&self) -> Vec<&'static str> {
        let used = (0..9).filter(|n| self.chosen[*n] || self.set[*n]).count();
        (1..9).filter(|n| used > 1 && self.chosen[*n] && !self.set[*n]).map(|n| NAMES[n]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn g92_moves_all_origins_so_that_the_place_has_the_coordinate() {
        // The example of LinuxCNC's manual: at X4, G92 X7 moves the origins by -3.
        let mut coordinates = Coordinates::default();
        coordinates.shift_here(0, 4.0, 7.0);
        assert_eq!(coordinates.origin().x, -3.0);
        coordinates.keep_shift(false);
        assert_eq!(coordinates.origin().x, 0.0);
        coordinates.keep_shift(true);
        assert_eq!(coordinates.origin().x, -3.0);
        coordinates.forget_shift();
        coordinates.keep_shift(true);
        assert_eq!(coordinates.origin().x, 0.0);
    }

    #[test]
    fn l20_leaves_the_shift_and_places_the_system() {
        let mut coordinates = Coordinates::default();
        coordinates.shift_by(1, 2.0);
        coordinates.set_here(1, 1, 10.0, 1.5);
        coordinates.choose(1);
        // Work coordinate: 10 - origin = 1.5.
        assert_eq!(coordinates.origin().y, 8.5);
        assert!(coordinates.unplaced().is_empty());
        coordinates.choose(2);
        assert_eq!(coordinates.unplaced(), ["G56"]);
    }
}
