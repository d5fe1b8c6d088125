//! Generators, each in one file on the public API alone: to be used as they are, or copied and changed.
//!
//! | generator | what it does | class |
//! |---|---|---|
//! | [`Carry`] | several arms carry a rigid body along a path | MP `f*0(c0)`, first step `f*2(c0, e)` |
//! | [`Transmit`] | passes the coordinator's displacements on | ECP `f*4(c0, c)` |
//! | [`JointMove`] | straight line in joint space | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`StraightLine`] | straight line of the tool frame | ECP `f*0(c)`, first step `f*2(c, e)` |
//! | [`SplineTrack`] | the moving-segment B-spline through a stream of points | ECP `f*0(c)` |
//! | [`GuardedApproach`] | straight on until a sensor says so | ECP `f*1(c, v)`, first step `f*3(c, e, v)` |

mod carry;
mod guarded_approach;
mod joint_move;
mod spline_track;
mod straight_line;
mod transmit;

pub use carry::Carry;
pub use guarded_approach::GuardedApproach;
pub use joint_move::JointMove;
pub use spline_track::SplineTrack;
pub use straight_line::StraightLine;
pub use transmit::Transmit;
