//! The fingers of a gripper as they touch bodies: two flat pads that face each other along x of E.
//!
//! ```text
//!  finger -1   o/2    E    o/2   finger +1          o: opening;  x_E to the right, z_E ahead, out of the page
//!        |      <-----+----->      |
//!        P      [   body   ]       P                three points P on each pad, at y = -b, 0 and b, z = 0
//!
//!  t: how deep P is in the body, along the pad's normal towards the finger
//!  n = max(0, k t + c dt/dt)                        on the body, away from the finger: no friction before it is gripped
//! ```
//!
//! So a body that lies off the middle is pushed there by the finger that comes first, and one that lies askew is turned, both
//! against the friction of what it lies on. Both pads have it when each presses by [`Pads::PRESS`]; from then on the grasp's springs
//! hold it as it is.

use mrroc::pose::{Pose, Wrench};
use nalgebra::Vector3;

use super::body::{Face, Moving};
use super::compliance::Deflection;
use super::contact::at_lever;
use super::error::{WorldError, not_negative, positive};
use super::motion::Motion;

/// The pads of two fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pads {
    half_width: f64,
    ahead: f64,
    stiffness: f64,
    damping: f64,
}

impl Pads {
    /// Both pads have the body when each presses on it by this \[N\].
    pub const PRESS: f64 = 5.0;
    /// A point of a finger that is deeper in a body than this has come down on it \[m\].
    pub const DEEPEST: f64 = 0.005;

    /// Pads this wide along y of E \[m\], > 0, which reach this far ahead of E along z \[m\], >= 0: of 1e4 N/m and 20 N s/m at each of
    /// three points (assumed).
    #[must_use]
    pub fn new(width: f64, ahead: f64) -> Self {
        Self { half_width: 0.5 * width, ahead, stiffness: 1e4, damping: 20.0 }
    }

    pub(super) fn check(&self) -> Result<(), WorldError> {
        positive("the pads' width", self.half_width, "m")?;
        not_negative("how far the pads reach ahead", self.ahead, "m")?;
        Ok(())
    }
}

/// A body between the fingers, at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Touch {
    /// Which body.
    pub body: usize,
    /// On the world's clock \[s\].
    pub time: f64,
    /// Where it is between the fingers, `X_EB`.
    pub X_EB: Pose,
    /// Its velocity less that of E, along the axes of E [m/s].
    pub velocity: Vector3<f64>,
}

/// The fingers of a hand, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jaw {
    pads: Pads,
    /// \[m\], and its rate [m/s].
    opening: f64,
    rate: f64,
    /// For how long it holds \[s\].
    left: f64,
    closing: bool,
    /// The body that they may touch in this interval.
    near: Option<usize>,
    /// Force of each pad \[N\].
    force: [f64; 2],
    /// The first touch since a body is near, and when both had it.
    pub touch: Option<Touch>,
    pub grip: Option<Touch>,
    /// How often a finger came down on a body.
    pub crashes: u32,
    crashed: bool,
}

impl Jaw {
    pub fn new(pads: Pads, opening: f64) -> Self {
        Self {
            pads,
            opening,
            rate: 0.0,
            left: 0.0,
            closing: true,
            near: None,
            force: [0.0; 2],
            touch: None,
            grip: None,
            crashes: 0,
            crashed: false,
        }
    }

    /// Sets opening \[m\] and rate [m/s], which holds for `duration` \[s\].
    pub fn set_opening(&mut self, opening: f64, rate: f64, duration: f64) {
        (self.opening, self.rate, self.left) = (opening, rate, duration);
    }

    /// Sets whether the drive presses the fingers together, or lets go.
    pub const fn set_closing(&mut self, closing: bool) {
        self.closing = closing;
    }

    /// Moves the fingers on for `h` \[s\].
    pub fn drift(&mut self, h: f64) {
        self.opening += self.rate * h.min(self.left);
        self.left = (self.left - h).max(0.0);
        if self.left == 0.0 {
            self.rate = 0.0;
        }
    }

    /// \[m\].
    pub const fn opening(&self) -> f64 {
        self.opening
    }

    pub const fn near(&self) -> Option<usize> {
        self.near
    }

