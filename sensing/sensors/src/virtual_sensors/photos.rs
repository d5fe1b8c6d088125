//! A real camera over a belt, or its images in files: which parts come, and where they are in the belt's own frame.

use mrroc::prelude::*;

use super::parts::{PartSensor, Spotted};
use super::sighting::Sighting;
use crate::aggregation::Vision;

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Photo {
    /// Grey values, row by row, of the size of the camera by which they are evaluated.
    pub grey: Vec<u8>,
    /// How old it was when it was asked for: since the middle of its exposure \[s\]; below 0 of one that was exposed later.
    pub age: f64,
}

/// Where the images of a [`PhotoSensor`] come from. A closure that gives them is one, too.
pub trait PhotoSource: 'static {
    /// The newest image, if there is a new one. It is called in the sensor's own process, and may wait for the camera.
    ///
    /// # Errors
    /// Why there are none any more.
    fn take(&mut self) -> Result<Option<Photo>, Fault>;

    /// As [`VirtualSensor::hardware`].
    fn hardware(&self) -> Option<String> {
        None
    }

    /// As [`VirtualSensor::open`].
    ///
    /// # Errors
    /// Why it could not be opened.
    fn open(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}

impl<T: FnMut() -> Result<Option<Photo>, Fault> + 'static> PhotoSource for T {
    fn take(&mut self) -> Result<Option<Photo>, Fault> {
        self()
    }
}

/// A camera whose images come from elsewhere, read with delay. The first one must be of the empty belt.
///
/// How far the belt had run at an exposure is computed from the state that comes with the order, its speed, and the age of the image, which is at most
/// half a second.
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
/// let sensor = PhotoSensor::new(vision, move || Ok(images.next().map(|grey| Photo { grey, age: 0.02 })), 2e-3);
/// # let _ = sensor;
/// ```
pub struct PhotoSensor<T> {
    source: T,
    latch: f64,
    sighting: Sighting,
}

impl<T> core::fmt::Debug for PhotoSensor<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("PhotoSensor").field("sighting", &self.sighting).finish_non_exhaustive()
    }
}

impl<T: PhotoSource> PhotoSensor<T> {
    /// The oldest image whose place on the belt is believed \[s\].
    const OLDEST: f64 = 0.5;

    /// What `source` gives is evaluated by `vision`; `latch` \[s\] is how old the state of the belt is that goes with an order.
    #[must_use]
    pub fn new(vision: Vision, source: T, latch: f64) -> Self {
        Self { source, latch, sighting: Sighting::by(vision) }
    }
}

impl<T: PhotoSource> VirtualSensor for PhotoSensor<T> {
    type Kind = PartSensor;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Spotted, Fault> {
        let belt = order.robot.ok_or_else(|| {
            Fault::thrown("a camera sees parts on a belt: write of = \"BELT\" in its table of cell.toml")
        })?;
        let (travel, speed) = (belt.joints[0], belt.velocity[0]);
        if let Some(Photo { grey, age }) = self.source.take()? {
            let [width, height] = self.sighting.vision().plane().camera.size;
            if grey.len() != width * height {
                let fault = Fault::thrown(
                    "an image has not the size of the camera by which it is evaluated: give that camera's size to `Camera`",
                );
                return Err(fault.exceeds(grey.len() as f64, (width * height) as f64, "pixel"));
            }
            if age.is_nan() || age.abs() > Self::OLDEST {
                let fault = Fault::thrown("an image is too old to tell where its parts are on the belt");
                return Err(fault.exceeds(age, Self::OLDEST, "s"));
            }
            self.sighting.evaluate(&grey, travel - speed * (age - self.latch), 0.0)?;
        }
        (self.sighting.reading.travel, self.sighting.reading.speed) = (travel, speed);
        Ok(self.sighting.tell(0.0))
    }

    fn hardware(&self) -> Option<String> {
        self.source.hardware()
    }

    fn open(&mut self) -> Result<(), Fault> {
        self.source.open()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregation::{PartClass, Sole};
    use crate::camera::{Camera, Plane};
    use crate::form::{Form, Piece};
    use crate::physics::Imager;
    use crate::scene::{Scene, Solid};
    use crate::view::{Seen, View};
    use mrroc::sensor::EffectorState;
    use nalgebra::Vector3;

    /// A block at a place along the belt, or none.
    struct Block(Option<f64>);

    impl Scene for Block {
        fn now(&self) -> f64 {
            0.0
        }

        fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
    }

    impl View for Block {
        fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
            let Some(x) = self.0 else { return };
            visit(&Seen {
                form: &form(),
                pose: Pose::translation(x, 0.01, 0.0),
                velocity: Vector3::zeros(),
                angular_velocity: Vector3::zeros(),
                reflectance: 0.8,
            });
        }

        fn surface(&self, _: f64) -> f64 {
            0.0
        }
    }

