//! A part as physics and as light meet it.

use mrroc::pose::Pose;
use mrroc_robots::grasp::Body;
use nalgebra::Vector3;

use crate::form::{Form, Piece};

/// A part: its body, and its form. The frame P of the form lies where the part stands, z up.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Workpiece {
    /// What light and sound meet, in P.
    pub form: Form,
    /// What moves, in its frame B.
    pub body: Body,
    /// `X_BP`.
    pub X_BP: Pose,
    /// How much light it scatters, 0 to 1.
    pub reflectance: f64,
}

impl Workpiece {
    /// A block of these edges \[m\] and this mass \[kg\], all > 0. P is in the middle of its bottom.
    ///
    /// ```
    /// use mrroc_sensors::simulated::Workpiece;
    ///
    /// let block = Workpiece::block([0.07, 0.05, 0.04], 0.2).painted(0.8);
    /// assert_eq!(block.X_BP.translation.z, -0.02);
    /// ```
    #[must_use]
    pub fn block(edges: [f64; 3], mass: f64) -> Self {
        let [x, y, z] = edges;
        let lower = Vector3::new(-0.5 * x, -0.5 * y, 0.0);
        let form = Form::new([Piece::Block { lower, upper: Vector3::new(0.5 * x, 0.5 * y, z) }]);
        Self::of(form, Body::block(mass, edges), Pose::translation(0.0, 0.0, -0.5 * z))
    }

    /// An upright disc of this diameter and height \[m\] and this mass \[kg\], all > 0. P is in the middle of its bottom.
    #[must_use]
    pub fn disc(diameter: f64, height: f64, mass: f64) -> Self {
        let form = Form::new([Piece::Tube { radius: 0.5 * diameter, inner: 0.0, height }]);
        Self::of(form, Body::disc(mass, diameter, height), Pose::translation(0.0, 0.0, -0.5 * height))
    }

    /// A body that looks like this form, whose frame P is at `X_BP` in the body's frame. It scatters 0.6 of the light.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn of(form: Form, body: Body, X_BP: Pose) -> Self {
        Self { form, body, X_BP, reflectance: 0.6 }
    }

    /// The same part that scatters this share of the light, 0 to 1.
    #[must_use]
    pub fn painted(self, reflectance: f64) -> Self {
        Self { reflectance, ..self }
    }
}
