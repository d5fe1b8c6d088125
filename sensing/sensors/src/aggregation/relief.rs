//! What passes below ultrasonic transducers, as a relief: a height for each ping, at its place on the belt.
//!
//! ```text
//! echo -> its middle, without the threshold's walk -> height = h (1 - t / t of the belt)        the speed of sound goes out of it
//!      -> place of the transducer - travel of the belt at the ping                                 in the belt's own frame
//!      -> things: places that stand out of the belt, with a strip of bare belt before and behind
//! ```
//!
//! Noise lets some pings of the bare belt hear something higher. So a strip is bare where few of its pings do, not where none does: the slower
//! the belt, the more pings are in it.
//!
//! Each transducer hears the belt between parts, and so knows what its temperature, its height and its loudness are now.

use std::collections::VecDeque;

use crate::ultrasound::{Air, Array, Echo, Transducer};
use thiserror::Error;

/// What a ping said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Where its transducer was along the belt, where that had run 0 \[m\] ..
    pub along: f64,
    /// .. and across it \[m\].
    pub across: f64,
    /// How high what it met is over the belt \[m\], and how loud, of what the bare belt is; `None` where nothing was heard.
    pub heard: Option<[f64; 2]>,
}

/// The samples of a thing, and of the belt about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Relief {
    /// Those.
    pub samples: Vec<Sample>,
    /// How much of the belt each stands for \[m²\].
    pub area: f64,
}

/// Why nothing can be heard.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Deaf {
    /// A transducer hears neither belt nor parts.
    #[error(
        "ultrasonic transducer {number} of {of} heard no echo in {count} pings over {travel_mm:.0} mm of belt: dead, loose or covered?"
    )]
    Transducer {
        /// Which one, from 1 on.
        number: usize,
        /// How many there are.
        of: usize,
        /// So many pings.
        count: u32,
        /// And so much belt \[mm\].
        travel_mm: f64,
    },
    /// What is to be learned as the bare belt is not level.
    #[error(
        "ultrasonic transducer {number} of {of} hears something {off_mm:+.1} mm from where the others hear the belt, at most {limit_mm:.1} mm, while the bare belt is learned: clear the belt below the matrix and begin again"
    )]
    Uneven {
        /// The one that is farthest off, from 1 on.
        number: usize,
        /// How many there are.
        of: usize,
        /// How much higher \[mm\].
        off_mm: f64,
        /// What is allowed \[mm\].
        limit_mm: f64,
    },
    /// The belt is not where it was.
    #[error(
        "the belt is heard {off_mm:+.1} mm from where it was, at most {limit_mm:.1} mm: is the air hot or cold, or has the matrix been moved?"
    )]
    Belt {
        /// How far off \[mm\].
        off_mm: f64,
        /// What is allowed \[mm\].
        limit_mm: f64,
    },
    /// Almost nothing that is heard is the belt.
    #[error(
        "{share_percent:.0} % of the newest pings hear something else than the belt, {off_mm:+.1} mm from where it was in the mean: is the air hot or cold, or has the matrix been moved?"
    )]
    Elsewhere {
        /// Their share.
        share_percent: f64,
        /// How far off in the mean \[mm\].
        off_mm: f64,
    },
}

/// What a transducer hears of the bare belt.
#[derive(Clone, Copy, Debug, Default)]
struct Bare {
    /// Time of the echo's middle \[s\], and its amplitude.
    time: f64,
    amplitude: f64,
    /// Pings by which that was learned, how many of them had an echo, and the first of these: times \[s\] and amplitudes.
    pings: u32,
    count: u32,
    first: [[f64; 2]; Reliefs::LEARNING as usize],
    /// Pings without an echo, and where the belt was at the first of them \[m\].
    unheard: u32,
    from: f64,
    /// Along the belt, where its last sample is \[m\].
    stored: Option<f64>,
}

impl Bare {
    /// Goes by the median of the first echoes: a single one may be of something else.
    fn learn(&mut self) {
        let mut first = self.first;
        let known = &mut first[..self.count as usize];
        known.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (Some(low), Some(high)) =
            (known.get(known.len().saturating_sub(1) / 2), known.get(known.len() / 2))
        else {
            return;
        };
        (self.time, self.amplitude) = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]));
    }
}

/// Makes reliefs of echoes.
#[derive(Clone, Debug)]
pub struct Reliefs {
    array: Array,
    transducer: Transducer,
    bare: Vec<Bare>,
    /// Mean of the times of the bare belt, when it was learned.
    learned: Option<f64>,
    /// Of the newest pings: how many heard something else than the belt, as a share, and the mean of their heights \[m\].
    elsewhere: [f64; 2],
    samples: VecDeque<Sample>,
    /// No sample that stands out of the belt is farther along it than this \[m\].
    raised_to: f64,
    /// The last row of transducers, along the belt \[m\].
    last_row: f64,
    /// The belt before this is done with, along the belt \[m\].
    done: f64,
}

