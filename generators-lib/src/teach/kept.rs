//! A file into which poses are written as they are taught.
//!
//! In: poses, in the steps in which a person records them. Out: the file, written by a thread. A step leaves its pose in memory
//! that was set aside, and waits for nothing; whatever stops the motion, what was recorded before is in the file.

use std::fs::{self, OpenOptions};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use mrroc::console::complain;
use mrroc::files::replace;
use mrroc::payload::Wire;
use mrroc::pose::Pose;

use super::{Reference, Space, Taught, TaughtPose};

/// How often the thread looks for poses.
const LOOK: Duration = Duration::from_millis(20);

/// A file of taught poses that grows as poses are recorded: for [`Jog::kept_in`](crate::generators::Jog::kept_in).
///
/// Dropping it waits until all of them are written, and complains where that fails; [`finish`](TaughtFile::finish) says so.
///
/// ```
/// use mrroc_generators::teach::{Taught, TaughtFile};
///
/// # let folder = std::env::temp_dir().join(format!("mrroc-taught-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// let path = folder.join("taught.txt");
/// // To be replayed with half of the largest velocity and acceleration; at most 100 poses.
/// let kept = TaughtFile::begin(&path, 0.5, 0.5, 100)?;
/// // .. `Jog::by(..).kept_in(&kept)` ..
/// kept.finish()?;
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct TaughtFile {
    room: Arc<Room>,
    writer: Option<JoinHandle<io::Result<()>>>,
}

/// Memory for poses, which one step after another fills and the thread reads.
#[derive(Debug)]
struct Room {
    poses: Box<[[AtomicU64; Pose::LEN]]>,
    count: AtomicUsize,
    closes: AtomicBool,
}

impl Room {
    /// Leaves a pose there; whether there was room for it.
    fn record(&self, pose: &Pose) -> bool {
        let count = self.count.load(Ordering::Relaxed);
        let Some(place) = self.poses.get(count) else { return false };
        let mut words = [0; Pose::LEN];
        pose.put(&mut words);
        place.iter().zip(words).for_each(|(place, word)| place.store(word, Ordering::Relaxed));
        self.count.store(count + 1, Ordering::Release);
        true
    }

    fn pose(&self, index: usize) -> Option<Pose> {
        let words = self.poses[index].each_ref().map(|word| word.load(Ordering::Relaxed));
        Pose::get(&words).ok()
    }
}

/// The side of a [`TaughtFile`] on which steps record poses.
#[derive(Debug)]
pub struct Kept(Arc<Room>);

impl Kept {
    /// Leaves a pose `X_WE` for the file, without waiting; whether there was room for it.
    #[must_use]
    pub fn record(&self, pose: &Pose) -> bool {
        self.0.record(pose)
    }
}

impl TaughtFile {
    /// A file that is written anew when the first pose is recorded: until then what is in it stays. Its poses are to be replayed
    /// with these shares of velocity and acceleration, each > 0 and at most 1. There is room for `most` poses.
    ///
    /// # Errors
    /// The file cannot be written, a share is none, or there is no thread.
    pub fn begin(
        file: impl Into<PathBuf>,
        velocity: f64,
        acceleration: f64,
        most: usize,
    ) -> io::Result<Self> {
        let empty = Taught { space: Space::AngleAxis, reference: Reference::Absolute, poses: Vec::new() };
        TaughtFile::open(file.into(), empty, (velocity, acceleration), most)
    }

    /// A file to which `most` poses may be added: after a fault, say.
    ///
    /// # Errors
    /// As of [`begin`](TaughtFile::begin); or the file cannot be read, or has other poses than those of a tool in the world by
    /// angle and axis, which is how they are recorded.
    pub fn go_on(
        file: impl Into<PathBuf>,
        velocity: f64,
        acceleration: f64,
        most: usize,
    ) -> io::Result<Self> {
        let file = file.into();
        let bad =
            |why: String| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {why}", file.display()));
        let taught: Taught = fs::read_to_string(&file)?.parse().map_err(|why| bad(format!("{why}")))?;
        if (taught.space, taught.reference) != (Space::AngleAxis, Reference::Absolute) {
            return Err(bad(
                "poses can be added to `space angle-axis` and `reference absolute` alone".to_owned()
            ));
        }
        TaughtFile::open(file, taught, (velocity, acceleration), most)
    }

    fn open(file: PathBuf, mut taught: Taught, shares: (f64, f64), most: usize) -> io::Result<Self> {
        if TaughtPose::of_pose(shares.0, shares.1, &Pose::identity()).is_none() {
            let text = format!("the shares {} and {} must be above 0 and up to 1", shares.0, shares.1);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        OpenOptions::new().append(true).create(true).open(&file)?;
        let poses = (0..most).map(|_| Default::default()).collect();
        let room = Arc::new(Room { poses, count: AtomicUsize::new(0), closes: AtomicBool::new(false) });
        let seen = Arc::clone(&room);
        let writer = thread::Builder::new().name("taught".to_owned()).spawn(move || {
            let mut written = 0;
            loop {
                // Before the poses are counted: none is recorded after it.
                let closes = seen.closes.load(Ordering::Acquire);
                let count = seen.count.load(Ordering::Acquire);
                if count > written {
                    let new = (written..count).filter_map(|index| seen.pose(index));
                    taught
                        .poses
                        .extend(new.filter_map(|pose| TaughtPose::of_pose(shares.0, shares.1, &pose)));
                    replace(&file, &taught.to_string())?;
                    written = count;
                } else if closes {
                    return Ok(());
                } else {
                    thread::park_timeout(LOOK);
                }
            }
        })?;
        Ok(TaughtFile { room, writer: Some(writer) })
    }

    /// What a generator keeps poses with, one generator at a time.
    #[must_use]
    pub fn kept(&self) -> Kept {
        Kept(Arc::clone(&self.room))
    }

    /// Waits until all poses are written that were recorded.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.close()
    }

    fn close(&mut self) -> io::Result<()> {
        let Some(writer) = self.writer.take() else { return Ok(()) };
        self.room.closes.store(true, Ordering::Release);
        writer.thread().unpark();
        writer.join().unwrap_or_else(|_| Err(io::Error::other("the thread that writes has panicked")))
    }
}

impl Drop for TaughtFile {
    fn drop(&mut self) {
        if let Err(error) = self.close() {
            complain(&format!("error: taught poses cannot be written: {error}"));
        }
    }
}
