//! A moving segment fed by an iterator.

use super::{MovingSegment, PathSpan, Poll, SplineError, SplinePoint, SplineSettings};

/// An iterator of spans over an iterator of points; constant memory.
#[derive(Clone, Debug)]
pub struct SpanStream<I> {
    points: I,
    segment: MovingSegment,
    failed: bool,
}

impl<I> SpanStream<I> {
    /// Spans of the curve through `points` \[m\].
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new<J>(settings: SplineSettings, points: J) -> Result<Self, SplineError>
    where
        J: IntoIterator<IntoIter = I>,
    {
        Ok(Self { points: points.into_iter(), segment: MovingSegment::new(settings)?, failed: false })
    }
}

impl<I> Iterator for SpanStream<I>
where
    I: Iterator,
    I::Item: Into<SplinePoint>,
{
    type Item = Result<PathSpan, SplineError>;

    /// The next span; an error, once, at a point that is not finite.
    fn next(&mut self) -> Option<Self::Item> {
        while !self.failed {
            match self.segment.poll() {
                Poll::Span(span) => return Some(Ok(span)),
                Poll::Done => return None,
                Poll::NeedPoint => match self.points.next() {
                    None => self.segment.finish(),
                    Some(point) => {
                        if let Err(error) = self.segment.push(point.into()) {
                            self.failed = true;
                            return Some(Err(error));
                        }
                    }
                },
            }
        }
        None
    }
}
