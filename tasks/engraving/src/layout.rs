//! Where everything stands: the arm, its tool, the plate in front of it; and whether the arm reaches the drawing.

use mrroc::prelude::*;
use mrroc_robots::{Irp6, Six};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::drawing::Vec2;
use crate::placement::Plate;

/// Length of the milling head with its cutter, from the flange \[m\].
pub const TOOL_LENGTH: f64 = 0.25;

/// Where the middle of the plate lies in front of the arm [m, world]; the height is what the fixture promises.
const MIDDLE: Vector3<f64> = Vector3::new(0.85, 0.0, 0.10);

/// How the simulated plate differs from the promised height \[m\]: what the probe has to find.
pub const HEIGHT_ERROR: f64 = -0.0017;

/// Height above the plate at which the arm waits and parks \[m\].
const PARK_HEIGHT: f64 = 0.05;

/// The cell's geometry.
#[derive(Clone)]
pub struct Layout {
    /// The arm.
    pub arm: Irp6,
    /// `X_FE`: the cutter's tip in the flange frame.
    pub tool: Pose,
    /// `X_WP`: the plate's lower left corner, as the fixture promises it; x to the right, y up (away from the arm).
    pub plate: Pose,
    /// `R_PE`: the tool's orientation on the plate, straight down.
    pub orientation: UnitQuaternion<f64>,
    /// Where the arm waits and parks \[rad\].
    pub park: Six,
}

/// A place of the plate that the arm cannot reach.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the arm does not reach ({x:.1}, {y:.1}) mm of the plate: {why}\n  what to do: use a smaller plate (--plate) or a smaller drawing (--size)"
)]
pub struct OutOfReach {
    /// The place \[mm\].
    pub x: f64,
    /// The place \[mm\].
    pub y: f64,
    /// What prevents it.
    pub why: &'static str,
}

impl Layout {
    /// The nominal arm in front of a plate of this size.
    ///
    /// # Errors
    /// [`OutOfReach`] when the arm does not even reach its own parking place.
    pub fn new(plate: &Plate) -> Result<Layout, OutOfReach> {
        let arm = Irp6::nominal();
        // Seen from the arm, the plate's x runs to the right and its y away: x_P = -y_W, y_P = x_W.
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -core::f64::consts::FRAC_PI_2);
        let corner = MIDDLE - turn * Vector3::new(plate.width * 0.5e-3, plate.height * 0.5e-3, 0.0);
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
        let mut layout = Layout {
            arm,
            tool: Pose::translation(0.0, 0.0, TOOL_LENGTH),
            plate: Pose::from_parts(Translation3::from(corner), turn),
            orientation: turn.inverse() * down,
            park: Irp6::READY,
        };
        let middle = Vec2::new(plate.width / 2.0, plate.height / 2.0);
        layout.park = layout.joints(middle, PARK_HEIGHT)?;
        Ok(layout)
    }

    /// The joints that put the tip over a place of the plate \[mm\], `height` above it \[m\].
    ///
    /// # Errors
    /// [`OutOfReach`] when no joints within the limits do.
    pub fn joints(&self, place: Vec2, height: f64) -> Result<Six, OutOfReach> {
        let out = |why| OutOfReach { x: place.x, y: place.y, why };
        let position = Translation3::new(place.x * 1e-3, place.y * 1e-3, height);
        let flange = self.plate * Pose::from_parts(position, self.orientation) * self.tool.inverse();
        let joints =
            self.arm.inverse(&flange, &self.park).map_err(|_| out("it is too far away or too near"))?;
        if self.arm.is_feasible(&joints) {
            Ok(joints)
        } else {
            Err(out("a joint or a motor is at its limit"))
        }
    }
}
