//! A camera of the machine as Linux knows it (Video4Linux): webcams, industrial cameras by USB with its class of video.

use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use mrroc::fault::Fault;
use rustix::time::{ClockId, clock_gettime};
use v4l::buffer::{Flags, Metadata, Type};
use v4l::io::mmap::Stream;
use v4l::io::traits::CaptureStream;
use v4l::video::Capture;
use v4l::{Device, Format, FourCC};

use super::photos::Photo;

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
/// let mut camera = VideoCamera::open("/dev/video0".as_ref(), [640, 480], 0.012)?;
/// let sensor = PhotoSensor::new(vision(), move || camera.take());
/// # let _ = sensor;
/// # Ok::<(), mrroc::fault::Fault>(())
/// ```
pub struct VideoCamera {
    stream: Stream<'static>,
    layout: Layout,
    size: [usize; 2],
    stride: usize,
    stamped_after: f64,
}

impl core::fmt::Debug for VideoCamera {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("VideoCamera")
            .field("layout", &self.layout)
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}

impl VideoCamera {
    /// How long [`take`](Self::take) waits for an image.
    const PATIENCE: Duration = Duration::from_millis(5);

    /// Opens the camera at `path`, such as `/dev/video0`, for images of `size` pixels, width and height. Its driver stamps an image `stamped_after`
    /// \[s\] after the middle of its exposure: most stamp it once it has been read out, so that this is half the exposure and the time of reading.
    ///
    /// # Errors
    /// If there is no such camera, another program has it, or it gives no grey images of that size.
    pub fn open(path: &Path, size: [usize; 2], stamped_after: f64) -> Result<Self, Fault> {
        let failed = |what: &str, error: &dyn core::fmt::Display| {
            Fault::thrown(&format!("the camera {} {what}: {error}", path.display()))
        };
        let device = Device::with_path(path).map_err(|error| failed("cannot be opened", &error))?;
        let [width, height] = size;
        let wanted = |layout: Layout| Format::new(width as u32, height as u32, layout.four_cc());
        let given = Layout::ALL.into_iter().find_map(|layout| {
            let format = device.set_format(&wanted(layout)).ok()?;
            let is_same =
                format.fourcc == layout.four_cc() && [format.width as usize, format.height as usize] == size;
            is_same.then_some((layout, format.stride as usize))
        });
        let Some((layout, stride)) = given else {
            let text = format!("{width} x {height} pixels as GREY or YUYV are not among its formats");
            return Err(failed("gives no grey images of this size", &text));
        };
        let mut stream = Stream::with_buffers(&device, Type::VideoCapture, 4)
            .map_err(|error| failed("gives no images", &error))?;
        stream.set_timeout(Self::PATIENCE);
        let stride = stride.max(width * layout.bytes_of_a_pixel());
        Ok(Self { stream, layout, size, stride, stamped_after })
    }

    /// The next image, if one has come.
    ///
    /// # Errors
    /// If the camera is gone, or its driver does not say when an image was taken.
    pub fn take(&mut self) -> Result<Option<Photo>, Fault> {
        let (bytes, told) = match self.stream.next() {
            Ok(image) => image,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
                return Ok(None);
            }
            Err(error) => {
                return Err(Fault::thrown(&format!("the camera gives no images any more: {error}")));
            }
        };
        // What its driver could not read whole.
        if told.flags.contains(Flags::ERROR) {
            return Ok(None);
        }
        let now = clock_gettime(ClockId::Monotonic);
        let now = now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64;
        let age = age(told, now)? + self.stamped_after;
        Ok(self.layout.grey(bytes, self.size, self.stride).map(|grey| Photo { grey, age }))
    }
}

/// For how long \[s\] an image has had its stamp, at a time \[s\] of the monotonic clock.
fn age(told: &Metadata, now: f64) -> Result<f64, Fault> {
    if told.flags & Flags::TIMESTAMP_MASK != Flags::TIMESTAMP_MONOTONIC {
        return Err(Fault::thrown(
            "the driver of the camera does not say by the monotonic clock when an image was taken: where its parts are cannot be told",
        ));
    }
    let stamp = told.timestamp.sec as f64 + 1e-6 * told.timestamp.usec as f64;
    Ok((now - stamp).max(0.0))
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
        assert!(age(&told, 100.2).expect("known") <= 0.0, "of the future");
    }

    #[test]
    fn a_camera_that_is_not_there_is_told_by_its_path() {
        let error = VideoCamera::open("/dev/no-such-camera".as_ref(), [640, 480], 0.0).expect_err("none");
        assert!(error.message().contains("/dev/no-such-camera"), "{error}");
        // A file of another kind is no camera.
        let error = VideoCamera::open("/dev/null".as_ref(), [640, 480], 0.0).expect_err("none");
        assert!(error.message().contains("no grey images"), "{error}");
    }
}
