//! Parts in reliefs: which class, where, and at which angle.
//!
//! ```text
//! relief -> features that do not turn -> a class by a classifier
//!        -> place and angle: those at which the class's form would have sent back what was heard
//! ```
//!
//! What a transducer that looks straight down hears of a form depends on where it is above that, not on how that is turned. So each class has one
//! map: for each place how likely each height is to be heard there, by the same sum over surfaces that real echoes are, and noise. A relief
//! is laid onto it where it is likeliest. A thing that is unlikely everywhere is none of the known parts.

use core::cell::OnceCell;
use core::f64::consts::{PI, TAU};

use mrroc::pose::Pose;
use mrroc::random::Noise;
use nalgebra::{Rotation2, Vector2, Vector3};

use super::relief::{Relief, Sample};
use super::relief_features::{RELIEF_FEATURES, relief_features};
use super::vision::{Classifier, PartClass};
use crate::form::Form;
use crate::ultrasound::{Air, Array, Waveform};

/// What is so high is no belt \[m\].
const RAISED: f64 = 0.008;

/// A thing that passed.
#[derive(Clone, Debug, PartialEq)]
pub struct HeardObject {
    /// Its class; `None` of something unknown.
    pub class: Option<usize>,
    /// How likely the likeliest class is, 0 to 1.
    pub score: f64,
    /// How much less likely its heights are than is usual for the class: natural logarithm, mean over the places that stand out of the
    /// belt; infinite where there was nothing to compare.
    pub misfit: f64,
    /// Where its frame P is on the belt, where that had run 0 \[m\].
    pub place: Vector2<f64>,
    /// Angle of x of P from x of F \[rad\].
    pub angle: f64,
    /// What it was told by.
    pub features: [f32; RELIEF_FEATURES],
}

/// What is heard above a form, on a grid of its frame P.
#[derive(Clone, Debug)]
struct Map {
    /// Lower corner of the grid \[m, P\], and its columns and rows.
    lower: Vector2<f64>,
    columns: usize,
    rows: usize,
    /// Of each place: how likely each height is, if something is heard; at last the place outside of the map, the bare belt.
    likely: Vec<[f32; Map::HEIGHTS]>,
    /// The mean of the logarithms of that, of what is heard there.
    usual: Vec<f32>,
    /// How loud the bare belt and what stands out of it are there in the mean; NaN where they are not heard.
    loud: Vec<[f32; 2]>,
    /// The middle of what stands out of the belt \[m, P\].
    centre: Vector2<f64>,
}

/// What a map says of something heard at a place.
struct At {
    /// Logarithm of how likely it is, and the mean of that there.
    likely: f32,
    usual: f32,
    /// Whether something stands out of the belt there at times.
    is_raised: bool,
}

/// Tells parts by reliefs.
pub struct Hearing {
    classes: Vec<PartClass>,
    maps: Vec<OnceCell<Map>>,
    limits: Vec<f64>,
    array: Array,
    classifier: Box<dyn Classifier>,
}

impl core::fmt::Debug for Hearing {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Hearing").field("classes", &self.classes).finish_non_exhaustive()
    }
}

impl Map {
    /// Distance of its places \[m\], and how far it goes beyond the form \[m\].
    const STEP: f64 = 0.004;
    const BEYOND: f64 = 0.036;
    /// A ray for every three millimetres.
    const COARSE: f64 = 0.012;
    /// Heights in steps of a millimetre, from this one on \[m\].
    const HEIGHTS: usize = 72;
    const LOWEST: f64 = -0.012;
    const WIDE: f64 = 1e-3;
    /// So many pings make a place.
    const PINGS: usize = 32;
    /// How likely it is that a height is any other one.
    const STRAY: f64 = 0.05;
    /// Standard deviation of heights besides noise \[m\]: sizes of parts, transducers, the belt's own height.
    const BLUR: f64 = 1e-3;
    /// What the places beside one add to it, each.
    const BESIDE: f32 = 0.1;
    /// Standard deviation of loudness, and the greatest and the usual penalty for it.
    const LOUD: [f32; 3] = [0.07, 3.0, 0.2];

