//! Masses of the links: what `<inertial>` says of those that a joint moves, as one body, which must be one that can be.
//!
//! ```text
//! A <= B <= C, principal moments:   A >= 0,   C <= A + B      (of any mass, whatever its shape)
//! ```
//!
//! The first is asked of each link: without it, simulated drives could run away. The second is asked of the links of a body together:
//! many files have placeholders on links that weigh nothing, which change nothing where they are fixed to one that weighs something.

use mrroc::pose::Pose;
use mrroc::robot::Load;
use nalgebra::{Matrix3, Point3, Vector3};

use super::document::{Element, Tree, origin, shown};
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

/// Links that are fixed to one another, and which of them has the inertia that is most unlike that of a body.
#[derive(Clone, Debug, Default)]
pub(super) struct Rigid {
    body: Body,
    worst: Option<Suspect>,
}

/// A link whose inertia no body has.
#[derive(Clone, Debug)]
struct Suspect {
    line: usize,
    link: String,
    principal: [f64; 3],
    /// By how much its largest moment exceeds the sum of the others [kg m²].
    excess: f64,
}

/// Largest part of a moment that the least one may be below 0, for rounding: three digits of each number.
const BELOW_ZERO: f64 = 1e-3;

/// Largest part by which the largest principal moment may exceed the sum of the others. In any body it does not; moments that were
/// measured, or rounded, do so by up to 3 % in arms that are in use (of `example-robot-data`, Tiago's).
const BEYOND_SUM: f64 = 0.05;

impl Rigid {
    /// Adds the link `name`, whose frame stands at `X_JL` in the joint's.
    ///
    /// # Errors
    /// A mass or a moment is negative, or no number.
    #[allow(non_snake_case)]
    pub(super) fn add(&mut self, tree: &Tree<'_, '_>, name: &str, X_JL: &Pose) -> Result<(), UrdfError> {
        let Some(link) = tree.link(name) else { return Ok(()) };
        let Some(inertial) = link.child("inertial")? else { return Ok(()) };
        let mass = at_least_zero(&inertial.required("mass", "<mass value=\"..\"/> [kg]")?, "value")?;
        let X_LC = origin(&inertial, tree.has_quaternions)?;
        let (mut inertia, mut spin) = (Matrix3::zeros(), 0.0);
        if let Some(element) = inertial.child("inertia")? {
            inertia = tensor(&element)?;
            let principal = principal(&inertia);
            let [least, middle, largest] = principal;
            spin = largest;
            let (line, link) = (element.line(), shown(name));
            if least.is_nan() || least < -BELOW_ZERO * largest {
                return Err(UrdfError::NegativeInertia { line, link, principal });
            }
            let excess = largest - least - middle;
            if excess > self.worst.as_ref().map_or(0.0, |worst| worst.excess) {
                self.worst = Some(Suspect { line, link, principal, excess });
            }
        }
        let X_JC = X_JL * X_LC;
        let centre = (X_JC * Point3::origin()).coords;
        let turned = X_JC.rotation.to_rotation_matrix().into_inner();
        let inertia = turned * inertia * turned.transpose();
        self.body = self.body.joined(&Body { mass, centre, spin, inertia });
        Ok(())
    }

    /// All of them as one body.
    ///
    /// # Errors
    /// No body has their inertia, though they are taken together: [`UrdfError::ImpossibleInertia`] of the link that adds most to that.
    pub(super) fn body(self) -> Result<Body, UrdfError> {
        let Self { body, worst } = self;
        let Some(Suspect { line, link, principal: of_link, .. }) = worst else { return Ok(body) };
        let [least, middle, largest] = principal(&body.inertia);
        if largest > (1.0 + BEYOND_SUM) * (least + middle) {
            return Err(UrdfError::ImpossibleInertia { line, link, principal: of_link, limit: BEYOND_SUM });
        }
        Ok(body)
    }
}

/// Principal moments in ascending order [kg m²]; no numbers where those of the tensor have overflowed: the iteration would not end.
fn principal(inertia: &Matrix3<f64>) -> [f64; 3] {
    if !inertia.iter().all(|number| number.is_finite()) {
        return [f64::NAN; 3];
    }
    let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
    moments.sort_unstable_by(f64::total_cmp);
    moments
}

impl Body {
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
