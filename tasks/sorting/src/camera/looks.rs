//! What was found in images and reliefs, and how far off it is.

use mrroc_robots::grasp::World;
use mrroc_sensors::aggregation::{DetectedObject, HeardObject, Relief};
use mrroc_sensors::ultrasound::Echo;

use super::arrivals::{Coming, angle};
use super::kinds::turned;

/// What came of the images, or reliefs.
#[derive(Default)]
pub struct Looks {
    /// Things that were found, and what they truly were.
    pub all: Vec<Look>,
    /// The first images, and what was found in them.
    pub images: Vec<(Vec<u8>, Vec<DetectedObject>)>,
    /// The first reliefs, and what was made of them.
    pub reliefs: Vec<(Relief, HeardObject)>,
    /// What one transducer heard while the first part passed.
    pub traces: Vec<Trace>,
    /// So many images or reliefs are kept.
    pub keep: usize,
}

/// A thing that was found in an image or a relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Which part it was.
    pub part: usize,
    /// As which kind it was taken.
    pub taken: Option<usize>,
    /// How far its place in the belt's frame was off, along and across \[m\].
    pub off: [f64; 2],
    /// How far its angle was off \[rad\].
    pub turned: f64,
}

/// What a transducer heard after one ping.
#[derive(Clone, Debug)]
pub struct Trace {
    /// \[s\].
    pub time: f64,
    /// The pressure over the range, as [`Waveform`](mrroc_sensors::ultrasound::Waveform) has it.
    pub heard: Vec<f64>,
    /// Its first echo.
    pub echo: Option<Echo>,
}

/// The part that is nearest to a place on a belt that has truly run `run` \[m\], and how far what was told of it is off. A part on a belt that
/// runs evenly keeps its place in the belt's frame.
pub fn nearest(
    world: &World,
    parts: &[Coming],
    turns: &[u32],
    run: f64,
    taken: Option<usize>,
    place: [f64; 2],
    told: f64,
) -> Option<Look> {
    let mut nearest: Option<(f64, Look)> = None;
    world.each_body(|number, state| {
        let part = &parts[number];
        let truly = part.place(&state.pose);
        let along = place[0] - (truly.translation.x - run);
        let across = place[1] - truly.translation.y;
        let turned = turned(told, angle(&truly), turns.get(part.kind).copied().unwrap_or(0));
        let look = Look { part: number, taken, off: [along, across], turned };
        let distance = along.hypot(across);
        if nearest.is_none_or(|(least, _)| distance < least) {
            nearest = Some((distance, look));
        }
    });
    nearest.map(|(_, look)| look)
}