    fn of(form: &Form, array: &Array) -> Self {
        let transducer = array.transducer(Air { celsius: 20.0 });
        let height = array.places.first().map_or(0.25, |place| place.z);
        let over = Array { places: Vec::new(), half_width: f64::INFINITY, ..array.clone() };
        let bare = over.belt(&transducer, &Vector3::new(0.0, 0.0, height));
        let (mut random, deviation) = (Noise::seeded(1), array.noise(&transducer));
        let mut noise = || {
            let mut wave = transducer.silence();
            wave.disturb(|| random.normals().map(|x| x * deviation));
            let _ = transducer.hear(&mut wave, 1.0);
            wave
        };
        let noises: Vec<Waveform> = (0..Self::PINGS).map(|_| noise()).collect();
        let corners: Vec<_> = form.corners().map(|corner| corner.xy()).collect();
        let around = Vector2::repeat(Self::BEYOND);
        let lower = corners.iter().fold(Vector2::repeat(f64::INFINITY), |a, b| a.inf(b)) - around;
        let upper = corners.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |a, b| a.sup(b)) + around;
        let count = |size: f64| (size / Self::STEP).ceil() as usize + 1;
        let (columns, rows) = (count(upper.x - lower.x), count(upper.y - lower.y));
        let mut map = Self {
            lower,
            columns,
            rows,
            likely: Vec::with_capacity(columns * rows + 1),
            usual: Vec::with_capacity(columns * rows + 1),
            loud: Vec::with_capacity(columns * rows + 1),
            centre: Vector2::zeros(),
        };
        let (mut wave, mut heard) = (bare.clone(), bare.clone());
        let belt = transducer.hear(&mut wave, 1.0).map_or(1.0, |echo| echo.amplitude);
        let mut raised = 0.0;
        for index in 0..=columns * rows {
            let at = lower + Vector2::new((index % columns) as f64, (index / columns) as f64) * Self::STEP;
            wave.start_from(&bare);
            if index < columns * rows {
                let place = Vector3::new(at.x, at.y, height);
                over.add(&transducer, &mut wave, &place, (form, &Pose::identity()), Self::COARSE, |_, _| {
                    false
                });
            }
            let _ = transducer.hear(&mut wave, 1.0);
            let heights = noises.iter().filter_map(|noise| {
                heard.join(&wave, noise);
                let echo = transducer.detect(&heard, 1.0)?;
                let z = height - 0.5 * transducer.air().speed() * transducer.middle(&echo);
                Some([z, echo.amplitude / belt])
            });
            let heights: Vec<[f64; 2]> = heights.collect();
            let above = heights.iter().filter(|[z, _]| *z > RAISED).count() as f64;
            map.centre += at * above;
            raised += above;
            map.add(&heights);
        }
        map.blur();
        map.centre /= f64::max(raised, 1.0);
        map
    }

    /// Adds a place at which these heights were heard, so loud.
    fn add(&mut self, heights: &[[f64; 2]]) {
        let mut likely = [Self::STRAY / Self::HEIGHTS as f64; Self::HEIGHTS];
        let share = (1.0 - Self::STRAY) / heights.len().max(1) as f64;
        for [z, _] in heights {
            let bell = |bin: usize| {
                let off = (Self::LOWEST + (bin as f64 + 0.5) * Self::WIDE - z) / Self::BLUR;
                (-0.5 * off * off).exp()
            };
            let bells: [f64; Self::HEIGHTS] = core::array::from_fn(bell);
            let sum: f64 = bells.iter().sum();
            let bins = likely.iter_mut().zip(bells);
            bins.for_each(|(likely, bell)| *likely += share * bell / f64::max(sum, 1e-9));
        }
        self.likely.push(likely.map(|p| p as f32));
        let mean = |is_raised: bool| {
            let of = heights.iter().filter(|[z, _]| (*z > RAISED) == is_raised).map(|[_, loud]| loud);
            (of.clone().sum::<f64>() / of.count() as f64) as f32
        };
        self.loud.push([mean(false), mean(true)]);
    }

    /// Adds to each place what is beside it, as transducers and parts are never quite where they are believed to be.
    fn blur(&mut self) {
        let sharp = self.likely.clone();
        for row in 1..self.rows.saturating_sub(1) {
            for column in 1..self.columns.saturating_sub(1) {
                let index = row * self.columns + column;
                let beside = [index - 1, index + 1, index - self.columns, index + self.columns];
                for (bin, likely) in self.likely[index].iter_mut().enumerate() {
                    let others: f32 = beside.iter().map(|other| sharp[*other][bin]).sum();
                    *likely = (1.0 - 4.0 * Self::BESIDE) * sharp[index][bin] + Self::BESIDE * others;
                }
            }
        }
        let usual = |likely: &[f32; Self::HEIGHTS]| {
            likely.iter().map(|p| p * p.ln()).sum::<f32>() / likely.iter().sum::<f32>()
        };
        self.usual = self.likely.iter().map(usual).collect();
    }

    /// What is known of a height and its loudness at a place of P.
    fn at(&self, place: &Vector2<f64>, [height, loud]: [f64; 2]) -> At {
        let bin = ((height - Self::LOWEST) / Self::WIDE).clamp(0.0, Self::HEIGHTS as f64 - 1.0) as usize;
        let last = self.columns * self.rows;
        let at = (place - self.lower) / Self::STEP;
        let (column, row) = (at.x.max(0.0) as usize, at.y.max(0.0) as usize);
        if at.x < 0.0 || at.y < 0.0 || column + 1 >= self.columns || row + 1 >= self.rows {
            let likely = self.likely[last][bin].ln() - Self::penalty(loud as f32 - 1.0);
            return At { likely, usual: self.usual[last] - Self::LOUD[2], is_raised: false };
        }
        let index = row * self.columns + column;
        let (x, y) = (at.x.fract() as f32, at.y.fract() as f32);
        let corners = [
            (index, (1.0 - x) * (1.0 - y)),
            (index + 1, x * (1.0 - y)),
            (index + self.columns, (1.0 - x) * y),
            (index + self.columns + 1, x * y),
        ];
        let (mut likely, mut usual, mut mean, mut known, mut raised) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let which = usize::from(height > RAISED);
        for (index, share) in corners {
            likely += share * self.likely[index][bin];
            usual += share * self.usual[index];
            let loud = self.loud[index][which];
            raised += if self.loud[index][1].is_finite() { share } else { 0.0 };
            if loud.is_finite() {
                mean += share * loud;
                known += share;
            }
        }
        let penalty = if known > 0.0 { Self::penalty(loud as f32 - mean / known) } else { Self::LOUD[2] };
        At { likely: likely.ln() - penalty, usual: usual - Self::LOUD[2], is_raised: raised > 0.5 }
    }

    /// For a loudness that is off: half of a square in the mean.
    fn penalty(off: f32) -> f32 {
        (0.5 * (off / Self::LOUD[0]).powi(2)).min(Self::LOUD[1])
    }
}