impl Reliefs {
    /// What is so high is no belt \[m\].
    const RAISED: f64 = 0.008;
    /// Things are apart where so much belt is bare between them \[m\] ..
    const APART: f64 = 0.03;
    /// .. of whose pings at most this share hears something higher: noise does that to one ping in 300.
    const STRAY: f64 = 0.03;
    /// So much belt about a thing goes with it \[m\].
    const ABOUT: f64 = 0.02;
    /// What has fewer samples than this is noise.
    const FEWEST: usize = 6;
    /// Pings by which a transducer learns the bare belt. One that has lost more than one of their echoes goes by what the others have
    /// learned, so that learning is over before a part comes; at least so large a share of all must have learned it themselves.
    const LEARNING: u32 = 4;
    const ENOUGH: u32 = 3;
    const LEARNED: f64 = 0.6;
    /// What is learned as the bare belt may be so far from the others' \[m\]: bare belts are learned within 2 mm, and what is 4 mm off is none later on.
    const LEVEL: f64 = 3.5e-3;
    /// A transducer that hears nothing so often, over so much belt \[m\], is dead.
    const DEAF: (u32, f64) = (24, 0.15);
    /// How much of a bare belt's echo changes what is known of it.
    const FOLLOW: f64 = 0.3;
    /// Of the newest pings, and of how many, at most this share may hear something else than the belt: no part is as large as the matrix.
    const ELSEWHERE: (f64, f64) = (0.95, 64.0);
    /// The belt may be heard so far from where it was first \[m\]: 15 K.
    const MOVED: f64 = 6.5e-3;
    /// A transducer's samples are so far apart at least \[m\]: those of a belt that stands are one.
    const SPACED: f64 = 3e-3;
    /// So many samples are kept at most: of 32 transducers over 0.38 m of a belt that is as slow as may be. A thing is heard over 0.21 m, and
    /// has passed when the last of rows that are 0.09 m long is `APART` behind that.
    const KEPT: usize = 4096;

    /// By an array, as it is believed to be.
    #[must_use]
    pub fn by(array: Array) -> Self {
        let transducer = array.transducer(Air { celsius: 20.0 });
        let bare = vec![Bare::default(); array.places.len()];
        let last_row = array.places.iter().map(|place| place.x).fold(f64::NEG_INFINITY, f64::max);
        Self {
            array,
            transducer,
            bare,
            learned: None,
            elsewhere: [0.0; 2],
            samples: VecDeque::new(),
            raised_to: f64::NEG_INFINITY,
            last_row,
            done: f64::INFINITY,
        }
    }

    /// The array, as it is believed to be.
    #[must_use]
    pub const fn array(&self) -> &Array {
        &self.array
    }

    /// Whether it knows the bare belt.
    #[must_use]
    pub const fn is_taught(&self) -> bool {
        self.learned.is_some()
    }

    /// Takes what a transducer heard, when the belt had run `travel` \[m\].
    ///
    /// # Errors
    /// [`Deaf`].
    pub fn take(&mut self, number: usize, echo: Option<Echo>, travel: f64) -> Result<(), Deaf> {
        if echo.is_none() {
            self.count_unheard(number, travel)?;
        }
        let Some(learned) = self.learned else { return self.learn(number, echo) };
        let place = self.array.places[number];
        let bare = &mut self.bare[number];
        let along = place.x - travel;
        let heard = if let Some(echo) = echo {
            bare.unheard = 0;
            bare.count = bare.count.saturating_add(1);
            let middle = self.transducer.middle(&echo);
            let height = place.z * (1.0 - middle / bare.time);
            let loud = echo.amplitude / bare.amplitude;
            let is_belt = height.abs() < 0.5 * Self::RAISED;
            let [share, mean] = &mut self.elsewhere;
            *share += (f64::from(u8::from(!is_belt)) - *share) / Self::ELSEWHERE.1;
            *mean += (height - *mean) / Self::ELSEWHERE.1;
            if *share > Self::ELSEWHERE.0 {
                return Err(Deaf::Elsewhere { share_percent: 1e2 * *share, off_mm: 1e3 * *mean });
            }
            if is_belt && (loud - 1.0).abs() < 0.15 {
                bare.time += Self::FOLLOW * (middle - bare.time);
                bare.amplitude += Self::FOLLOW * (echo.amplitude - bare.amplitude);
            }
            Some([height, loud])
        } else {
            None
        };
        // Warm air brings the belt nearer, and so higher: as much as its echo comes sooner.
        let off = place.z * (1.0 - self.mean() / learned);
        if off.abs() > Self::MOVED {
            return Err(Deaf::Belt { off_mm: 1e3 * off, limit_mm: 1e3 * Self::MOVED });
        }
        let bare = &mut self.bare[number];
        let is_new = bare.stored.is_none_or(|stored| (along - stored).abs() >= Self::SPACED);
        if along < self.done && is_new {
            bare.stored = Some(along);
            let sample = Sample { along, across: place.y, heard };
            if Self::is_raised(&sample) {
                self.raised_to = self.raised_to.max(along);
            }
            self.samples.push_back(sample);
        }
        if self.samples.len() > Self::KEPT {
            self.samples.pop_front();
        }
        Ok(())
    }

