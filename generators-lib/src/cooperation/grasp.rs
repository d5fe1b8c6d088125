//! Rigid grasps: where the arms hold a body, and where they must be when it is elsewhere.
//!
//! ```text
//! X_BE_i = X_WB^-1 X_WE_i      at the start, the one place that needs the arms' states
//! X_WE_i = X_WB X_BE_i         in every step
//! ```
//!
//! so that `X_WE_i^-1 X_WE_j = X_BE_i^-1 X_BE_j` is the same in every step, up to rounding.

use mrroc::pose::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Where the body's frame B lies when the grasps are closed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BodyFrame {
    /// At `X_WB` in the world.
    InWorld(Pose),
    /// At `X_EB` in the tool of the list's first arm.
    InFirstTool(Pose),
    /// Midway between the origins of all tools, along the world's axes.
    Centroid,
}

impl BodyFrame {
    /// `X_WB` for tools at `X_WE`; a list without arms has its centroid at the world's origin.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn pose(&self, X_WE: &[Pose]) -> Pose {
        match *self {
            BodyFrame::InWorld(X_WB) => X_WB,
            BodyFrame::InFirstTool(X_EB) => X_WE.first().map_or(X_EB, |first| first * X_EB),
            BodyFrame::Centroid => {
                let sum: Vector3<f64> = X_WE.iter().map(|pose| pose.translation.vector).sum();
                let middle = sum / X_WE.len().max(1) as f64;
                Pose::from_parts(Translation3::from(middle), UnitQuaternion::identity())
            }
        }
    }
}

/// The grasps `X_BE_i` of the arms on one body, in the order of the list of robots. `E` is an array of poses:
/// `[Pose; 2]`, or `L::Each<Pose>` of any list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Grasps<E> {
    X_BE: E,
}

impl<E: AsRef<[Pose]> + AsMut<[Pose]> + Copy> Grasps<E> {
    /// The grasps of a body at `X_WB` by tools at `X_WE`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn close(X_WB: &Pose, X_WE: E) -> Self {
        let mut X_BE = X_WE;
        for pose in X_BE.as_mut() {
            *pose = X_WB.inv_mul(pose);
        }
        Grasps { X_BE }
    }

    /// `X_WE` of arm `i` when the body is at `X_WB`.
    ///
    /// # Panics
    /// When there is no arm `i`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn tool(&self, i: usize, X_WB: &Pose) -> Pose {
        X_WB * self.X_BE.as_ref()[i]
    }

    /// `X_BE` of every arm.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        self.X_BE.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tools() -> [Pose; 3] {
        [
            Pose::new(Vector3::new(0.8, -0.3, 0.5), Vector3::new(3.0, 0.1, -0.2)),
            Pose::new(Vector3::new(0.9, 0.4, 0.6), Vector3::new(0.0, 2.0, 1.0)),
            Pose::new(Vector3::new(-0.2, 0.1, 0.4), Vector3::new(0.5, -0.4, 0.3)),
        ]
    }

    #[test]
    fn relative_poses_of_the_tools_do_not_depend_on_where_the_body_is() {
        let tools = tools();
        let grasps = Grasps::close(&BodyFrame::Centroid.pose(&tools), tools);
        let moved = Pose::new(Vector3::new(3.0, -2.0, 1.0), Vector3::new(-1.0, 0.7, 2.0));
        let relative = tools[0].inverse() * tools[2];
        let after = grasps.tool(0, &moved).inverse() * grasps.tool(2, &moved);
        assert!((relative.translation.vector - after.translation.vector).norm() < 1e-15 * 10.0);
        assert!((relative.inverse() * after).rotation.angle() < 1e-9);
    }

    #[test]
    fn the_bodys_frame_is_where_it_is_said_to_be() {
        let tools = tools();
        assert_eq!(BodyFrame::InWorld(tools[1]).pose(&tools), tools[1]);
        assert_eq!(BodyFrame::InFirstTool(Pose::identity()).pose(&tools), tools[0]);
        let middle = BodyFrame::Centroid.pose(&tools);
        assert!((middle.translation.vector - Vector3::new(0.5, 0.2 / 3.0, 0.5)).norm() < 1e-15);
        assert_eq!(middle.rotation, UnitQuaternion::identity());
    }
}
