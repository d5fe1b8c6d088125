//! Frames: what a virtual sensor has besides its reading, too large for a message: images, and the samples of an echo.
//!
//! In: a frame, from the sensor's aggregation. Out: the same to a [`FrameSink`] on a thread of its own, which may lag or block
//! without delaying the sensor. Between them is a queue of slots that are set aside beforehand. No control process has part in
//! it: the thread is in the process of the sensor.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::console::complain;

/// How long a sensor under the virtual clock, which stands still meanwhile, waits for a slot.
const TIMEOUT: Duration = Duration::from_secs(10);

/// What the bytes of a frame are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// Rows from top to bottom, pixels from left to right, channels of a pixel beside each other.
    Image {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// 1: grey, 2: grey and alpha, 3: red, green, blue, 4: with alpha.
        channels: u8,
        /// Bytes of a channel: 1, or 2 with the more significant one first.
        depth: u8,
    },
    /// Samples of 4 bytes, `f32` in little-endian order.
    Echo {
        /// From one sample to the next \[s\].
        interval: f64,
    },
}

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    step: u64,
    content: Content,
    bytes: Box<[u8]>,
    used: usize,
}

impl Frame {
    /// The step in which the sensor took it.
    #[must_use]
    pub const fn step(&self) -> u64 {
        self.step
    }

    /// What its bytes are.
    #[must_use]
    pub const fn content(&self) -> Content {
        self.content
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.used]
    }

    /// The samples of an echo; none of an image.
    pub fn samples(&self) -> impl Iterator<Item = f32> {
        let is_echo = matches!(self.content, Content::Echo { .. });
        let bytes = if is_echo { self.bytes() } else { &[] };
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }
}

/// Writes the frames of one sensor.
pub trait FrameSink: Send {
    /// Writes a frame.
    ///
    /// # Errors
    /// What keeps it from being written; the frames after it are not tried.
    fn write(&mut self, frame: &Frame) -> io::Result<()>;

    /// Ends the output, in which so many frames are missing.
    ///
    /// # Errors
    /// What keeps it from being written.
    fn finish(&mut self, dropped: u64) -> io::Result<()>;
}

/// What a virtual sensor hands its frames to; it keeps this beside its raw sensors, and shows it to the runtime by
/// [`VirtualSensor::frames`](crate::sensor::VirtualSensor::frames).
///
/// A frame is copied into a free slot. If all slots wait to be written, the new frame is dropped and counted; under the virtual
/// clock the sensor waits for the thread instead. What is missing is told when the run is over. Where nobody wants frames (no
/// recording, no folder for them) a frame is not even copied.
///
/// ```
/// use mrroc_core::sensor::Frames;
///
/// // Four slots for images of 64 x 48 grey pixels.
/// let mut frames = Frames::new(4, 64 * 48);
/// let image = vec![128; 64 * 48];
/// frames.image(0, (64, 48), 1, &image); // nobody wants it: nothing happens
/// assert!(!frames.are_wanted());
/// ```
#[derive(Debug)]
pub struct Frames {
    slots: usize,
    bytes: usize,
    queue: Option<Queue>,
}

#[derive(Debug)]
struct Queue {
    name: String,
    free: Receiver<Frame>,
    /// Dropped before the thread is waited for.
    full: Option<SyncSender<Frame>>,
    thread: Option<JoinHandle<Written>>,
    /// Whether it waits for a slot.
    waits: bool,
    dropped: u64,
    misfits: u64,
}

/// What the thread has done.
#[derive(Debug)]
struct Written {
    sink: Box<dyn FrameSink>,
    failed: Option<io::Error>,
    unwritten: u64,
}

impl core::fmt::Debug for dyn FrameSink {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("FrameSink")
    }
}

impl Frames {
    /// A queue of `slots` frames, at least 1, of at most `bytes` bytes each: `width * height * channels` of an image of `u8`,
    /// twice as many of `u16`, 4 for each sample of an echo.
    #[must_use]
    pub const fn new(slots: usize, bytes: usize) -> Frames {
        Frames { slots: if slots == 0 { 1 } else { slots }, bytes, queue: None }
    }

    /// Whether anybody wants frames: if not, there is no need to make one.
    #[must_use]
    pub const fn are_wanted(&self) -> bool {
        self.queue.is_some()
    }

