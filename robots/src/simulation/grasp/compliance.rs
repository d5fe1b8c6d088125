//! A compliant grasp: one spring and one damper, in six directions, between a gripper's tool frame E and the grasp
//! frame G on the body.
//!
//! ```text
//! d = p_EG,   theta = angle-axis of R_WG R_WE^T          both along the world's axes; the spring is at rest where G is E
//! f   = -k d - c (velocity of G less that of E's extension at G)          on the body at G, the opposite on the gripper
//! tau = -kappa theta - gamma (omega_B - omega_E)
//! energy = k d^2 / 2 + kappa theta^2 / 2
//! ```
//!
//! While a gripper closes, all four constants grow evenly from 0.
//!
//! The gradient of `theta^2 / 2` over turns is theta itself, so the spring conserves energy at any angle below pi.

use mrroc::pose::{Pose, Wrench};
use nalgebra::{UnitQuaternion, Vector3};

use super::error::{WorldError, not_negative, positive};
use super::turn;

/// How a gripper holds the body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Grasp {
    pub(super) stiffness: f64,
    pub(super) rotational_stiffness: f64,
    pub(super) damping: f64,
    pub(super) rotational_damping: f64,
    pub(super) closing: f64,
    pub(super) X_FE: Pose,
    pub(super) X_BG: Option<Pose>,
}

impl Grasp {
    /// Damping for its stiffness, unless stated \[s\]: lightly damped for bodies of some kilograms.
    const DAMPING: f64 = 2e-3;
    /// How far a stated grasp frame may be from the tool frame when the gripper closes \[m\] ..
    pub const REACH: f64 = 0.02;
    /// .. and by how much it may be turned \[rad\].
    pub const TURN: f64 = 0.2;

    /// A grasp of this stiffness against displacement [N/m] and turning [N m/rad], both > 0, damped by 2 ms of them. The
    /// body is held where it is when the gripper closes.
    #[must_use]
    pub fn new(stiffness: f64, rotational: f64) -> Self {
        Self {
            stiffness,
            rotational_stiffness: rotational,
            damping: Self::DAMPING * stiffness,
            rotational_damping: Self::DAMPING * rotational,
            closing: 0.0,
            X_FE: Pose::identity(),
            X_BG: None,
        }
    }

    /// The same grasp with this damping of displacement [N s/m] and of turning [N m s/rad], both >= 0.
    #[must_use]
    pub fn with_damping(self, damping: f64, rotational: f64) -> Self {
        Self { damping, rotational_damping: rotational, ..self }
    }

    /// The same grasp, tightened evenly over this time when it closes \[s\], >= 0 (0 unless stated). Meanwhile something else
    /// must carry the body.
    #[must_use]
    pub fn closing_over(self, duration: f64) -> Self {
        Self { closing: duration, ..self }
    }

    /// The same grasp with the tool frame E at `X_FE` in the flange's frame F (E is F unless stated).
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_tool(self, X_FE: Pose) -> Self {
        Self { X_FE, ..self }
    }

    /// The same grasp at the frame `X_BG` of the body, to which closing pulls the gripper and the body together. It
    /// closes only where E is within [`REACH`](Self::REACH) and [`TURN`](Self::TURN) of G.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(self, X_BG: Pose) -> Self {
        Self { X_BG: Some(X_BG), ..self }
    }

    pub(super) fn check(&self) -> Result<(), WorldError> {
        positive("the grasp's stiffness", self.stiffness, "N/m")?;
        positive("the grasp's rotational stiffness", self.rotational_stiffness, "N m/rad")?;
        not_negative("the grasp's damping", self.damping, "N s/m")?;
        not_negative("the grasp's rotational damping", self.rotational_damping, "N m s/rad")?;
        not_negative("the time in which the grasp closes", self.closing, "s")?;
        if !self.X_FE.to_homogeneous().iter().all(|x| x.is_finite()) {
            return Err(WorldError::NotFinite("the tool frame"));
        }
        Ok(())
    }

    /// Energy stored at a deflection \[J\].
    pub(super) fn energy(&self, deflection: &Deflection) -> f64 {
        0.5 * self.stiffness * deflection.displacement.norm_squared()
            + 0.5 * self.rotational_stiffness * deflection.turn.norm_squared()
    }

    /// The wrench of the grasp on the body: at G, in the world's axes.
    pub(super) fn wrench(&self, deflection: &Deflection, rate: &Deflection) -> Wrench {
        Wrench::new(
            -self.stiffness * deflection.displacement - self.damping * rate.displacement,
            -self.rotational_stiffness * deflection.turn - self.rotational_damping * rate.turn,
        )
    }
}

/// The deflection of a grasp, or its rate: from E to G, in the world's axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deflection {
    /// \[m\] or [m/s].
    pub displacement: Vector3<f64>,
    /// \[rad\] or [rad/s].
    pub turn: Vector3<f64>,
}

impl Deflection {
    /// Of the frame G from the frame E: their origins \[m\] and rotations in the world.
    #[allow(non_snake_case)]
    pub fn between(
        p_E: &Vector3<f64>,
        R_E: &UnitQuaternion<f64>,
        p_G: &Vector3<f64>,
        R_G: &UnitQuaternion<f64>,
    ) -> Self {
        Self { displacement: p_G - p_E, turn: turn::of(&(R_G * R_E.inverse())) }
    }
}