    fn form() -> Form {
        let lower = Vector3::new(-0.035, -0.025, 0.0);
        Form::new([Piece::Block { lower, upper: Vector3::new(0.035, 0.025, 0.04) }])
    }

    fn plane() -> Plane {
        let down = Pose::translation(0.0, 0.0, 0.85) * Pose::rotation(Vector3::x() * core::f64::consts::PI);
        Plane::new(Camera::MRROCPP, down)
    }

    fn vision() -> Vision {
        let block = PartClass { name: "block", form: form(), turns: 2 };
        Vision::new(plane(), vec![block], Box::new(Sole))
    }

    /// With the belt at a travel and a speed.
    fn order(travel: f64, speed: f64) -> ReadingOrder<()> {
        let (mut joints, mut velocity) = ([0.0; mrroc::robot::MAX_JOINTS], [0.0; mrroc::robot::MAX_JOINTS]);
        (joints[0], velocity[0]) = (travel, speed);
        let belt = EffectorState { joints, velocity, pose: Pose::identity(), wrench: None };
        ReadingOrder { configuration: (), robot: Some(belt), step: 0 }
    }

    #[test]
    fn a_photo_tells_the_place_that_a_part_had_on_the_belt_when_it_was_exposed() {
        let mut imager = Imager::over(plane(), 3);
        let mut photo = |x: Option<f64>, age: f64| {
            let mut grey = Vec::new();
            imager.expose(&Block(x), 0.0, &mut grey);
            Ok(Some(Photo { grey, age }))
        };
        // The empty belt; nothing new; the part at 0.03 m, 0.052 s ago; the same part 0.02 m later; and another 0.05 s after it was asked for.
        let photos = [
            photo(None, 0.0),
            Ok(None),
            photo(Some(0.03), 0.052),
            photo(Some(0.05), 0.0),
            photo(Some(0.1), -0.05),
        ];
        let mut photos = photos.into_iter();
        // The belt's state is 2 ms old when it comes.
        let mut sensor = PhotoSensor::new(vision(), move || photos.next().unwrap_or(Ok(None)), 2e-3);
        assert_eq!(sensor.aggregate(&order(0.0, 0.1)).expect("the empty belt").parts, 0);
        assert_eq!(sensor.aggregate(&order(0.1, 0.1)).expect("nothing new").images, 0);
        let seen = sensor.aggregate(&order(0.2, 0.1)).expect("a part");
        // The belt had run 0.2 - 0.1 (0.052 - 0.002) = 0.195 m at the exposure.
        let part = seen.newest[0];
        assert!(seen.parts == 1 && (part.along - (0.03 - 0.195)).abs() < 5e-4, "{part:?}");
        assert!((part.across - 0.01).abs() < 5e-4 && part.angle.abs() < 0.01, "{part:?}");
        assert_eq!(sensor.aggregate(&order(0.215, 0.1)).expect("again").parts, 1);
        let next = sensor.aggregate(&order(0.4, 0.1)).expect("another").newest[0];
        assert!((next.along - (0.1 - 0.4052)).abs() < 5e-4, "{next:?}");
    }

    #[test]
    fn fault_217_a_photo_of_another_size_or_of_no_age_is_refused() {
        for (pixels, age) in [(100, 0.0), (768 * 576, f64::NAN), (768 * 576, -1.0), (768 * 576, 0.6)] {
            let mut photo = Some(Photo { grey: vec![90; pixels], age });
            let mut sensor = PhotoSensor::new(vision(), move || Ok(photo.take()), 0.0);
            assert!(sensor.aggregate(&order(0.0, 0.0)).is_err(), "{pixels} {age}");
        }
        let mut dark = Some(Photo { grey: vec![0; 768 * 576], age: 0.0 });
        let mut sensor = PhotoSensor::new(vision(), move || Ok(dark.take()), 0.0);
        assert!(sensor.aggregate(&order(0.0, 0.0)).is_err(), "an empty belt without light");
        let mut sensor = PhotoSensor::new(vision(), || Ok(None), 0.0);
        let alone = ReadingOrder { configuration: (), robot: None, step: 0 };
        assert!(sensor.aggregate(&alone).is_err(), "of no belt");
    }
}
