//! Masses of the links: what `<inertial>` says of those that a joint moves, as one body.

use mrroc::pose::Pose;
use mrroc::robot::Load;
use nalgebra::{Matrix3, Point3, Vector3};

use super::document::{Element, Tree, origin};
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
    /// Inertia about the centre, in the axes of the joint's frame [kg m²].
    pub(super) inertia: Matrix3<f64>,
}

impl Body {
    /// The body together with the link `name`, whose frame stands at `X_JL` in the joint's.
    #[allow(non_snake_case)]
    pub(super) fn with_link(self, tree: &Tree<'_, '_>, name: &str, X_JL: &Pose) -> Result<Self, UrdfError> {
        let Some(link) = tree.link(name) else { return Ok(self) };
        let Some(inertial) = link.child("inertial")? else { return Ok(self) };
        let mass = at_least_zero(&inertial.required("mass", "<mass value=\"..\"/> [kg]")?, "value")?;
        let X_LC = origin(&inertial, tree.has_quaternions)?;
        let inertia = inertial.child("inertia")?.map_or(Ok(Matrix3::zeros()), |inertia| tensor(&inertia))?;
        let X_JC = X_JL * X_LC;
        let centre = (X_JC * Point3::origin()).coords;
        let turned = X_JC.rotation.to_rotation_matrix().into_inner();
        let spin = spin(&inertia);
        Ok(self.joined(&Self { mass, centre, spin, inertia: turned * inertia * turned.transpose() }))
    }

    fn joined(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self { spin: self.spin + other.spin, inertia: self.inertia + other.inertia, ..*self };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let off = |body: &Self| body.spin + body.mass * (body.centre - centre).norm_squared();
        let about = |body: &Self| {
            let r = body.centre - centre;
            body.inertia + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * body.mass
        };
        Self { mass, centre, spin: off(self) + off(other), inertia: about(self) + about(other) }
    }

    /// The body of a tree.
    pub(super) fn load(&self) -> Load {
        Load { mass: self.mass, centre: self.centre, inertia: self.inertia }
    }
}

fn at_least_zero(element: &Element<'_, '_>, attribute: &'static str) -> Result<f64, UrdfError> {
    let number = element.number(attribute)?.ok_or_else(|| element.missing(attribute, "a number >= 0"))?;
    if number < 0.0 { Err(element.bad(attribute, "a finite number >= 0")) } else { Ok(number) }
}

/// A tensor of inertia.
fn tensor(inertia: &Element<'_, '_>) -> Result<Matrix3<f64>, UrdfError> {
    inertia.only(&["ixx", "ixy", "ixz", "iyy", "iyz", "izz"])?;
    let moment = |name| at_least_zero(inertia, name);
    let product = |name| inertia.number(name)?.ok_or_else(|| inertia.missing(name, "a number [kg m^2]"));
    let [xx, yy, zz] = [moment("ixx")?, moment("iyy")?, moment("izz")?];
    let [xy, xz, yz] = [product("ixy")?, product("ixz")?, product("iyz")?];
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// The root of the sum of the squares of a tensor of inertia: at least its largest moment.
fn spin(inertia: &Matrix3<f64>) -> f64 {
    let mut square = 0.0;
    for i in 0..3 {
        square += inertia[(i, i)].powi(2);
    }
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        square += 2.0 * inertia[(i, j)] * inertia[(i, j)];
    }
    square.sqrt()
}
