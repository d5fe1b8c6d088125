//! A curve of polynomial pieces.

use super::{Curve, CurveError, CurvePoint};
use crate::bspline::{Span, length_between, parameter_at};

/// Polynomial pieces, one after another, by their length.
///
/// Its pieces are kept in memory; a path of any length as a stream is a matter of [`feed`](crate::feed).
#[derive(Clone, Debug, PartialEq)]
pub struct SpanCurve {
    spans: Vec<Span>,
    /// Length to the end of each piece \[m\].
    lengths: Vec<f64>,
}

impl SpanCurve {
    /// Of pieces of which each begins where the one before it ends; those without length are left out.
    ///
    /// # Errors
    /// No piece that has a length, or a piece that is not finite.
    pub fn new(spans: impl IntoIterator<Item = Span>) -> Result<Self, CurveError> {
        let mut curve = SpanCurve { spans: Vec::new(), lengths: Vec::new() };
        let mut sum = 0.0;
        for span in spans {
            let length = length_between(&span, 0.0, span.knot_span());
            if length > 0.0 {
                sum += length;
                curve.spans.push(span);
                curve.lengths.push(sum);
            }
        }
        if !sum.is_finite() {
            return Err(CurveError::NotFinite);
        }
        if curve.spans.is_empty() { Err(CurveError::Coincident) } else { Ok(curve) }
    }

    /// The pieces.
    #[must_use]
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }
}

impl Curve for SpanCurve {
    fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or_default()
    }

    fn at(&self, s: f64) -> CurvePoint {
        let i = self.lengths.partition_point(|length| *length <= s).min(self.spans.len() - 1);
        let span = &self.spans[i];
        let start = if i == 0 { 0.0 } else { self.lengths[i - 1] };
        let h = span.knot_span();
        let u = if s >= self.lengths[i] { h } else { parameter_at(span, 0.0, h, s - start) };
        let geometry = span.at(u);
        let [tangent, curvature, _] = geometry.by_length();
        CurvePoint { position: geometry.position, tangent, curvature }
    }
}