    /// Hands over an image of `width` times `height` pixels, each with 1 to 4 channels of 0 to 255, taken in `step`.
    pub fn image(&mut self, step: u64, (width, height): (u32, u32), channels: u8, pixels: &[u8]) {
        let content = Content::Image { width, height, channels, depth: 1 };
        let fits = pixels_of(width, height, channels) == Some(pixels.len());
        self.hand(step, content, pixels.len(), fits, |bytes| bytes.copy_from_slice(pixels));
    }

    /// The same of channels of 0 to 65535, such as depths in millimetres.
    pub fn image_u16(&mut self, step: u64, (width, height): (u32, u32), channels: u8, pixels: &[u16]) {
        let content = Content::Image { width, height, channels, depth: 2 };
        let fits = pixels_of(width, height, channels) == Some(pixels.len());
        self.hand(step, content, 2 * pixels.len(), fits, |bytes| {
            for (bytes, pixel) in bytes.chunks_exact_mut(2).zip(pixels) {
                bytes.copy_from_slice(&pixel.to_be_bytes());
            }
        });
    }

    /// Hands over the samples of an echo, `interval` \[s\] apart, taken in `step`.
    pub fn echo(&mut self, step: u64, interval: f64, samples: &[f32]) {
        let fits = interval.is_finite() && interval > 0.0;
        self.hand(step, Content::Echo { interval }, 4 * samples.len(), fits, |bytes| {
            for (bytes, sample) in bytes.chunks_exact_mut(4).zip(samples) {
                bytes.copy_from_slice(&sample.to_le_bytes());
            }
        });
    }

    fn hand(&mut self, step: u64, content: Content, used: usize, fits: bool, fill: impl FnOnce(&mut [u8])) {
        let most = self.bytes;
        let Some(queue) = &mut self.queue else { return };
        if !fits || used == 0 || used > most {
            queue.misfits += 1;
            return;
        }
        let Some(mut frame) = queue.slot() else {
            queue.dropped += 1;
            return;
        };
        (frame.step, frame.content, frame.used) = (step, content, used);
        fill(&mut frame.bytes[..used]);
        // There is room for every slot; it fails only without the thread.
        if queue.full.as_ref().is_none_or(|full| full.try_send(frame).is_err()) {
            queue.dropped += 1;
        }
    }

    /// From now on a thread writes the frames of the sensor `name` to `sink`; with `waits` a frame is not dropped while the
    /// thread makes progress.
    ///
    /// # Errors
    /// The system has no thread for it.
    pub(crate) fn write_to(&mut self, name: &str, waits: bool, sink: Box<dyn FrameSink>) -> io::Result<()> {
        let (gives_back, free) = sync_channel(self.slots);
        let (full, comes) = sync_channel(self.slots);
        for _ in 0..self.slots {
            let bytes = vec![0; self.bytes].into_boxed_slice();
            // There is room for all of them.
            let _ = gives_back.try_send(Frame {
                step: 0,
                content: Content::Echo { interval: 1.0 },
                bytes,
                used: 0,
            });
        }
        let write = move || write_all(sink, &comes, &gives_back);
        let thread = Some(std::thread::Builder::new().name("frames".to_owned()).spawn(write)?);
        let name = name.to_owned();
        self.queue = Some(Queue { name, free, full: Some(full), thread, waits, dropped: 0, misfits: 0 });
        Ok(())
    }
}

/// The number of values of an image that makes sense.
fn pixels_of(width: u32, height: u32, channels: u8) -> Option<usize> {
    let all = (width as usize).checked_mul(height as usize)?.checked_mul(channels.into())?;
    (1..=4).contains(&channels).then_some(all)
}

impl Queue {
    /// A slot to be filled.
    fn slot(&self) -> Option<Frame> {
        let taken = self.free.try_recv().ok();
        if taken.is_none() && self.waits { self.free.recv_timeout(TIMEOUT).ok() } else { taken }
    }
}

impl Drop for Queue {
    /// Waits until the last frame is written, and tells what is missing.
    fn drop(&mut self) {
        drop(self.full.take());
        let name = &self.name;
        let Some(Ok(mut written)) = self.thread.take().map(JoinHandle::join) else {
            complain(&format!(
                "warning: the frames of sensor `{name}` are not complete: their writer panicked"
            ));
            return;
        };
        let missing = self.dropped + written.unwritten;
        let finished = written.sink.finish(missing);
        if let Some(error) = written.failed.or(finished.err()) {
            complain(&format!("warning: frames of sensor `{name}` were not written: {error}"));
        }
        if missing > 0 {
            complain(&format!("warning: {missing} frames of sensor `{name}` were dropped"));
        }
        if self.misfits > 0 {
            let (misfits, what) =
                (self.misfits, "are larger than their slots, or have not the size that they say");
            complain(&format!("warning: {misfits} frames of sensor `{name}` were refused: they {what}"));
        }
    }
}

