//! A camera of the machine as Linux knows it (Video4Linux): webcams, industrial cameras by USB with its class of video.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;

use mrroc::fault::{Fault, FaultKind};
use rustix::time::{ClockId, clock_gettime};
use v4l::buffer::{Flags, Metadata, Type};
use v4l::io::mmap::Stream;
use v4l::io::traits::CaptureStream;
use v4l::video::Capture;
use v4l::{Device, Format, FourCC};

use super::photos::{Photo, PhotoSource};

/// What is waited for: an image to read (`poll(2)`).
const POLLIN: i16 = 1;

/// How its images lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// A byte for each pixel.
    Grey,
    /// Two bytes for each pixel, the first of which is its brightness.
    Yuyv,
}

impl Layout {
    const ALL: [Layout; 2] = [Layout::Grey, Layout::Yuyv];

    fn four_cc(self) -> FourCC {
        FourCC::new(match self {
            Layout::Grey => b"GREY",
            Layout::Yuyv => b"YUYV",
        })
    }

    const fn bytes_of_a_pixel(self) -> usize {
        match self {
            Layout::Grey => 1,
            Layout::Yuyv => 2,
        }
    }

    /// The grey values of an image of `width` pixels in each of `height` rows, which begin `stride` bytes apart. `None` if it is too short.
    fn grey(self, bytes: &[u8], [width, height]: [usize; 2], stride: usize) -> Option<Vec<u8>> {
        let step = self.bytes_of_a_pixel();
        let mut grey = Vec::with_capacity(width * height);
        for row in 0..height {
            let row = bytes.get(row * stride..row * stride + width * step)?;
            grey.extend(row.iter().step_by(step));
        }
        Some(grey)
    }
}

/// A camera of this machine, whose images a [`PhotoSensor`](super::PhotoSensor) takes.
///
/// Its driver must be able to give grey images (`GREY`) or brightness with colours (`YUYV`) of the size that is asked for, and must say by the
/// monotonic clock when it took them. It was never run with a real camera.
///
/// ```no_run
/// # fn vision() -> mrroc_sensors::aggregation::Vision { unimplemented!() }
/// use mrroc_sensors::virtual_sensors::{PhotoSensor, VideoCamera};
///
/// // 640 x 480 pixels; the driver says when an image had come, 12 ms after the middle of its exposure.
/// let camera = VideoCamera::at("/dev/video0", [640, 480], 0.012);
/// let sensor = PhotoSensor::new(vision(), camera, 2e-3);
/// # let _ = sensor;
/// ```
pub struct VideoCamera {
    path: PathBuf,
    size: [usize; 2],
    stamped_after: f64,
    opened: Option<Opened>,
}

/// A camera that gives images.
struct Opened {
    stream: Stream<'static>,
    layout: Layout,
    stride: usize,
    /// When it gave one last, by the monotonic clock \[s\].
    heard: f64,
}

impl core::fmt::Debug for VideoCamera {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("VideoCamera")
            .field("path", &self.path)
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}

impl VideoCamera {
    /// How long an image is waited for when one is asked for \[ms\].
    const TIMEOUT_MS: i32 = 5;
    /// How long the first image may take ..
    const FIRST: Duration = Duration::from_secs(2);
    /// .. and how long there may be none \[s\].
    const SILENCE: f64 = 1.0;

    /// The camera at `path`, such as `/dev/video0`, for images of `size` pixels, width and height: the sensor opens it. Its driver stamps an image
    /// `stamped_after` \[s\] after the middle of its exposure: most stamp it once it has been read out, so that this is half the exposure and
    /// the time of reading.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>, size: [usize; 2], stamped_after: f64) -> Self {
        Self { path: path.into(), size, stamped_after, opened: None }
    }

    fn failed(&self, what: &str, error: &dyn core::fmt::Display) -> Fault {
        Fault::new(FaultKind::SensorFailed)
            .text(&format!("the camera {} {what}: {error}", self.path.display()))
    }
}

impl PhotoSource for VideoCamera {
    fn hardware(&self) -> Option<String> {
        Some(format!("camera {}", self.path.display()))
    }

    fn open(&mut self) -> Result<(), Fault> {
        self.opened = None;
        let device =
            Device::with_path(&self.path).map_err(|error| self.failed("cannot be opened", &error))?;
        let [width, height] = self.size;
        let wanted = |layout: Layout| Format::new(width as u32, height as u32, layout.four_cc());
        let given = Layout::ALL.into_iter().find_map(|layout| {
            let format = device.set_format(&wanted(layout)).ok()?;
            let is_same = format.fourcc == layout.four_cc()
                && [format.width as usize, format.height as usize] == self.size;
            is_same.then_some((layout, format.stride as usize))
        });
        let Some((layout, stride)) = given else {
            let text = format!("{width} x {height} pixels as GREY or YUYV are not among its formats");
            return Err(self.failed("gives no grey images of this size", &text));
        };
        let mut stream = Stream::with_buffers(&device, Type::VideoCapture, 4)
            .map_err(|error| self.failed("gives no images", &error))?;
        // A stream that has timed out once hands its buffers to the driver twice, and is refused: so an image is only asked for that is there,
        // but for this one, which begins the stream.
        stream.set_timeout(Self::FIRST);
        stream.next().map_err(|error| self.failed("gives no images", &error))?;
        let stride = stride.max(width * layout.bytes_of_a_pixel());
        self.opened = Some(Opened { stream, layout, stride, heard: now() });
        Ok(())
    }

