//! A real camera over a belt, or its images in files: which parts come, and where they are in the belt's own frame.

use mrroc::prelude::*;

use super::parts::{PartSensor, Spotted};
use super::sighting::Sighting;
use crate::aggregation::Vision;

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Photo {
    /// Grey values, row by row, of the size of the camera by which they are judged.
    pub grey: Vec<u8>,
    /// How old it is: since the middle of its exposure \[s\], finite, >= 0.
    pub age: f64,
}

/// A camera whose images come from elsewhere. The first one must be of the empty belt.
///
/// `take` gives an image when there is a new one. It runs in the sensor's own process, with delay or free running, so it may wait for the camera.
/// The belt has run as far as it had at the exposure by the state that comes with the order, and its speed since then.
///
/// ```
/// use mrroc::pose::Pose;
/// use mrroc_sensors::aggregation::{PartClass, Sole, Vision};
/// use mrroc_sensors::camera::{Camera, Plane};
/// use mrroc_sensors::form::{Form, Piece};
/// use mrroc_sensors::virtual_sensors::{Photo, PhotoSensor};
/// use nalgebra::Vector3;
///
/// let down = Pose::translation(0.0, 0.0, 0.85) * Pose::rotation(Vector3::x() * core::f64::consts::PI);
/// let form = Form::new([Piece::Tube { radius: 0.03, inner: 0.0, height: 0.04 }]);
/// let disc = PartClass { name: "disc", form, turns: 0 };
/// let vision = Vision::new(Plane::new(Camera::MRROCPP, down), vec![disc], Box::new(Sole));
/// // A driver of a camera asks it here; this one has one image of the empty belt.
/// let mut images = vec![vec![90; 768 * 576]].into_iter();
/// let sensor = PhotoSensor::new(vision, move || Ok(images.next().map(|grey| Photo { grey, age: 0.02 })));
/// # let _ = sensor;
/// ```
pub struct PhotoSensor<T> {
    take: T,
    sighting: Sighting,
}

impl<T> core::fmt::Debug for PhotoSensor<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("PhotoSensor").field("sighting", &self.sighting).finish_non_exhaustive()
    }
}

impl<T: FnMut() -> Result<Option<Photo>, Fault> + 'static> PhotoSensor<T> {
    /// What `take` gives is judged by `vision`.
    #[must_use]
    pub fn new(vision: Vision, take: T) -> Self {
        Self { take, sighting: Sighting::by(vision) }
    }
}

impl<T: FnMut() -> Result<Option<Photo>, Fault> + 'static> VirtualSensor for PhotoSensor<T> {
    type Kind = PartSensor;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Spotted, Fault> {
        let belt = order.robot.ok_or_else(|| {
            Fault::thrown("a camera sees parts on a belt: write of = \"BELT\" in its table of cell.toml")
        })?;
        let (way, speed) = (belt.joints[0], belt.velocity[0]);
        if let Some(Photo { grey, age }) = (self.take)()? {
            let [width, height] = self.sighting.vision().plane().camera.size;
            if grey.len() != width * height {
                let fault = Fault::thrown(
                    "an image has not the size of the camera by which it is judged: give that camera's size to `Camera`",
                );
                return Err(fault.exceeds(grey.len() as f64, (width * height) as f64, "pixel"));
            }
            if !(age.is_finite() && age >= 0.0) {
                return Err(Fault::thrown("the age of an image must be finite and >= 0 s"));
            }
            self.sighting.judge(&grey, way - speed * age, 0.0)?;
        }
        (self.sighting.reading.way, self.sighting.reading.speed) = (way, speed);
        Ok(self.sighting.tell(0.0))
    }
}