    /// Counts a ping without an echo.
    fn count_unheard(&mut self, number: usize, travel: f64) -> Result<(), Deaf> {
        let (of, bare) = (self.bare.len(), &mut self.bare[number]);
        if bare.unheard == 0 {
            bare.from = travel;
        }
        bare.unheard += 1;
        let run = (travel - bare.from).abs();
        if bare.unheard >= Self::DEAF.0 && (run >= Self::DEAF.1 || bare.count < Self::ENOUGH) {
            let (count, travel_mm) = (bare.unheard, 1e3 * run);
            return Err(Deaf::Transducer { number: number + 1, of, count, travel_mm });
        }
        Ok(())
    }

    /// Learns what a transducer hears of the bare belt.
    fn learn(&mut self, number: usize, echo: Option<Echo>) -> Result<(), Deaf> {
        let bare = &mut self.bare[number];
        if bare.pings >= Self::LEARNING && bare.count >= Self::ENOUGH {
            return Ok(());
        }
        bare.pings += 1;
        if let Some(echo) = echo {
            bare.unheard = 0;
            if let Some(place) = bare.first.get_mut(bare.count as usize) {
                *place = [self.transducer.middle(&echo), echo.amplitude];
                bare.count += 1;
            }
            bare.learn();
        }
        let have = self.bare.iter().filter(|bare| bare.count >= Self::ENOUGH).count() as f64;
        let are_enough = have >= Self::LEARNED * self.bare.len() as f64;
        if are_enough && self.bare.iter().all(|bare| bare.pings >= Self::LEARNING) {
            self.learn_level()?;
            self.learned = Some(self.mean());
        }
        Ok(())
    }

    /// Checks that all transducers that have heard enough have learned one level, and lets the others go by that. How far off it is, the
    /// air's temperature and the matrix's height say, which all have in common: the median of them is the belt, as long as less than a
    /// half are above something else.
    fn learn_level(&mut self) -> Result<(), Deaf> {
        let places = &self.array.places;
        let knows = |bare: &Bare| bare.count >= Self::ENOUGH;
        // Time for each metre of height.
        let all = || self.bare.iter().zip(places).filter(|(bare, _)| knows(bare));
        let mut sorted: Vec<f64> = all().map(|(bare, place)| bare.time / place.z).collect();
        sorted.sort_by(f64::total_cmp);
        let level = sorted[sorted.len() / 2];
        let loud = all().map(|(bare, _)| bare.amplitude).sum::<f64>() / sorted.len() as f64;
        let off = |number: usize| places[number].z - self.bare[number].time / level;
        let is_off = |number: &usize| knows(&self.bare[*number]) && off(*number).abs() > Self::LEVEL;
        let numbers: Vec<usize> = (0..self.bare.len()).filter(is_off).collect();
        // A part is below several. A single one has heard something else, and goes by the others, too.
        if numbers.len() > 1
            && let Some(&number) = numbers.iter().max_by(|a, b| off(**a).abs().total_cmp(&off(**b).abs()))
        {
            return Err(Deaf::Uneven {
                number: number + 1,
                of: self.bare.len(),
                off_mm: 1e3 * off(number),
                limit_mm: 1e3 * Self::LEVEL,
            });
        }
        for (number, (bare, place)) in self.bare.iter_mut().zip(places).enumerate() {
            if !knows(bare) || numbers.contains(&number) {
                (bare.time, bare.amplitude) = (level * place.z, loud);
            }
        }
        Ok(())
    }

    fn mean(&self) -> f64 {
        self.bare.iter().map(|bare| bare.time).sum::<f64>() / self.bare.len() as f64
    }

