//! Reliefs without a cell: parts that lie anywhere on a belt pass below the matrix at any speed. What a network learns from, and is examined by.

use core::f64::consts::PI;
use std::fmt::Write as _;

use mrroc::random::Noise;
use mrroc_sensors::aggregation::{Classifier, Deaf, HeardObject, Hearing, RELIEF_FEATURES, Relief, Reliefs};
use mrroc_sensors::physics::Sounders;
use mrroc_sensors::ultrasound::Air;

use super::layout::{LIMITS, MATRIX, array};
use crate::camera::kinds::{Kind, classes, kinds, strangers, turned};
use crate::camera::layout::ACROSS;
use crate::camera::studio::{Lying, Passing, TOLERANCE};

/// A thing that passed, and what was made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its kind; `None` of a stranger.
    pub kind: Option<usize>,
    /// What was made of it; `None` of what was not noticed.
    pub heard: Option<HeardObject>,
    /// How far its place was off, along and across \[m\].
    pub off: [f64; 2],
    /// How far its angle was off \[rad\].
    pub turned: f64,
}

/// What is made difficult.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Temperatures of the air \[°C\].
    pub celsius: [f64; 2],
    /// By how much it changes between the bare belt and the part, at most \[K\].
    pub change: f64,
    /// Shares of echoes that are lost, 0 to 1.
    pub lost: [f64; 2],
    /// Speeds of the belt [m/s].
    pub speed: [f64; 2],
    /// Every so many a stranger, if that is not 0.
    pub stranger: usize,
}

impl Conditions {
    /// A quiet room.
    pub const USUAL: Self =
        Self { celsius: [18.0, 22.0], change: 0.0, lost: [0.0, 0.0], speed: [0.08, 0.12], stranger: 0 };
    /// A tenth of the echoes is lost, and the air is up to 5 K warmer or colder than when the bare belt was learned.
    pub const HARD: Self =
        Self { celsius: [15.0, 25.0], change: 5.0, lost: [0.1, 0.1], speed: [0.08, 0.12], stranger: 0 };
    /// To learn from: everything up to that, and a little more.
    pub const ALL: Self =
        Self { celsius: [15.0, 25.0], change: 5.0, lost: [0.0, 0.12], speed: [0.04, 0.16], stranger: 0 };
}

/// How long the belt is bare before a part comes below the matrix, and how far it runs until it has passed \[s, m\].
const BARE: f64 = 0.7;
const PASSING: f64 = 0.44;
/// Parts that pass one matrix, before another is taken.
const SAME: usize = 12;

/// Lets `count` things pass below the matrix, as `seed` draws them.
///
/// # Errors
/// [`Deaf`]: none, as long as conditions are such that it hears.
pub fn examine(
    count: usize,
    seed: u64,
    conditions: &Conditions,
    classifier: Box<dyn Classifier>,
    mut show: impl FnMut(&Lying, &Relief, &HeardObject),
) -> Result<Vec<Trial>, Deaf> {
    let mut random = Noise::seeded(seed);
    let (kinds, strangers) = (kinds(), strangers());
    let array = array();
    let mut hearing = Hearing::new(&array, classes(), classifier).with_limits(&LIMITS);
    let mut trials = Vec::new();
    let mut sounders = None;
    while trials.len() < count {
        if trials.len().is_multiple_of(SAME) {
            let [least, most] = conditions.lost;
            let celsius = random.between(conditions.celsius[0], conditions.celsius[1]);
            let seed = (random.uniform() * 1e15) as u64;
            let lost = random.between(least, most);
            sounders = Some((celsius, Sounders::over(&array, Air { celsius }, seed).losing(lost)));
        }
        let Some((celsius, sounders)) = &mut sounders else { break };
        let strange = conditions.stranger > 0 && trials.len().is_multiple_of(conditions.stranger);
        let speed = random.between(conditions.speed[0], conditions.speed[1]);
        let mut passing = one(strange, &kinds, &strangers, speed, &mut random);
        let truly = passing.parts[0].pose.translation.vector.xy();
        if conditions.change > 0.0 {
            let other = Air { celsius: *celsius + random.between(-conditions.change, conditions.change) };
            sounders.warm(BARE, other);
        }
        let mut reliefs = Reliefs::by(array.clone());
        let mut evaluated = None;
        for ping in 1_u32.. {
            passing.now = f64::from(ping) * array.period;
            passing.run = speed * passing.now;
            passing.parts[0].pose.translation.vector.x = truly.x + passing.run;
            let number = array.turn(ping.into());
            let echo = sounders.ping(&passing, number, passing.now);
            reliefs.take(number, echo, passing.run)?;
            if let Some(relief) = reliefs.passed(passing.run) {
                let heard = hearing.evaluate(&relief);
                // As it lay where the belt had run 0.
                passing.parts[0].pose.translation.vector.x = truly.x;
                show(&passing.parts[0], &relief, &heard);
                evaluated = Some(heard);
                break;
            }
            if passing.run > BARE * speed + PASSING {
                break;
            }
        }
        if conditions.change > 0.0 {
            sounders.warm(0.0, Air { celsius: *celsius });
        }
        let part = &passing.parts[0];
        let off = evaluated
            .as_ref()
            .map_or([0.0; 2], |heard: &HeardObject| [heard.place.x - truly.x, heard.place.y - truly.y]);
        let turns = part.kind.map_or(0, |kind| kinds[kind].class.turns);
        let turned = evaluated.as_ref().map_or(0.0, |heard| turned(heard.angle, part.angle, turns));
        trials.push(Trial { kind: part.kind, heard: evaluated, off, turned });
    }
    Ok(trials)
}

/// A thing on the belt, before the matrix.
fn one(strange: bool, kinds: &[Kind], strangers: &[Kind], speed: f64, random: &mut Noise) -> Passing {
    let pick = |count: usize, random: &mut Noise| ((random.uniform() * count as f64) as usize).min(count - 1);
    let kind = (!strange).then(|| pick(kinds.len(), random));
    let scale = 1.0 + random.between(-TOLERANCE, TOLERANCE);
    let form = match kind {
        Some(kind) => kinds[kind].class.form.scaled(scale),
        None => strangers[pick(strangers.len(), random)].class.form.scaled(scale),
    };
    let x = MATRIX[0] - BARE * speed - 0.16 + random.between(-0.01, 0.01);
    let part = Lying::of(kind, form, [x, random.between(-ACROSS, ACROSS)], random.between(-PI, PI), 0.5);
    Passing { parts: vec![part], speed, run: 0.0, now: 0.0 }
}

/// A table to train by: the kind, and the features, of so many parts.
///
/// # Errors
/// As [`examine`].
pub fn data_set(count: usize, seed: u64, classifier: Box<dyn Classifier>) -> Result<String, Deaf> {
    let trials = examine(count, seed, &Conditions::ALL, classifier, |_, _, _| ())?;
    let mut table = String::new();
    for (trial, heard) in trials.iter().filter_map(|trial| Some((trial, trial.heard.as_ref()?))) {
        let features: &[f32; RELIEF_FEATURES] = &heard.features;
        let _ = write!(table, "{}", trial.kind.unwrap_or_default());
        features.iter().for_each(|feature| {
            let _ = write!(table, ",{feature:.5}");
        });
        table.push('\n');
    }
    Ok(table)
}
