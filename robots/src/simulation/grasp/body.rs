//! A rigid body: its mass, inertia and hull, and how it moves under forces.
//!
//! ```text
//! dp/dt = f,   p = m v            momentum [N s]
//! dl/dt = tau, l = R I R^T omega  angular momentum about the centre of mass, in the world's axes [N m s]
//! ```
//!
//! Position and attitude drift with constant momenta, momenta are kicked at constant position: the leapfrog scheme, of
//! second order, which conserves both momenta in free flight to round-off. The attitude drifts by the midpoint rule.

use mrroc::pose::{Pose, Wrench};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::error::{WorldError, positive};
use super::turn;

/// A rigid body at rest. Its frame B lies in its centre of mass.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Body {
    pub(super) mass: f64,
    pub(super) inertia: Matrix3<f64>,
    pub(super) points: Vec<Vector3<f64>>,
    pub(super) faces: Vec<Face>,
    /// Its side, if that is round where it touches the edge of a hole.
    pub(super) barrel: Option<Barrel>,
    pub(super) X_WB: Pose,
}

/// A face of a convex body: all of it lies where `normal . p <= offset`, in B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    /// Unit vector, outwards.
    pub normal: Vector3<f64>,
    /// \[m\].
    pub offset: f64,
}

/// An upright cylinder about z of B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Barrel {
    /// \[m\].
    pub radius: f64,
    /// Half of its height \[m\].
    pub half: f64,
}

impl Barrel {
    /// How deep a point of B is in it \[m\], negative outside, and the normal of the nearest face, outwards.
    pub fn depth(&self, at: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let rho = at.x.hypot(at.y);
        let end = (self.half - at.z.abs(), Vector3::z() * at.z.signum());
        let side = self.radius - rho;
        if side < end.0 && rho > 0.0 { (side, Vector3::new(at.x / rho, at.y / rho, 0.0)) } else { end }
    }
}

impl Body {
    /// Points of a cylinder's rim.
    pub const SIDES: usize = 16;
    /// Points of the rim of a [`peg`](Self::peg)'s end.
    pub const RIM: usize = 32;

    /// A body of this mass \[kg\] and tensor of inertia about its centre of mass, in the axes of B [kg m²]. It goes
    /// through a table until it is given [points](Self::with_points) that touch, and through fingers.
    #[must_use]
    pub fn new(mass: f64, inertia: Matrix3<f64>) -> Self {
        Self { mass, inertia, points: Vec::new(), faces: Vec::new(), barrel: None, X_WB: Pose::identity() }
    }

    /// A homogeneous block of this mass \[kg\] and these edges along x, y, z of B \[m\], which touches with its corners.
    #[must_use]
    pub fn block(mass: f64, edges: [f64; 3]) -> Self {
        let [x, y, z] = edges.map(|edge| edge * edge * mass / 12.0);
        let corner = |i: usize| {
            let side = |bit: usize| if i & bit == 0 { -0.5 } else { 0.5 };
            Vector3::new(side(1) * edges[0], side(2) * edges[1], side(4) * edges[2])
        };
        let inertia = Matrix3::from_diagonal(&Vector3::new(y + z, x + z, x + y));
        let face = |i: usize| {
            let mut normal = Vector3::zeros();
            normal[i / 2] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            Face { normal, offset: 0.5 * edges[i / 2] }
        };
        let block = Self::new(mass, inertia).with_points((0..8).map(corner));
        Self { faces: (0..6).map(face).collect(), ..block }
    }

    /// A homogeneous upright cylinder of this mass \[kg\], diameter and height along z of B \[m\]. It touches with
    /// [`SIDES`](Self::SIDES) points of each rim, and has as many flat sides.
    #[must_use]
    pub fn disc(mass: f64, diameter: f64, height: f64) -> Self {
        let (r, h) = (0.5 * diameter, 0.5 * height);
        let across = mass * (3.0 * r * r + height * height) / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(across, across, 0.5 * mass * r * r));
        let angle = |i: usize| i as f64 * core::f64::consts::TAU / Self::SIDES as f64;
        let rim = |i: usize| {
            let up = if i < Self::SIDES { -h } else { h };
            Vector3::new(r * angle(i).cos(), r * angle(i).sin(), up)
        };
        let side = |i: usize| {
            // Half-way between two points of the rim.
            let half = 0.5 * angle(1);
            let middle = angle(i) + half;
            Face { normal: Vector3::new(middle.cos(), middle.sin(), 0.0), offset: r * half.cos() }
        };
        let end = |sign: f64| Face { normal: Vector3::z() * sign, offset: h };
        let faces = (0..Self::SIDES).map(side).chain([end(1.0), end(-1.0)]).collect();
        Self { faces, ..Self::new(mass, inertia).with_points((0..2 * Self::SIDES).map(rim)) }
    }

    /// A peg for a hole in a [`Plate`](super::Plate): the cylinder of [`disc`](Self::disc), whose side is round for the edge of a
    /// hole. It touches with [`RIM`](Self::RIM) points of the rim of its end at -z of B.
    #[must_use]
    pub fn peg(mass: f64, diameter: f64, length: f64) -> Self {
        let (radius, half) = (0.5 * diameter, 0.5 * length);
        let rim = |i: usize| {
            let angle = i as f64 * core::f64::consts::TAU / Self::RIM as f64;
            Vector3::new(radius * angle.cos(), radius * angle.sin(), -half)
        };
        let disc = Self::disc(mass, diameter, length).with_points((0..Self::RIM).map(rim));
        Self { barrel: Some(Barrel { radius, half }), ..disc }
    }

    /// A body of this mass \[kg\] and tensor of inertia about its centre of mass, in the axes of B [kg m²], whose hull is an upright
    /// prism: a convex outline, anticlockwise about z of B, from one height to the other \[m, in B\]. It touches with the outline's points
    /// at both ends.
    #[must_use]
    pub fn prism(mass: f64, inertia: Matrix3<f64>, outline: &[[f64; 2]], [from, to]: [f64; 2]) -> Self {
        let sides = outline.iter().zip(outline.iter().cycle().skip(1)).filter(|(a, b)| a != b);
        let side = |(a, b): (&[f64; 2], &[f64; 2])| {
            let normal = Vector3::new(b[1] - a[1], a[0] - b[0], 0.0).normalize();
            Face { normal, offset: normal.x * a[0] + normal.y * a[1] }
        };
        let ends = [Face { normal: Vector3::z(), offset: to }, Face { normal: -Vector3::z(), offset: -from }];
        let faces = sides.map(side).chain(ends).collect();
        let points =
            [from, to].into_iter().flat_map(|z| outline.iter().map(move |[x, y]| Vector3::new(*x, *y, z)));
        Self { faces, ..Self::new(mass, inertia).with_points(points) }
    }

    /// The hull's points \[m, in B\].
    #[must_use]
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// The same body with these points of its hull \[m, in B\], by which it touches a table.
    #[must_use]
    pub fn with_points(self, points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        Self { points: points.into_iter().collect(), ..self }
    }

    /// The same body at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(self, X_WB: Pose) -> Self {
        Self { X_WB, ..self }
    }
}