impl Hearing {
    /// The classifier is believed from this score on ..
    pub const SCORE: f64 = 0.7;
    /// .. and its class up to this misfit, if no other limit is given.
    pub const MISFIT: f64 = 1.2;
    /// Angles that are tried in a turn, and how many of them are followed.
    const ANGLES: usize = 48;
    const FOLLOWED: usize = 4;

    /// By an array that looks at a belt like this, for these classes.
    #[must_use]
    pub fn new(array: &Array, classes: Vec<PartClass>, classifier: Box<dyn Classifier>) -> Self {
        let maps = classes.iter().map(|_| OnceCell::new()).collect();
        let limits = vec![Self::MISFIT; classes.len()];
        Self { classes, maps, limits, array: array.clone(), classifier }
    }

    /// The same, with a limit of the misfit for each class, in their order: what true parts of that class hardly ever have.
    #[must_use]
    pub fn with_limits(mut self, limits: &[f64]) -> Self {
        self.limits.iter_mut().zip(limits).for_each(|(of, limit)| *of = *limit);
        self
    }

    /// The classes.
    #[must_use]
    pub fn classes(&self) -> &[PartClass] {
        &self.classes
    }

    fn map(&self, class: usize) -> &Map {
        self.maps[class].get_or_init(|| Map::of(&self.classes[class].form, &self.array))
    }

    /// How unlikely a relief is of a class at a place and an angle, as a sum of logarithms: what [`lay`](Self::lay) makes least.
    #[must_use]
    pub fn unlikely_at(&self, class: usize, relief: &Relief, place: &Vector2<f64>, angle: f64) -> f64 {
        Self::unlikely(self.map(class), &relief.samples, place, angle)[0]
    }

