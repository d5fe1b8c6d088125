//! The moving-segment B-spline: a smooth curve through a stream of points of which only a window is known.
//!
//! "A series of B-spline curves each spanning 8 points; of each only the piece between the first two points is used;
//! then the window is shifted by one." In: points, one at a time ([`MovingSegment::push`]) or from an iterator
//! ([`SpanStream`]). Out: one polynomial [`Span`] per pair of neighbouring points. Memory is that of one window,
//! whatever the length of the path; what comes out does not depend on how the points arrive.
//!
//! | [`Method`] | start of a window | continuity at joins | meets the points |
//! |---|---|---|---|
//! | `Literal` | as the far end | position only | exactly |
//! | `Interpolating` | the slope already reached | C1; S'' jumps by 2(2 - sqrt 3)^(W-2) | exactly |
//! | `C2` | as `Interpolating`, quintic spans between its slopes and second derivatives | C2 | exactly |
//! | `FrozenControlPoints` | the control points already computed | C2 | to 3e-5 of the second difference |
//!
//! With `h_i` the knot spans and `D_i = (P_{i+1} - P_i) / h_i`, a window's slopes `m` satisfy
//! `h_i m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_{i-1} m_{i+1} = 3 (h_i D_{i-1} + h_{i-1} D_i)`
//! (de Boor, *A Practical Guide to Splines*, chapter IV). A point's influence decays by 2 - sqrt 3 = 0.268 per knot:
//! that is why a window of 8 gives the first span of the spline through all points to about 1e-4 of a second
//! difference.

mod arc;
mod closed;
mod frozen;
mod gauss;
mod moving;
mod parametrisation;
mod point;
mod span;
mod span_length;
mod stream;
mod window;

pub use arc::{length_between, parameter_at};
pub(crate) use arc::{length_measured, parameter_at_plain};
pub use closed::ClosedPoints;
pub use moving::{Method, MovingSegment, Poll, SplineError, SplineSettings, WINDOW_MAX, WINDOW_MIN};
pub use parametrisation::Parametrisation;
pub use point::{Junction, Part, PathSpan, SpanEnd, SplinePoint};
pub use span::{Span, SpanGeometry};
pub use span_length::SpanLength;
pub use stream::SpanStream;
pub use window::{EndCondition, first_slopes};
