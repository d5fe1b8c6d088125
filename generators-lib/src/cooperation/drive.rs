//! Kinematic loops that share a drive frame, as in KALI.
//!
//! ```text
//! X_WR_i X_RE_i X_EG_i = X_WD(t) X_DG_i        one equation per loop, D common to all
//! X_WE_i = X_WR_i X_RE_i = X_WD(t) X_DG_i X_EG_i^-1
//! ```
//!
//! R_i is the arm's base, G_i the place on the drive frame where the loop closes. Each transform is constant or a function
//! of path time. Sources: Hayati and Hayward, *KALI: an environment for the programming and control of cooperative
//! manipulators* (ACC 1988); functional and held transforms after RCCL (Hayward and Paul 1986).

use mrroc::pose::Pose;

/// A transform of a loop, evaluated at an instant of path time.
pub trait Transform {
    /// The transform `age` \[s\] of path time after the loop was engaged.
    fn at(&mut self, age: f64) -> Pose;
}

/// A constant transform.
impl Transform for Pose {
    fn at(&mut self, _: f64) -> Pose {
        *self
    }
}

/// A functional transform: evaluated once per instant, however many loops ask.
#[derive(Clone, Copy, Debug)]
pub struct Functional<F> {
    function: F,
    last: Option<(f64, Pose)>,
}

impl<F: FnMut(f64) -> Pose> Functional<F> {
    /// `function` of the age \[s\].
    #[must_use]
    pub const fn new(function: F) -> Self {
        Functional { function, last: None }
    }
}

impl<F: FnMut(f64) -> Pose> Transform for Functional<F> {
    fn at(&mut self, age: f64) -> Pose {
        match self.last {
            Some((at, pose)) if at == age => pose,
            _ => {
                let pose = (self.function)(age);
                self.last = Some((age, pose));
                pose
            }
        }
    }
}

/// One arm's loop: where it closes on the drive frame, `X_DG`, and on the tool, `X_EG`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct KinematicLoop<D = Pose, E = Pose> {
    /// Where the loop closes in the drive frame D.
    pub X_DG: D,
    /// Where it closes in the tool frame E.
    pub X_EG: E,
}

#[allow(non_snake_case)]
impl KinematicLoop {
    /// The loop that a tool at `X_WE` closes as it stands, at its own origin, with the drive frame at `X_WD` (RCCL's
    /// transform that is held).
    #[must_use]
    pub fn held(X_WD: &Pose, X_WE: &Pose) -> Self {
        KinematicLoop { X_DG: X_WD.inv_mul(X_WE), X_EG: Pose::identity() }
    }
}

#[allow(non_snake_case)]
impl<D: Transform, E: Transform> KinematicLoop<D, E> {
    /// `X_WE`, where the arm's tool must be when the drive frame is at `X_WD`, at this age \[s\].
    pub fn tool(&mut self, X_WD: &Pose, age: f64) -> Pose {
        X_WD * self.X_DG.at(age) * self.X_EG.at(age).inverse()
    }

    /// `X_RE`, the same in the arm's base, which stands at `X_WR`: what a loop with a calibrated base solves for.
    pub fn tool_in_base(&mut self, X_WR: &Pose, X_WD: &Pose, age: f64) -> Pose {
        X_WR.inv_mul(&self.tool(X_WD, age))
    }
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn pose(x: f64) -> Pose {
        Pose::new(Vector3::new(x, 1.0 - x, 0.3 * x), Vector3::new(0.2, x, -0.7))
    }

    #[test]
    fn the_loop_closes() {
        let mut turning = KinematicLoop {
            X_DG: Functional::new(|age| Pose::rotation(Vector3::x() * age)),
            X_EG: pose(0.4),
        };
        let X_WR = pose(-1.0);
        let X_WD = pose(2.0);
        let X_RE = turning.tool_in_base(&X_WR, &X_WD, 0.8);
        let around = (X_WR * X_RE * pose(0.4)).inverse() * X_WD * Pose::rotation(Vector3::x() * 0.8);
        assert!(around.translation.vector.norm() < 1e-14 && around.rotation.angle() < 1e-7);
    }

    #[test]
    fn a_held_loop_starts_where_the_tool_is_and_moves_with_the_drive_frame() {
        let mut held = KinematicLoop::held(&pose(2.0), &pose(0.1));
        let error = held.tool(&pose(2.0), 0.0).inverse() * pose(0.1);
        assert!(error.translation.vector.norm() < 1e-14 && error.rotation.angle() < 1e-7);
        let by = Pose::translation(0.0, 0.0, 0.5);
        let error = held.tool(&(by * pose(2.0)), 1.0).inverse() * by * pose(0.1);
        assert!(error.translation.vector.norm() < 1e-14);
    }

    #[test]
    fn a_functional_transform_is_evaluated_once_per_instant() {
        let calls = core::cell::Cell::new(0);
        let mut transform = Functional::new(|_| {
            calls.set(calls.get() + 1);
            Pose::identity()
        });
        for age in [0.0, 0.0, 0.1, 0.1, 0.1] {
            transform.at(age);
        }
        assert_eq!(calls.get(), 2);
    }
}
