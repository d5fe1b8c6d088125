//! A free trunk with four legs whose joints move as they are told: its six degrees of freedom.
//!
//! The whole machine has the momentum p and the angular momentum l about the world's origin. Forces of the ground and weight change them,
//! nothing else does. How the trunk moves follows from them and from how the legs move in it: with sums over all bodies, in the axes of
//! T and relative to it,
//!
//! ```text
//! S = sum m r,   J = sum I + m (|r|^2 - r r^T),   U = sum m u,   K = sum r x m u + I w       r, u, w: place, velocity, turning of a link
//!
//! R^T p            = M v + omega x S + U
//! R^T (l - x x p)  = S x v + J omega + K          v, omega: of the trunk, along its axes; x: its origin
//! ```
//!
//! So swinging legs push the trunk as they truly do, and no energy of the legs is left out. Momenta are kicked at constant place, places
//! drift with constant momenta (leapfrog), by the midpoint rule.

use mrroc::pose::Pose;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::leg::{Leg, Three};

/// Mass of the trunk \[kg\], its centre in the origin of T.
pub const MASS: f64 = 20.0;
/// Edges of the trunk, a homogeneous block along the axes of T \[m\].
pub const EDGES: [f64; 3] = [0.7, 0.25, 0.12];

/// Sums over all bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Sums {
    /// \[kg\].
    pub M: f64,
    /// [kg m].
    pub S: Vector3<f64>,
    /// [kg m²].
    pub J: Matrix3<f64>,
    /// [kg m/s].
    pub U: Vector3<f64>,
    /// [kg m²/s].
    pub K: Vector3<f64>,
}

/// The trunk's own tensor of inertia, along T [kg m²].
#[must_use]
pub fn inertia() -> Matrix3<f64> {
    let [x, y, z] = EDGES.map(|edge| edge * edge * MASS / 12.0);
    Matrix3::from_diagonal(&Vector3::new(y + z, x + z, x + y))
}

impl Sums {
    /// Of a trunk with these legs.
    #[must_use]
    pub fn of(legs: &[Leg; 4], q: &[Three; 4], qd: &[Three; 4]) -> Self {
        let (mut mass, mut first, mut second) = (MASS, Vector3::zeros(), inertia());
        let (mut flow, mut swirl) = (Vector3::zeros(), Vector3::zeros());
        for i in 0..4 {
            for link in legs[i].links(&q[i], &qd[i]) {
                let r = link.at;
                mass += link.mass;
                first += r * link.mass;
                second +=
                    link.inertia + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * link.mass;
                flow += link.velocity * link.mass;
                swirl += r.cross(&link.velocity) * link.mass + link.inertia * link.turning;
            }
        }
        Self { M: mass, S: first, J: second, U: flow, K: swirl }
    }

    /// Velocity and turning of the trunk, along its axes, with these momenta along its axes and about its origin.
    #[must_use]
    pub fn twist(&self, momentum: &Vector3<f64>, angular: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let s = &self.S;
        let about_centre = self.J - (Matrix3::identity() * s.norm_squared() - s * s.transpose()) / self.M;
        let free = momentum - self.U;
        let spin = angular - self.K - s.cross(&free) / self.M;
        // It is the inertia about the centre of mass: positive definite, as the trunk is a solid.
        let omega = about_centre.cholesky().map_or_else(Vector3::zeros, |matrix| matrix.solve(&spin));
        ((free - omega.cross(s)) / self.M, omega)
    }

    /// Centre of mass of the machine [m, T].
    #[must_use]
    pub fn centre(&self) -> Vector3<f64> {
        self.S / self.M
    }
}

/// Where the trunk is, and the momenta of the machine.
#[derive(Clone, Debug)]
pub struct Trunk {
    /// Its origin \[m, W\].
    pub position: Vector3<f64>,
    /// Its attitude.
    pub rotation: UnitQuaternion<f64>,
    momentum: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Trunk {
    /// At rest.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(X_WT: Pose) -> Self {
        Self {
            position: X_WT.translation.vector,
            rotation: X_WT.rotation,
            momentum: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// `X_WT`.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position.into(), self.rotation)
    }

    /// Velocity of its origin and its turning, along the world's axes [m/s, rad/s].
    #[must_use]
    pub fn twist(&self, sums: &Sums) -> (Vector3<f64>, Vector3<f64>) {
        self.twist_at(sums, &self.position, &self.rotation)
    }

    fn twist_at(
        &self,
        sums: &Sums,
        position: &Vector3<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let back = rotation.inverse();
        let about = self.angular - position.cross(&self.momentum);
        let (v, omega) = sums.twist(&(back * self.momentum), &(back * about));
        (rotation * v, rotation * omega)
    }

    /// Takes a force at a place [N, m, W] for `h` \[s\].
    pub fn kick(&mut self, force: &Vector3<f64>, at: &Vector3<f64>, h: f64) {
        self.momentum += force * h;
        self.angular += at.cross(force) * h;
    }

    /// Moves on for `h` \[s\] with constant momenta; `sums` are those of the step's middle.
    pub fn drift(&mut self, sums: &Sums, h: f64) {
        let (v, omega) = self.twist(sums);
        let position = self.position + v * (0.5 * h);
        let rotation = UnitQuaternion::from_scaled_axis(omega * (0.5 * h)) * self.rotation;
        let (v, omega) = self.twist_at(sums, &position, &rotation);
        self.position += v * h;
        self.rotation = UnitQuaternion::from_scaled_axis(omega * h) * self.rotation;
        self.rotation.renormalize_fast();
    }

    /// Momentum, and angular momentum about the world's origin [kg m/s, kg m²/s].
    #[must_use]
    pub const fn momenta(&self) -> (Vector3<f64>, Vector3<f64>) {
        (self.momentum, self.angular)
    }

    /// Gives the machine the momenta of these velocities of the trunk [m/s, rad/s, W].
    pub fn set_twist(&mut self, sums: &Sums, velocity: &Vector3<f64>, omega: &Vector3<f64>) {
        let back = self.rotation.inverse();
        let (v, omega) = (back * velocity, back * omega);
        self.momentum = self.rotation * (v * sums.M + omega.cross(&sums.S) + sums.U);
        let about = self.rotation * (sums.S.cross(&v) + sums.J * omega + sums.K);
        self.angular = about + self.position.cross(&self.momentum);
    }
}