    /// Whether the fingers of E may touch a body within a short time: its farthest point is `radius` \[m\] from its centre.
    #[allow(non_snake_case)]
    pub fn may_touch(&self, E: &Motion, body: &Moving, points: &[Vector3<f64>], radius: f64) -> bool {
        const MARGIN: f64 = 0.004;
        let offset = body.position - E.position;
        if offset.norm() > radius + 0.5 * self.opening + self.pads.half_width + MARGIN {
            return false;
        }
        // The body's extent in E: between the pads with room to spare, or beside them, or behind their tips?
        let R_EB = E.rotation.inverse() * body.rotation;
        let centre = E.rotation.inverse_transform_vector(&offset);
        let (mut least, mut most) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for point in points {
            let at = centre + R_EB * point;
            least = least.inf(&at);
            most = most.sup(&at);
        }
        let reaches = least.z < self.pads.ahead + MARGIN && most.z > -MARGIN;
        let beside = least.y < self.pads.half_width + MARGIN && most.y > -self.pads.half_width - MARGIN;
        let pad = 0.5 * self.opening - MARGIN;
        reaches && beside && (most.x > pad || least.x < -pad)
    }

    /// Sets the body that they may touch.
    pub fn set_near(&mut self, near: Option<usize>) {
        if near.is_some() && self.near != near {
            self.touch = None;
            self.crashed = false;
        }
        self.near = near;
        self.force = [0.0; 2];
    }

    /// Whether each pad presses enough, and is not about to let go.
    pub fn has_it(&self) -> bool {
        self.closing && self.force.iter().all(|force| *force >= Pads::PRESS)
    }

    /// Whether a pad presses.
    pub fn touches(&self) -> bool {
        self.force.iter().any(|force| *force > 0.0)
    }

    /// The wrench of the pads of E on the body, about its centre of mass along the world's axes.
    #[allow(non_snake_case)]
    pub fn press(&mut self, E: &Motion, body: &Moving, faces: &[Face], rate: &Deflection) -> Wrench {
        let mut sum = Wrench::default();
        let along = E.rotation * Vector3::x();
        for (side, force) in [-1.0, 1.0].into_iter().zip(&mut self.force) {
            *force = 0.0;
            // Away from the body, into the finger.
            let outwards = along * side;
            for y in [-self.pads.half_width, 0.0, self.pads.half_width] {
                let lever_E = E.rotation * Vector3::new(0.5 * side * self.opening, y, 0.0);
                let lever = E.position + lever_E - body.position;
                let Some(depth) = depth(&lever, &outwards, body, faces) else { continue };
                if depth > Pads::DEEPEST {
                    continue;
                }
                let point = rate.displacement + rate.turn.cross(&lever);
                let pad = E.velocity + E.turning.cross(&lever_E) + outwards * (0.5 * self.rate);
                let closing = (point - pad).dot(&outwards);
                let normal = (self.pads.stiffness * depth + self.pads.damping * closing).max(0.0);
                *force += normal;
                sum = sum + at_lever(-outwards * normal, &lever);
            }
        }
        let crashes = self.comes_down_on(E, body, faces);
        self.crashes += u32::from(crashes && !self.crashed);
        self.crashed = crashes;
        sum
    }

    /// Whether the tip of a finger, in its middle or behind the pad, is in the body.
    #[allow(non_snake_case)]
    fn comes_down_on(&self, E: &Motion, body: &Moving, faces: &[Face]) -> bool {
        [-1.0, 1.0].into_iter().any(|side| {
            [Pads::DEEPEST, 2.0 * Pads::DEEPEST].into_iter().any(|behind| {
                let at = Vector3::new(side * (0.5 * self.opening + behind), 0.0, self.pads.ahead);
                let lever = E.position + E.rotation * at - body.position;
                depth(&lever, &Vector3::z(), body, faces).is_some()
            })
        })
    }
}

/// How far a point at `lever` \[m\] from the body's centre is from the body's surface along `outwards`; `None` outside.
#[inline]
fn depth(lever: &Vector3<f64>, outwards: &Vector3<f64>, body: &Moving, faces: &[Face]) -> Option<f64> {
    let at = body.rotation.inverse_transform_vector(lever);
    let direction = body.rotation.inverse_transform_vector(outwards);
    let mut depth = f64::INFINITY;
    for face in faces {
        let room = face.offset - face.normal.dot(&at);
        if room <= 0.0 {
            return None;
        }
        let rate = face.normal.dot(&direction);
        if rate > 1e-9 {
            depth = depth.min(room / rate);
        }
    }
    depth.is_finite().then_some(depth)
}

impl Pads {
    /// How stiff [N/m] and how damped [N s/m] the contact is at most.
    pub(super) fn compliance(&self) -> (f64, f64) {
        (6.0 * self.stiffness, 6.0 * self.damping)
    }
}

impl Jaw {
    /// Bounds of the squared frequency [1/s²] and of the rate of decay [1/s] that the pads add to the motion of a body which yields
    /// so much [1/kg].
    pub fn bounds(&self, yielding: f64) -> (f64, f64) {
        let (stiffness, damping) = self.pads.compliance();
        (stiffness * yielding, damping * yielding)
    }
}