/// Writes what comes until nothing comes any more. After a failure it only gives slots back.
fn write_all(
    mut sink: Box<dyn FrameSink>,
    comes: &Receiver<Frame>,
    gives_back: &SyncSender<Frame>,
) -> Written {
    let (mut failed, mut unwritten) = (None, 0);
    // The channel ends with its sensor.
    for frame in comes {
        if failed.is_none() {
            failed = sink.write(&frame).err();
        }
        unwritten += u64::from(failed.is_some());
        // There is room for every slot.
        let _ = gives_back.try_send(frame);
    }
    Written { sink, failed, unwritten }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Sender, channel};

    /// Writes after it was allowed to.
    struct Slow {
        allowed: Receiver<()>,
        told: Sender<String>,
    }

    impl FrameSink for Slow {
        fn write(&mut self, frame: &Frame) -> io::Result<()> {
            let _ = self.allowed.recv();
            let samples: Vec<f32> = frame.samples().collect();
            let _ =
                self.told.send(format!("{} {:?} {:?} {samples:?}", frame.step, frame.content, frame.bytes()));
            if frame.step == 7 { Err(io::Error::other("full")) } else { Ok(()) }
        }
        fn finish(&mut self, dropped: u64) -> io::Result<()> {
            let _ = self.told.send(format!("{dropped} dropped"));
            Ok(())
        }
    }

    fn frames(slots: usize) -> (Frames, Sender<()>, Receiver<String>) {
        let (allow, allowed) = channel();
        let (told, tells) = channel();
        let mut frames = Frames::new(slots, 8);
        frames.write_to("camera", false, Box::new(Slow { allowed, told })).expect("a thread");
        (frames, allow, tells)
    }

    #[test]
    fn a_writer_that_lags_delays_nobody_and_what_finds_no_slot_is_dropped_and_counted() {
        let (mut frames, allow, tells) = frames(3);
        for step in 0..10 {
            frames.image(step, (2, 1), 1, &[1, 2]);
        }
        (0..3).for_each(|_| allow.send(()).expect("it waits"));
        drop(frames);
        let told: Vec<String> = tells.iter().collect();
        assert_eq!(told.len(), 4, "{told:?}");
        assert!(
            told[0].starts_with("0 Image { width: 2, height: 1, channels: 1, depth: 1 } [1, 2] []"),
            "{told:?}"
        );
        assert_eq!(told[3], "7 dropped");
    }

    #[test]
    fn frames_keep_their_values_and_those_of_a_wrong_size_are_refused() {
        let (mut frames, allow, tells) = frames(8);
        frames.image_u16(1, (1, 2), 2, &[0x0102, 3, 4, 0xffff]);
        frames.echo(2, 1e-6, &[0.5, -2.0]);
        // Three pixels for four, five channels, larger than a slot, no samples.
        frames.image(3, (2, 2), 1, &[0; 3]);
        frames.image(3, (1, 1), 5, &[0; 5]);
        frames.image(3, (3, 3), 1, &[0; 9]);
        frames.echo(3, 1e-6, &[]);
        frames.echo(3, f64::NAN, &[1.0]);
        (0..2).for_each(|_| allow.send(()).expect("it waits"));
        assert_eq!(frames.queue.as_ref().map(|queue| (queue.dropped, queue.misfits)), Some((0, 5)));
        drop(frames);
        let told: Vec<String> = tells.iter().collect();
        assert_eq!(
            told[0],
            "1 Image { width: 1, height: 2, channels: 2, depth: 2 } [1, 2, 0, 3, 0, 4, 255, 255] []"
        );
        assert!(
            told[1].starts_with("2 Echo { interval: 1e-6 }") && told[1].ends_with("[0.5, -2.0]"),
            "{told:?}"
        );
        assert_eq!(told[2..], ["0 dropped"]);
    }

    #[test]
    fn after_a_failure_the_rest_counts_as_dropped() {
        let (mut frames, allow, tells) = frames(8);
        (6..10).for_each(|step| frames.image(step, (1, 1), 1, &[0]));
        (0..4).for_each(|_| allow.send(()).expect("it waits"));
        drop(frames);
        let told: Vec<String> = tells.iter().collect();
        assert_eq!((told.len(), told[2].as_str()), (3, "3 dropped"), "{told:?}");
    }
}
