//! A planner fed by an iterator of spans.

use super::{FeedError, FeedLimits, FeedPlanner, PathPoint};
use crate::bspline::{PathSpan, SplineError};

/// A path of spans, followed in path time: keeps a [`FeedPlanner`]'s horizon full.
#[derive(Clone, Debug)]
pub struct FedPath<I, const HORIZON: usize = 64> {
    spans: I,
    planner: FeedPlanner<HORIZON>,
    error: Option<FeedError>,
}

impl<I, const HORIZON: usize> FedPath<I, HORIZON>
where
    I: Iterator<Item = Result<PathSpan, SplineError>>,
{
    /// The path through `spans` within `limits`.
    ///
    /// # Errors
    /// A limit out of range.
    pub fn new<J>(limits: FeedLimits, spans: J) -> Result<Self, FeedError>
    where
        J: IntoIterator<IntoIter = I>,
    {
        Ok(Self { spans: spans.into_iter(), planner: FeedPlanner::new(limits)?, error: None })
    }

    /// Advances by `dt` \[s\] of path time, >= 0: the exact end once, at rest, then `None`. A path that turns out to be
    /// faulty ends, at rest, at its last good point; see [`Self::error`].
    pub fn advance(&mut self, dt: f64) -> Option<PathPoint> {
        while self.planner.has_room() {
            let pushed = match self.spans.next() {
                None => {
                    self.planner.finish();
                    break;
                }
                Some(span) => span.map_err(FeedError::from).and_then(|span| self.planner.push(span)),
            };
            if let Err(error) = pushed {
                self.error = Some(error);
                self.planner.finish();
            }
        }
        self.planner.advance(dt)
    }

    /// Why the path ended early, if it did.
    #[must_use]
    pub fn error(&self) -> Option<FeedError> {
        self.error
    }
}
