//! Generators, each in one file on the public API alone: to be used as they are, or copied and changed.
//!
//! | generator | what it does | class |
//! |---|---|---|
//! | [`RigidCarry`] | several arms carry a rigid body along a path | MP `f*0(c0)`, first step `f*2(c0, e)` |
//! | [`SqueezedCarry`] | the same, with a wanted internal force | MP `f*1(c0, v)`, first step `f*3(c0, e, v)` |
//! | [`FollowMaster`] | slaves follow a master as measured | MP `f*2(c0, e)` |
//! | [`SharedDrive`] | arms engage with a drive frame and move with it | MP `f*0(c0)`, first step `f*2(c0, e)` |
//! | [`TransmitDisplacement`] | passes the coordinator's displacements on | ECP `f*4(c0, c)` |
//! | [`YieldingTransmit`] | the same, where a grasp leaves a direction free | ECP `f*4(c0, c)`, first step `f*6(c0, c, e)` |
//! | [`JointMove`] | straight line in joint space | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`StraightLine`] | straight line of the tool frame | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`SmoothJointMove`] | all joints to their goals together, with limited jerk | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`SmoothLine`] | straight line of the tool frame, with limited jerk | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`ReachState`] | joints to a target that may change in every step | ECP `f*4(c0, c)`, first step `f*6(c0, c, e)` |
//! | [`JointSpline`] | a cubic spline through joint positions | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`CircularMove`] | an arc of a circle of the tool | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`CurveMove`] | any curve of the tool: helix, ellipse, blended polyline | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`SplineTrack`] | the moving-segment B-spline through a stream of points | ECP `f*0(c)` |
//! | [`GuardedApproach`] | straight on until a sensor says so | ECP `f*1(c, v)`, first step `f*3(c, e, v)` |

mod circular_move;
mod curve_move;
mod follow_master;
mod guarded_approach;
mod joint_move;
mod joint_spline;
mod reach_state;
mod rigid_carry;
mod shared_drive;
mod smooth_joint_move;
mod smooth_line;
mod spline_track;
mod squeezed_carry;
mod straight_line;
mod transmit_displacement;
mod yielding_transmit;

pub use circular_move::CircularMove;
pub use curve_move::CurveMove;
pub use follow_master::FollowMaster;
pub use guarded_approach::GuardedApproach;
pub use joint_move::JointMove;
pub use joint_spline::JointSpline;
pub use reach_state::{JointOrder, ReachState};
pub use rigid_carry::RigidCarry;
pub use shared_drive::SharedDrive;
pub use smooth_joint_move::SmoothJointMove;
pub use smooth_line::SmoothLine;
pub use spline_track::SplineTrack;
pub use squeezed_carry::SqueezedCarry;
pub use straight_line::StraightLine;
pub use transmit_displacement::TransmitDisplacement;
pub use yielding_transmit::YieldingTransmit;
