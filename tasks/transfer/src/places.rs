//! Where things are, and how fast they may move: what the programs know of the cell besides its robots.
//!
//! Frames: W world, with z up; B body, in the middle of the bar, x along it; E the tool of an arm, between its fingertips,
//! z ahead, fingers along x.
//!
//! The numbers come from a search over places of the bar and of Polycrank's base for the paths of both tools that stays
//! farthest from singularities: Polycrank's is at least 0.09 away from one (of 0.11 at best; it has one where the tool is
//! vertical), RNT's 0.16 (it has one where tool and forearm are in line); lengths counted in the arm's reach.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use mrroc::pose::Pose;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// The bar's mass \[kg\] and its edges along x, y, z of B \[m\].
pub const MASS: f64 = 2.0;
/// See [`MASS`].
pub const EDGES: [f64; 3] = [0.4, 0.06, 0.06];
/// Height of the table \[m\].
pub const TABLE: f64 = 0.87;
/// The table's edges along x, y, z \[m\].
pub const TABLE_EDGES: [f64; 3] = [0.6, 0.9, 0.02];
/// Where the hands hold the bar: at this distance from its middle \[m\].
pub const GRIP: f64 = 0.17;
/// Openings of a hand \[m\]: around the bar, and pressing on it, 60 mm wide.
pub const OPEN: f64 = 0.075;
/// See [`OPEN`].
pub const CLOSED: f64 = 0.057;

/// Where Polycrank's base is believed to be: that of cell.toml.
#[must_use]
pub fn polycrank_base() -> Pose {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f64::consts::PI);
    Pose::from_parts(Translation3::new(1.8, -0.3, -0.45), turned)
}

/// Where the table's middle is: half-way between where the bar lies first and last.
#[must_use]
pub fn table() -> Pose {
    let bar = bar().translation;
    Pose::translation(bar.x, bar.y + 0.125, TABLE - 0.5 * TABLE_EDGES[2])
}

/// `X_WB` of the bar on the table, to begin with.
#[must_use]
pub fn bar() -> Pose {
    Pose::translation(0.95, -0.15, TABLE + 0.5 * EDGES[2])
}

/// The end of the bar that an arm holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At negative x of B: RNT's.
    Near,
    /// At positive x of B: Polycrank's.
    Far,
}

/// `X_BE` of a grasp: the tool points down by 45 degrees, towards the middle; its fingers close across the bar.
#[must_use]
pub fn grasp(end: End) -> Pose {
    let (side, turn) = match end {
        End::Near => (-1.0, FRAC_PI_2),
        End::Far => (1.0, -FRAC_PI_2),
    };
    // z_E down and x_E along y_B first, then the tilt about it.
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    let across = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_4);
    Pose::from_parts(Translation3::new(side * GRIP, 0.0, 0.0), across * down * tilt)
}

/// Back from a grasp to where the fingers are clear of the bar, in the tool's axes.
#[must_use]
pub fn back() -> Pose {
    Pose::translation(0.0, 0.0, -0.15)
}

/// The bar's path, leg by leg: `X_BsB` from the start of each. Up, over, where it is turned by 20 degrees, and down.
#[must_use]
pub fn legs() -> [Pose; 3] {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 20_f64.to_radians());
    [
        Pose::translation(0.0, 0.0, 0.12),
        Pose::from_parts(Translation3::new(0.0, 0.25, 0.0), turn),
        Pose::translation(0.0, 0.0, -0.12),
    ]
}

/// How fast a tool or the bar may move: so that Polycrank, which has most to do, keeps a fifth of its limits in reserve.
#[must_use]
pub fn limits() -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity: 0.1, acceleration: 0.15 },
        rotation: ProfileLimits { velocity: 0.3, acceleration: 0.5 },
    }
}