    fn take(&mut self) -> Result<Option<Photo>, Fault> {
        let asked = now();
        let Some(Opened { stream, layout, stride, heard }) = &mut self.opened else {
            return Err(Fault::new(FaultKind::SensorFailed).text("the camera has not been opened"));
        };
        let mut newest = None;
        let mut timeout = Self::TIMEOUT_MS;
        let told = loop {
            match stream.handle().poll(POLLIN, timeout) {
                Ok(0) => break Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => break Ok(()),
                Err(error) => break Err(error),
                Ok(_) => {}
            }
            match stream.next() {
                // What its driver could not read whole is none.
                Ok((_, told)) if told.flags.contains(Flags::ERROR) => {}
                Ok((bytes, told)) => {
                    if let Some(grey) = layout.grey(bytes, self.size, *stride) {
                        newest = Some(Photo { grey, age: age(told, asked)? + self.stamped_after });
                        *heard = now();
                    }
                }
                Err(error) => break Err(error),
            }
            timeout = 0;
        };
        let silent = now() - *heard > Self::SILENCE;
        match told {
            Err(error) => Err(self.failed("gives no images any more", &error)),
            Ok(()) if newest.is_none() && silent => {
                let text = "none has come for 1 s; is it plugged in, or does it wait for a trigger?";
                Err(self.failed("gives no images", &text))
            }
            Ok(()) => Ok(newest),
        }
    }
}

/// The monotonic clock \[s\].
fn now() -> f64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// For how long \[s\] an image had had its stamp, at a time \[s\] of the monotonic clock; below 0 before it.
fn age(told: &Metadata, at: f64) -> Result<f64, Fault> {
    if told.flags & Flags::TIMESTAMP_MASK != Flags::TIMESTAMP_MONOTONIC {
        return Err(Fault::thrown(
            "the driver of the camera does not say by the monotonic clock when an image was taken: where its parts are cannot be told",
        ));
    }
    let stamp = told.timestamp.sec as f64 + 1e-6 * told.timestamp.usec as f64;
    Ok(at - stamp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use v4l::timestamp::Timestamp;

    #[test]
    fn rows_with_padding_are_grey_values_side_by_side() {
        let grey = [1, 2, 3, 0, 4, 5, 6, 0];
        assert_eq!(Layout::Grey.grey(&grey, [3, 2], 4), Some(vec![1, 2, 3, 4, 5, 6]));
        // Brightness and colour in turn, and two bytes at the end of a row.
        let yuyv = [1, 128, 2, 128, 0, 0, 3, 128, 4, 128, 0, 0];
        assert_eq!(Layout::Yuyv.grey(&yuyv, [2, 2], 6), Some(vec![1, 2, 3, 4]));
        // The padding of the last row need not be there, its pixels must.
        assert_eq!(Layout::Grey.grey(&grey[..7], [3, 2], 4), Some(vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(Layout::Grey.grey(&grey[..6], [3, 2], 4), None);
    }

    #[test]
    fn an_image_is_as_old_as_its_stamp_on_the_monotonic_clock_and_on_no_other() {
        let mut told = Metadata { timestamp: Timestamp::new(100, 250_000), ..Metadata::default() };
        assert!(age(&told, 100.3).is_err(), "a clock that is not known");
        told.flags = Flags::TIMESTAMP_COPY;
        assert!(age(&told, 100.3).is_err(), "a stamp of another");
        told.flags = Flags::TIMESTAMP_MONOTONIC | Flags::TSTAMP_SRC_SOE | Flags::DONE;
        assert!((age(&told, 100.3).expect("known") - 0.05).abs() < 1e-9);
        assert!((age(&told, 100.2).expect("known") + 0.05).abs() < 1e-9, "exposed after it was asked for");
    }

    #[test]
    fn a_camera_that_is_not_there_is_told_by_its_path() {
        let mut none = VideoCamera::at("/dev/no-such-camera", [640, 480], 0.0);
        assert_eq!(none.hardware().as_deref(), Some("camera /dev/no-such-camera"));
        let error = none.open().expect_err("none");
        assert!(error.message().contains("/dev/no-such-camera"), "{error}");
        // A file of another kind is no camera.
        let error = VideoCamera::at("/dev/null", [640, 480], 0.0).open().expect_err("none");
        assert!(error.message().contains("no grey images"), "{error}");
        assert!(none.take().is_err(), "before it is open");
    }
}
