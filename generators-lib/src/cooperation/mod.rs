//! Several arms on one body: rigid grasps, body paths, kinematic loops, internal forces.
//!
//! Frames: W world, B body, E_i the tool of arm `i`, E_i,s the tool as demanded at the start of the instruction, D a
//! drive frame. What flows, per step of the coordinator:
//!
//! ```text
//! dt -> BodyPath -> X_WB -> Grasps: X_WE_i = X_WB X_BE_i -> Placed: a pose, or X_EsE = X_WEs^-1 X_WE as an order
//!       wrenches at E_i -> InternalForce -> SqueezeLaw: X_EE' -> X_WE_i X_EE'
//! ```
//!
//! - [`Grasps`], [`BodyFrame`]: what a rigid body makes of many arms;
//! - [`BodyPath`]: how the body moves, along any Cartesian path of this library or any function of path time;
//! - [`Displacement`]: the numeric order of tight cooperation, which an ECP only transmits;
//! - [`KinematicLoop`], [`Transform`]: loops that share a drive frame, as in KALI;
//! - [`Smoothed`]: a measured pose as a reference, for a slave;
//! - [`TrackedFrame`]: a frame that moves by itself, by readings that are late;
//! - [`InternalForce`], [`SqueezeLaw`]: what the arms do to the body besides moving it, and how to reduce it;
//! - [`dry_run`], [`Arm`]: whether every arm can follow, asked before anything moves; [`FreeDirection`] for arms with
//!   fewer joints than a pose has coordinates.
//!
//! Sources: Zieliński's MRROC++ paper, section 8; Uchiyama and Dauchez (ICRA 1988); Hayati and Hayward (KALI, ACC 1988);
//! the rest where it is used.

mod attainable;
mod body_path;
mod displacement;
mod drive;
mod grasp;
mod internal_force;
mod smoothed;
mod squeeze;
mod tracked;

pub use attainable::{Arm, ArmModel, Cause, Direction, DryRunError, FreeDirection, Unattainable, dry_run};
pub use body_path::{BodyPath, SplineBody, StraightBody, TimedBody};
pub use displacement::{Displacement, Placed};
pub use drive::{Functional, KinematicLoop, Transform};
pub use grasp::{BodyFrame, Grasps};
pub use internal_force::{GraspStiffness, InternalForce, Sharing, central_squeeze};
pub use smoothed::Smoothed;
pub use squeeze::{BadSqueeze, Correction, SqueezeBounds, SqueezeGains, SqueezeLaw};
pub use tracked::{TrackedFrame, Tracking};