/// Where a body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct BodyState {
    /// `X_WB`, its pose in the world.
    pub pose: Pose,
    /// Velocity of its centre of mass [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity, in the world's axes [rad/s].
    pub angular_velocity: Vector3<f64>,
}

/// A body in motion.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    pub mass: f64,
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// Smallest principal moment of inertia [kg m²].
    least: f64,
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    momentum: Vector3<f64>,
    angular_momentum: Vector3<f64>,
}

impl Moving {
    /// The body at rest.
    pub fn at_rest(body: &Body) -> Result<Self, WorldError> {
        let mass = positive("the body's mass", body.mass, "kg")?;
        let finite = body.X_WB.to_homogeneous().iter().all(|x| x.is_finite())
            && body.points.iter().flatten().all(|x| x.is_finite());
        if !finite {
            return Err(WorldError::NotFinite("the body's pose or a point of its hull"));
        }
        let inertia = body.inertia;
        let asymmetry = (inertia - inertia.transpose()).amax();
        let is_tensor = inertia.iter().all(|x| x.is_finite()) && asymmetry <= 1e-9 * inertia.amax();
        if !is_tensor {
            return Err(WorldError::Inertia([f64::NAN; 3]));
        }
        let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        let [a, b, c] = moments;
        if a <= 0.0 || c > (a + b) * (1.0 + 1e-9) {
            return Err(WorldError::Inertia(moments));
        }
        let inverse = inertia.try_inverse().ok_or(WorldError::Inertia(moments))?;
        Ok(Self {
            mass,
            inertia,
            inverse,
            least: a,
            position: body.X_WB.translation.vector,
            rotation: body.X_WB.rotation,
            momentum: Vector3::zeros(),
            angular_momentum: Vector3::zeros(),
        })
    }

    pub fn state(&self) -> BodyState {
        BodyState {
            pose: Pose::from_parts(self.position.into(), self.rotation),
            velocity: self.velocity(),
            angular_velocity: self.angular_velocity(),
        }
    }

    /// Puts the body in motion, where it is.
    pub fn set_velocity(&mut self, linear: Vector3<f64>, angular: Vector3<f64>) {
        self.momentum = self.mass * linear;
        self.angular_momentum =
            self.rotation * (self.inertia * self.rotation.inverse_transform_vector(&angular));
    }

    #[inline]
    pub fn velocity(&self) -> Vector3<f64> {
        self.momentum / self.mass
    }

    #[inline]
    pub fn angular_velocity(&self) -> Vector3<f64> {
        self.turning_at(&self.rotation)
    }

    /// The angular velocity that belongs to the angular momentum at an attitude.
    #[inline]
    fn turning_at(&self, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        rotation * (self.inverse * rotation.inverse_transform_vector(&self.angular_momentum))
    }

    /// Kinetic energy \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * self.momentum.norm_squared() / self.mass
            + 0.5 * self.angular_momentum.dot(&self.angular_velocity())
    }

    /// Moves on for `h` \[s\] with constant momenta.
    #[inline]
    pub fn drift(&mut self, h: f64) {
        self.position += self.momentum * (h / self.mass);
        let before = self.angular_velocity();
        let half = turn::by(&(before * (0.5 * h))) * self.rotation;
        self.rotation = turn::by(&(self.turning_at(&half) * h)) * self.rotation;
        // Products of rotations lose their unit length by round-off: one Newton step restores it.
        self.rotation.renormalize_fast();
    }

    /// Takes a wrench about the centre of mass, in the world's axes, for `h` \[s\].
    #[inline]
    pub fn kick(&mut self, wrench: &Wrench, h: f64) {
        self.momentum += wrench.force * h;
        self.angular_momentum += wrench.torque * h;
    }

    /// How a point of the body \[m, in B\] yields: the largest speed that a unit impulse at it gives to it, 1/kg. It is
    /// the largest eigenvalue of `1/m - [r] I^-1 [r]`.
    pub fn yielding(&self, r: &Vector3<f64>) -> f64 {
        let cross = r.cross_matrix();
        let tensor = Matrix3::identity() / self.mass - cross * self.inverse * cross;
        tensor.symmetric_eigenvalues().max()
    }

    /// How the body yields to a twist: the largest angular speed that a unit impulse of torque gives it [1/(kg m²)].
    pub fn turning(&self) -> f64 {
        self.least.recip()
    }
}
