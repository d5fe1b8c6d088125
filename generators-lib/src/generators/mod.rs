//! Generators, to be used as they are, or copied and changed. Each is one file that uses only the public API.
//!
//! In the table, "uses" lists what a step takes besides the function's own state, and "lines" counts lines of code.
//! Every class of section 6 of the paper has at least one generator. [`combinators`](crate::combinators) make
//! generators out of these. The folder `pictures` of this crate shows what each generator demands over time, and its
//! path in space.
//!
#![doc = include_str!("../../classes.md")]

mod await_operator;
mod circular_move;
mod compliant_transmit;
mod constant_order;
mod curve_move;
mod delay;
mod eye_in_hand;
mod follow_master;
mod follow_trajectory;
mod followed_frame;
mod force_law;
mod guarded_approach;
mod guided_body;
mod jog;
mod joint_move;
mod joint_spline;
mod joint_velocity;
mod joint_via;
mod line_via;
mod moving_frame;
mod ordered_force;
mod panel_jog;
mod pose_spline_move;
mod reach_state;
mod replay;
mod rigid_carry;
mod settle;
mod shared_drive;
mod sleep;
mod smooth_joint_move;
mod spiral_search;
mod spline_track;
mod squeezed_carry;
mod straight_line;
mod tell;
mod tilt_search;
mod time_optimal_curve;
mod time_optimal_joints;
mod tool_offset;
mod transmit_displacement;
mod watched_transmit;
mod yielding_transmit;

pub use await_operator::AwaitOperator;
pub use circular_move::CircularMove;
pub use compliant_transmit::CompliantTransmit;
pub use constant_order::ConstantOrder;
pub use curve_move::CurveMove;
pub use delay::Delay;
pub use eye_in_hand::{EyeInHand, Servoing};
pub use follow_master::FollowMaster;
pub use follow_trajectory::FollowTrajectory;
pub use followed_frame::FollowedFrame;
pub use force_law::ForceLaw;
pub use guarded_approach::GuardedApproach;
pub use guided_body::GuidedBody;
pub use jog::Jog;
pub use joint_move::JointMove;
pub use joint_spline::JointSpline;
pub use joint_velocity::JointVelocity;
pub use joint_via::JointVia;
pub use line_via::LineVia;
pub use moving_frame::MovingFrame;
pub use ordered_force::{OrderedForce, Pressing};
pub use panel_jog::PanelJog;
pub use pose_spline_move::PoseSplineMove;
pub use reach_state::{JointOrder, ReachState};
pub use replay::Replay;
pub use rigid_carry::RigidCarry;
pub use settle::Settle;
pub use shared_drive::SharedDrive;
pub use sleep::Sleep;
pub use smooth_joint_move::SmoothJointMove;
pub use spiral_search::SpiralSearch;
pub use spline_track::SplineTrack;
pub use squeezed_carry::SqueezedCarry;
pub use straight_line::StraightLine;
pub use tell::Tell;
pub use tilt_search::TiltSearch;
pub use time_optimal_curve::TimeOptimalCurve;
pub use time_optimal_joints::TimeOptimalJoints;
pub use tool_offset::ToolOffset;
pub use transmit_displacement::TransmitDisplacement;
pub use watched_transmit::WatchedTransmit;
pub use yielding_transmit::YieldingTransmit;
