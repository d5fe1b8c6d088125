//! From images to readings of the parts on a belt, whoever took the images.

use std::collections::VecDeque;

use mrroc::prelude::*;

use super::parts::{OnBelt, Pending, Spotted};
use crate::aggregation::{Blind, DetectedObject, Vision};

/// Evaluates images, and numbers the parts that come.
#[derive(Debug)]
pub(super) struct Sighting {
    vision: Vision,
    processed: Pending,
    known: VecDeque<OnBelt>,
    pub reading: Spotted,
}

impl Sighting {
    /// Things closer together than this are the same, seen twice \[m\].
    const SAME: f64 = 0.02;
    /// Parts that are kept to be told from new ones.
    const KEPT: usize = 32;

    pub fn by(vision: Vision) -> Self {
        Self { vision, processed: Pending::default(), known: VecDeque::new(), reading: Spotted::default() }
    }

    pub const fn vision(&self) -> &Vision {
        &self.vision
    }

    /// What is in an image that was exposed when the belt had run `travel` \[m\]; it is in readings from `from` \[s\] on. The first image is that of
    /// the empty belt: `None`.
    pub fn evaluate(
        &mut self,
        image: &[u8],
        travel: f64,
        from: f64,
    ) -> Result<Option<Vec<DetectedObject>>, Fault> {
        let dark = |error: Blind| Fault::thrown(&error.to_string());
        if !self.vision.is_taught() {
            self.vision.teach(image).map_err(dark)?;
            return Ok(None);
        }
        let found = self.vision.look(image).map_err(dark)?;
        self.reading.images += 1;
        for thing in &found {
            let along = thing.place.x - travel;
            let Some(class) = thing.class else {
                self.reading.unknown += 1;
                continue;
            };
            let near = |part: &OnBelt| (part.along - along).hypot(part.across - thing.place.y) < Self::SAME;
            if self.known.iter().any(near) {
                continue;
            }
            let number = self.known.front().map_or(0, |part| part.number) + 1;
            let (class, score, angle) = (class as u32, thing.score, thing.angle);
            let part = OnBelt { number, class, score, along, across: thing.place.y, angle };
            self.known.push_front(part);
            self.known.truncate(Self::KEPT);
            self.processed.push(from, part);
        }
        Ok(Some(found))
    }

    /// The reading at `now` \[s\].
    pub fn tell(&mut self, now: f64) -> Spotted {
        self.processed.tell(now, &mut self.reading);
        self.reading
    }
}
