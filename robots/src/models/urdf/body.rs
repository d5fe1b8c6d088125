//! Masses of the links: what `<inertial>` says of those that a joint moves, as one body.

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};

use super::chain::origin;
use super::document::{Element, Tree};
use super::error::UrdfError;

/// The links that are fixed to one another behind a joint, up to the next joint that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Body {
    /// \[kg\], >= 0.
    pub(super) mass: f64,
    /// Centre of mass in the joint's frame, z along its axis \[m\].
    pub(super) centre: Vector3<f64>,
    /// No axis through the centre has a greater moment of inertia [kg m²].
    pub(super) spin: f64,
}

impl Body {
    /// The body together with the link `name`, whose frame stands at `X_JL` in the joint's.
    #[allow(non_snake_case)]
    pub(super) fn with_link(self, tree: &Tree<'_, '_>, name: &str, X_JL: &Pose) -> Result<Self, UrdfError> {
        let Some(link) = tree.link(name) else { return Ok(self) };
        let Some(inertial) = link.child("inertial")? else { return Ok(self) };
        let mass = at_least_zero(&inertial.required("mass", "<mass value=\"..\"/> [kg]")?, "value")?;
        let X_LC = origin(&inertial, tree.has_quaternions)?;
        let spin = inertial.child("inertia")?.map_or(Ok(0.0), |inertia| spin(&inertia))?;
        let centre = (X_JL * X_LC * Point3::origin()).coords;
        Ok(self.joined(&Self { mass, centre, spin }))
    }

    fn joined(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self { spin: self.spin + other.spin, ..*self };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let off = |body: &Self| body.spin + body.mass * (body.centre - centre).norm_squared();
        Self { mass, centre, spin: off(self) + off(other) }
    }
}

fn at_least_zero(element: &Element<'_, '_>, attribute: &'static str) -> Result<f64, UrdfError> {
    let number = element.number(attribute)?.ok_or_else(|| element.missing(attribute, "a number >= 0"))?;
    if number < 0.0 { Err(element.bad(attribute, "a finite number >= 0")) } else { Ok(number) }
}

/// The root of the sum of the squares of a tensor of inertia: at least its largest moment.
fn spin(inertia: &Element<'_, '_>) -> Result<f64, UrdfError> {
    inertia.only(&["ixx", "ixy", "ixz", "iyy", "iyz", "izz"])?;
    let mut square = 0.0;
    for moment in ["ixx", "iyy", "izz"] {
        square += at_least_zero(inertia, moment)?.powi(2);
    }
    for product in ["ixy", "ixz", "iyz"] {
        let number = inertia.number(product)?.ok_or_else(|| inertia.missing(product, "a number [kg m^2]"))?;
        square += 2.0 * number * number;
    }
    Ok(square.sqrt())
}