    /// Where the last row of the array is on a belt that has run `travel` \[m\]: what is before that has been below all of them.
    fn frontier(&self, travel: f64) -> f64 {
        self.last_row - travel
    }

    fn is_raised(sample: &Sample) -> bool {
        sample.heard.is_some_and(|[z, _]| z > Self::RAISED)
    }

    /// The next thing that has wholly passed on a belt that has run `travel` \[m\].
    pub fn passed(&mut self, travel: f64) -> Option<Relief> {
        let frontier = self.frontier(travel);
        let bare_from = frontier + Self::APART;
        // Nothing that stands out has passed all rows and the strip behind them: thousands of samples need not be looked at.
        if self.raised_to <= bare_from {
            return None;
        }
        let (mut pings, mut stray, mut count) = (0.0, 0.0, 0);
        let (mut last, mut first) = (f64::INFINITY, f64::NEG_INFINITY);
        for sample in self.samples.iter().filter(|sample| sample.along > frontier) {
            if sample.along <= bare_from {
                pings += 1.0;
                stray += f64::from(u8::from(Self::is_raised(sample)));
            } else if Self::is_raised(sample) {
                (last, first) = (last.min(sample.along), first.max(sample.along));
                count += 1;
            }
        }
        if count == 0 || stray > Self::STRAY * pings {
            return None;
        }
        let (low, high) = (last - Self::ABOUT, first + Self::ABOUT);
        let within = |sample: &&Sample| (low..=high).contains(&sample.along);
        let samples: Vec<Sample> = self.samples.iter().filter(within).copied().collect();
        let keep = bare_from - 0.5 * Self::APART;
        self.done = self.done.min(keep);
        self.samples.retain(|sample| sample.along < keep);
        let raised = self.samples.iter().filter(|sample| Self::is_raised(sample));
        self.raised_to = raised.map(|sample| sample.along).fold(f64::NEG_INFINITY, f64::max);
        if count < Self::FEWEST {
            return None;
        }
        let across = self.array.places.iter().map(|place| place.y);
        let width = across.clone().fold(f64::NEG_INFINITY, f64::max) - across.fold(f64::INFINITY, f64::min);
        let area = (high - low) * width / samples.len().max(1) as f64;
        Some(Relief { samples, area })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where things lie on the belt, which is bare for 50 mm between them \[m\].
    const THINGS: [[f64; 2]; 2] = [[-0.75, -0.54], [-0.49, -0.28]];

    /// What passes at a speed [m/s], when one ping in 300 of the bare belt hears something 9 mm high.
    fn reliefs_of_things(speed: f64) -> Vec<Relief> {
        let array = Array::over(0.0, 0.25, 0.12);
        let transducer = array.transducer(Air { celsius: 20.0 });
        let amplitude = 2.0 * transducer.threshold();
        let walk = transducer.middle(&Echo { time: 0.0, amplitude });
        let (mut reliefs, mut found, mut bare) = (Reliefs::by(array.clone()), Vec::new(), 0);
        for ping in 1_u32.. {
            let travel = speed * array.period * f64::from(ping);
            if travel > 1.0 {
                break;
            }
            let number = array.turn(ping.into());
            let (along, across) = (array.places[number].x - travel, array.places[number].y);
            let is_over = |[from, to]: &[f64; 2]| (*from..=*to).contains(&along) && across.abs() < 0.04;
            let height = if THINGS.iter().any(is_over) {
                0.03
            } else {
                bare += 1;
                if bare % 300 == 0 { 0.009 } else { 0.0 }
            };
            let time = 2.0 * (array.places[number].z - height) / transducer.air().speed() - walk;
            reliefs.take(number, Some(Echo { time, amplitude }), travel).expect("it hears");
            found.extend(reliefs.passed(travel));
        }
        found
    }

    #[test]
    fn two_things_are_two_reliefs_however_slow_the_belt_is_and_though_some_pings_hear_noise() {
        for speed in [0.004, 0.01, 0.016, 0.03, 0.1] {
            let found = reliefs_of_things(speed);
            assert_eq!(found.len(), 2, "{speed} m/s");
            // The one that is farther along comes first.
            for (relief, [from, to]) in found.iter().zip([THINGS[1], THINGS[0]]) {
                let places = || relief.samples.iter().map(|sample| sample.along);
                let (low, high) =
                    (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
                // With 20 mm of belt about it, and up to `APART` more where noise was heard beside it.
                let most = 0.021 + Reliefs::APART;
                assert!(low < from && high > to, "{speed} m/s: from {low} to {high} m");
                assert!(from - low < most && high - to < most, "{speed} m/s: from {low} to {high} m");
            }
        }
    }
}
