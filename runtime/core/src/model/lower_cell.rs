//! A lower cell as a robot of a higher MP: its kind, and the state that its MP tells.
//!
//! In: nothing, for no value of it exists; the cell itself is put under the other one by [`Cell::cell`](crate::cell::Cell::cell).
//! Out: the kind that an upper program names in its lists, and what it may ask of the image.

use nalgebra::SVector;

use crate::model::image::RobotImage;
use crate::model::pose::Pose;
use crate::model::robot::{Limits, NoInverse, Robot};
use crate::model::signals::{Signals, Values};

/// The kind of a cell that serves the MP of another cell, as one robot of that.
///
/// It takes *loose* orders, an `enum` with or without data, and has no joints: no [`Demand`](crate::generator::Demand) can be
/// given to it. A program names it where it names the kinds of robots: `mp.robot::<LowerCell>("press")`,
/// `Always<(LowerCell, LowerCell), Job>`.
///
/// Its image says what its MP told last: [`is_ready`](RobotImage::is_ready), [`is_latched`](RobotImage::is_latched),
/// [`rate`](RobotImage::rate).
///
/// A demand to a lower cell does not compile:
/// ```compile_fail
/// use mrroc::cell::LowerCell;
/// use mrroc::prelude::*;
///
/// #[generator(mp)]
/// fn hold() -> Always<(LowerCell,)> {
///     Always((Demand::hold(),))
/// }
///
/// fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
///     let mut press = mp.robot::<LowerCell>("press")?;
///     mp.move_robots((&mut press,), (), hold {}).map(drop)
/// }
/// # let _ = Cell::new(std::time::Duration::from_millis(1)).program(coordinate);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LowerCell {}

/// No joints.
type NoJoints = SVector<f64, 0>;

/// The bits of what a cell tells.
const READY: u32 = 1;
const LATCHED: u32 = 1 << 1;
const SUSPENDED: u32 = 1 << 2;

impl Robot for LowerCell {
    const KIND: &'static str = "cell";

    const MOVES: bool = false;

    type Joints = NoJoints;

    fn limits(&self) -> &Limits<NoJoints> {
        match *self {}
    }

    fn forward(&self, _: &NoJoints) -> Pose {
        match *self {}
    }

    #[allow(non_snake_case)]
    fn inverse(&self, _: &Pose, _: &NoJoints) -> Result<NoJoints, NoInverse> {
        match *self {}
    }
}

/// What the MP of a lower cell tells the upper one of its cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellStatus {
    /// Its program awaits an order, or serves one.
    pub ready: bool,
    /// A fault is latched.
    pub latched: bool,
    /// Its operator, or the upper cell's, has suspended it.
    pub suspended: bool,
    /// The rate of its path time, 0 to 1.
    pub rate: f64,
}

impl RobotImage<LowerCell> {
    /// The image of a cell in this state, for calling a step function in a test.
    #[must_use]
    pub fn of_cell(status: CellStatus) -> Self {
        let bit = |is: bool, bit| if is { bit } else { 0 };
        let digital =
            bit(status.ready, READY) | bit(status.latched, LATCHED) | bit(status.suspended, SUSPENDED);
        let inputs = Values::new(digital, [status.rate, 0.0, 0.0, 0.0]);
        RobotImage::unknown().with_signals(Signals { inputs, outputs: Values::OFF })
    }

    /// Whether its program awaits an order, or serves one.
    #[must_use]
    pub const fn is_ready(&self) -> bool {
        self.signals().inputs.digital() & READY != 0
    }

    /// Whether a fault is latched in it, or it says nothing any more.
    #[must_use]
    pub const fn is_latched(&self) -> bool {
        self.signals().inputs.digital() & LATCHED != 0
    }

    /// Whether its operator, or this cell's, has suspended it.
    #[must_use]
    pub const fn is_suspended(&self) -> bool {
        self.signals().inputs.digital() & SUSPENDED != 0
    }

    /// The rate of its path time, 0 to 1: the product of what this cell's rate is and its own operator's speed, while it changes to that.
    #[must_use]
    pub const fn rate(&self) -> f64 {
        self.signals().inputs.analog(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::image::IMAGE_WORDS;
    use crate::model::wire::Wire;

    #[test]
    fn the_words_of_a_cell_s_image_say_its_state() {
        for bits in 0..8 {
            let status = CellStatus {
                ready: bits & 1 != 0,
                latched: bits & 2 != 0,
                suspended: bits & 4 != 0,
                rate: 0.5,
            };
            let mut words = [0; IMAGE_WORDS];
            RobotImage::<LowerCell>::of_cell(status).put(&mut words);
            let image = RobotImage::<LowerCell>::get(&words).expect("the words of an image");
            let told = CellStatus {
                ready: image.is_ready(),
                latched: image.is_latched(),
                suspended: image.is_suspended(),
                rate: image.rate(),
            };
            assert_eq!(told, status);
        }
    }
}