    /// What a relief is of.
    pub fn evaluate(&mut self, relief: &Relief) -> HeardObject {
        let features = relief_features(relief);
        let scores = self.classifier.classify(&features).unwrap_or_default();
        let best = scores.iter().copied().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((class, score)) = best.filter(|(class, _)| *class < self.classes.len()) else {
            let (place, angle, misfit) = (Vector2::zeros(), 0.0, f64::INFINITY);
            return HeardObject { class: None, score: 0.0, misfit, place, angle, features };
        };
        let (misfit, place, angle) = self.lay(class, relief);
        let score = f64::from(score);
        let known = score >= Self::SCORE && misfit <= self.limits[class];
        HeardObject { class: known.then_some(class), score, misfit, place, angle, features }
    }

    /// Lays a relief onto the map of a class: the least misfit, the place and the angle.
    #[must_use]
    pub fn lay(&self, class: usize, relief: &Relief) -> (f64, Vector2<f64>, f64) {
        let (map, turns) = (self.map(class), self.classes[class].turns);
        let raised = relief.samples.iter().filter(|sample| sample.heard.is_some_and(|[z, _]| z > RAISED));
        let (mut sum, mut count) = (Vector2::zeros(), 0.0);
        for sample in raised {
            sum += Vector2::new(sample.along, sample.across);
            count += 1.0;
        }
        let middle = sum / f64::max(count, 1.0);
        let unlikely =
            |place: &Vector2<f64>, angle: f64| Self::unlikely(map, &relief.samples, place, angle)[0];
        let (tried, period) = match turns {
            0 => (1, TAU),
            turns => (Self::ANGLES / turns as usize, TAU / f64::from(turns)),
        };
        let mut starts: Vec<(f64, Vector2<f64>, f64)> = (0..tried)
            .map(|i| {
                let angle = period * i as f64 / tried as f64;
                let place = middle - Rotation2::new(angle) * map.centre;
                (unlikely(&place, angle), place, angle)
            })
            .collect();
        starts.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(Self::FOLLOWED);
        let followed = starts.into_iter().map(|start| descend(start, turns > 0, unlikely));
        let (_, place, angle) =
            followed.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, middle, 0.0));
        let [_, excess, places] = Self::unlikely(map, &relief.samples, &place, angle);
        let misfit = if places > 0.0 { excess / places } else { f64::INFINITY };
        (misfit, place, angle - period * (angle / period).round())
    }

    /// How unlikely what was heard is there, as a sum of logarithms; by how much more unlikely than usually it is where something stands out
    /// of the belt, or should; and at how many places that is. What was lost says nothing.
    fn unlikely(map: &Map, samples: &[Sample], place: &Vector2<f64>, angle: f64) -> [f64; 3] {
        let turn = Rotation2::new(-angle);
        let mut sums = [0.0; 3];
        for sample in samples {
            let Some(heard) = sample.heard else { continue };
            let at = turn * (Vector2::new(sample.along, sample.across) - place);
            let At { likely, usual, is_raised } = map.at(&at, heard);
            sums[0] -= f64::from(likely);
            if is_raised || heard[0] > RAISED {
                sums[1] += f64::from(usual - likely);
                sums[2] += 1.0;
            }
        }
        sums
    }
}

/// Goes down in ever smaller steps.
fn descend(
    start: (f64, Vector2<f64>, f64),
    turns: bool,
    unlikely: impl Fn(&Vector2<f64>, f64) -> f64,
) -> (f64, Vector2<f64>, f64) {
    let (mut best, mut step, mut turn) = (start, 4e-3, PI / 32.0);
    while step > 1e-4 {
        let shift = |x: f64, y: f64| (Vector2::new(x, y) * step, 0.0);
        let mut tries = vec![shift(1.0, 0.0), shift(-1.0, 0.0), shift(0.0, 1.0), shift(0.0, -1.0)];
        if turns {
            tries.extend([(Vector2::zeros(), turn), (Vector2::zeros(), -turn)]);
        }
        let next = tries
            .into_iter()
            .map(|(shift, by)| (best.1 + shift, best.2 + by))
            .map(|(place, angle)| (unlikely(&place, angle), place, angle))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match next {
            Some(next) if next.0 < best.0 => best = next,
            _ => (step, turn) = (0.5 * step, 0.5 * turn),
        }
    }
    best
}
