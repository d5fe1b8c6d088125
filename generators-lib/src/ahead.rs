//! Places where a path leads, for a generator that names them in its first steps: a place out of reach is refused there, and
//! not when the motion comes to it.

/// Places along a path that are named ahead.
const PLACES: u8 = 8;

/// Shares of a path at which its places are named, one in each of the first steps: its end first, then places before it.
///
/// ```
/// use mrroc_generators::ahead::Ahead;
///
/// let shares: Vec<f64> = Ahead::default().collect();
/// assert_eq!((shares[0], shares[7], shares.len()), (1.0, 0.125, 8));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    left: u8,
}

impl Default for Ahead {
    fn default() -> Self {
        Ahead { left: PLACES }
    }
}

impl Iterator for Ahead {
    type Item = f64;

    /// The next share, 1 to 1/8; then none.
    fn next(&mut self) -> Option<f64> {
        let left = self.left.checked_sub(1)?;
        let share = f64::from(self.left) / f64::from(PLACES);
        self.left = left;
        Some(share)
    }
}
