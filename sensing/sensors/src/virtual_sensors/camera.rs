//! A camera over a belt: which parts come, and where they are in the belt's own frame.
//!
//! ```text
//! trigger --10 ms--> exposure ------------ processing, 60 ms ------------> in the readings
//!                       |
//!                       +- the encoder's count is latched: x = place on the image - travel of the belt at the exposure
//! ```
//!
//! A place in the belt's frame does not age: that an image takes its time costs no accuracy.

use mrroc::pose::Pose;
use mrroc::prelude::*;
use mrroc::sensor::Frames;

use super::parts::{PartSensor, Spotted};
use super::sampled::Sampled;
use super::sighting::Sighting;
use crate::aggregation::{DetectedObject, Vision};
use crate::physics::{Imager, LightBarrier};
use crate::view::View;

/// What makes a camera take an image.
#[derive(Debug)]
pub enum Trigger {
    /// Something comes into a light barrier, whose beam runs along z of its frame `X_WL`.
    Barrier(Pose, Sampled),
    /// The belt has run so far since the last one \[m\].
    Travel(f64),
}

/// What is told of each image: the grey values, what was found, the time of the exposure \[s\] and the travel of the belt then \[m\].
pub type ImageObserver = Box<dyn FnMut(&[u8], &[DetectedObject], f64, f64)>;

/// A camera over a scene.
pub struct CameraSensor<S> {
    scene: S,
    imager: Imager,
    sighting: Sighting,
    trigger: Trigger,
    /// How old the state of the belt is that goes with an order \[s\].
    latch: f64,
    /// When the next image is exposed \[s\], and the travel of the belt at the last one.
    next: Option<f64>,
    last_travel: f64,
    image: Vec<u8>,
    frames: Frames,
    observer: Option<ImageObserver>,
}

impl<S> core::fmt::Debug for CameraSensor<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("CameraSensor").field("reading", &self.sighting.reading).finish_non_exhaustive()
    }
}

impl<S: View + 'static> CameraSensor<S> {
    /// From the trigger to the middle of the exposure \[s\].
    pub const DELAY: f64 = 0.01;
    /// From there until its parts are in readings \[s\].
    pub const PROCESSING: f64 = 0.06;

    /// What `imager` takes of a scene is evaluated by `vision`; `latch` \[s\] is how old the state of the belt is that goes with an order.
    #[must_use]
    pub fn new(scene: S, imager: Imager, vision: Vision, trigger: Trigger, latch: f64) -> Self {
        let pixels = vision.plane().width() * vision.plane().height();
        Self {
            scene,
            imager,
            sighting: Sighting::by(vision),
            trigger,
            latch,
            next: None,
            last_travel: 0.0,
            image: Vec::new(),
            frames: Frames::new(4, pixels),
            observer: None,
        }
    }

    /// The same, with an observer of its images.
    #[must_use]
    pub fn watched(self, observer: ImageObserver) -> Self {
        Self { observer: Some(observer), ..self }
    }

    /// The camera, to darken it.
    pub const fn imager(&mut self) -> &mut Imager {
        &mut self.imager
    }

    /// The barrier that triggers it, to break it.
    pub const fn barrier(&mut self) -> Option<&mut LightBarrier> {
        match &mut self.trigger {
            Trigger::Barrier(_, barrier) => Some(barrier.barrier()),
            Trigger::Travel(_) => None,
        }
    }

    /// Exposes an image whose middle is at `time` \[s\], when the belt had run `travel` \[m\].
    fn look(&mut self, step: u64, time: f64, travel: f64) -> Result<(), Fault> {
        self.imager.expose(&self.scene, time, &mut self.image);
        let [width, height] = self.sighting.vision().plane().camera.size;
        self.frames.image(step, (width as u32, height as u32), 1, &self.image);
        let Some(found) = self.sighting.evaluate(&self.image, travel, time + Self::PROCESSING)? else {
            return Ok(());
        };
        if let Some(observer) = &mut self.observer {
            observer(&self.image, &found, time, travel);
        }
        Ok(())
    }
}

impl<S: View + 'static> VirtualSensor for CameraSensor<S> {
    type Kind = PartSensor;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Spotted, Fault> {
        let belt = order.robot.ok_or_else(|| {
            Fault::thrown("a camera sees parts on a belt: write of = \"BELT\" in its table of cell.toml")
        })?;
        let now = self.scene.now();
        let travel = |time: f64| belt.joints[0] + belt.velocity[0] * (time - now + self.latch);
        let exposure = self.imager.exposure();
        if !self.sighting.vision().is_taught() && self.next.is_none() {
            self.next = Some(now + exposure);
        }
        match &mut self.trigger {
            Trigger::Barrier(beam, barrier) => {
                let next = &mut self.next;
                barrier.sample(
                    &self.scene,
                    |_| *beam,
                    |edge| {
                        if edge.covered && next.is_none() {
                            *next = Some(edge.time + Self::DELAY);
                        }
                    },
                );
            }
            Trigger::Travel(every) => {
                if self.next.is_none() && (travel(now) - self.last_travel).abs() >= *every {
                    self.next = Some(now + exposure);
                }
            }
        }
        (self.sighting.reading.travel, self.sighting.reading.speed) = (travel(now), belt.velocity[0]);
        if let Some(time) = self.next.filter(|time| now >= time + 0.5 * exposure) {
            self.next = None;
            self.last_travel = travel(time);
            let latched = self.last_travel;
            self.look(order.step, time, latched)?;
        }
        Ok(self.sighting.tell(now))
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn frames(&mut self) -> Option<&mut Frames> {
        Some(&mut self.frames)
    }
}
