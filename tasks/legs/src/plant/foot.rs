//! A foot on the ground: a pad on a free ball joint, which touches as a ball does, with Coulomb friction.
//!
//! ```text
//! delta > 0: how deep, n: out of the ground, v: velocity of the foot's middle
//!
//! N = max(0, k delta - c v.n)                          never pulls
//! s = how far the foot has crept from where it stuck,  at most mu N / k_t long; what is cut off it has slid
//! F = N n - k_t s - beta c_t v_t,   |tangential| <= mu N   beta in 0..1: damping yields to friction
//! ```

use nalgebra::Vector3;

use crate::ground::Contact;

/// Radius of the foot \[m\].
pub const RADIUS: f64 = 0.02;
/// Stiffness of a foot on the ground [N/m], hard rubber (assumed).
pub const STIFFNESS: f64 = 1e5;
/// Its damping [N s/m] (assumed).
pub const DAMPING: f64 = 500.0;
/// Stiffness and damping along the ground are a third of these: rubber's shear modulus is a third of its elastic one.
pub const SHEAR: f64 = 1.0 / 3.0;

/// One foot.
#[derive(Clone, Debug, Default)]
pub struct Foot {
    /// How far it has crept from where it stuck \[m, W\].
    stretch: Vector3<f64>,
    /// The force of the ground on it \[N, W\].
    pub force: Vector3<f64>,
    /// How far it has slid in all \[m\].
    pub slid: f64,
}

impl Foot {
    /// Off the ground.
    pub fn lift(&mut self) {
        *self = Self { slid: self.slid, ..Self::default() };
    }

    /// The force of the ground on it \[N\], with this friction, at this velocity [m/s, W], after `h` \[s\] at it.
    pub fn press(
        &mut self,
        contact: &Contact,
        friction: f64,
        velocity: &Vector3<f64>,
        h: f64,
    ) -> Vector3<f64> {
        let Contact { depth, normal } = contact;
        let into = velocity.dot(normal);
        let load = (STIFFNESS * depth - DAMPING * into).max(0.0);
        let along = velocity - normal * into;
        let cone = friction * load;
        self.stretch += along * h;
        // The ground under it may lean otherwise than before.
        self.stretch -= normal * self.stretch.dot(normal);
        let length = self.stretch.norm();
        let most = cone / (SHEAR * STIFFNESS);
        if length > most {
            self.slid += length - most;
            self.stretch *= most / length;
        }
        let elastic = self.stretch * -(SHEAR * STIFFNESS);
        let viscous = along * -(SHEAR * DAMPING);
        let mut tangential = elastic + viscous;
        if tangential.norm() > cone {
            tangential = elastic + viscous * within(&elastic, &viscous, cone);
        }
        self.force = normal * load + tangential;
        self.force
    }
}

/// The largest share of `b`, 0 to 1, with which `a + share b` is at most `cone` long; `a` alone is.
fn within(a: &Vector3<f64>, b: &Vector3<f64>, cone: f64) -> f64 {
    let (bb, ab) = (b.norm_squared(), a.dot(b));
    let room = (cone * cone - a.norm_squared()).max(0.0);
    let root = (ab * ab + bb * room).sqrt();
    // The positive root of |a + share b|² = cone², without cancellation.
    let share = if ab > 0.0 { room / (root + ab) } else { (root - ab) / bb };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_the_ground(depth: f64) -> Contact {
        Contact { depth, normal: Vector3::z() }
    }

    #[test]
    fn it_sticks_within_the_cone_and_slides_beyond_it_by_what_the_spring_cannot_take() {
        let mut foot = Foot::default();
        let h = 1e-4;
        // 100 N down, friction 0.5: sticks up to 50 N, 1.5 mm of the spring; then it slides.
        for _ in 0..14 {
            foot.press(&on_the_ground(1e-3), 0.5, &(Vector3::x()), h);
        }
        assert!(foot.slid == 0.0 && (foot.stretch.x - 1.4e-3).abs() < 1e-15);
        for _ in 0..10 {
            foot.press(&on_the_ground(1e-3), 0.5, &(Vector3::x()), h);
        }
        assert!((foot.slid - 9e-4).abs() < 1e-15, "{}", foot.slid);
        let force = foot.force;
        assert!((force.x + 50.0).abs() < 1e-9 && (force.z - 100.0).abs() < 1e-9, "{force}");
    }

    #[test]
    fn it_never_pulls() {
        let mut foot = Foot::default();
        let force = foot.press(&on_the_ground(1e-5), 0.5, &(Vector3::z() * 1.0), 1e-4);
        assert_eq!(force, Vector3::zeros());
    }
}
