//! What came of runs with the camera, in figures and sentences.

use core::fmt;

use super::kinds::{KINDS, kinds};
use super::layout::STATIONS;
use super::looks::Look;
use super::misses::Miss;
use super::run::Outcome;
use super::settings::Settings;
use super::studio::Trial;
use crate::monitor::Fate;
use crate::summary::quantile;

/// How often a kind was taken for which: rows are what it truly was, the last column is "none of the kinds".
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Confusion(pub [[u32; KINDS + 1]; KINDS + 1]);

impl Confusion {
    /// Counts a thing of this kind, the last one of strangers, that was taken for another.
    pub fn add(&mut self, kind: Option<usize>, taken: Option<usize>) {
        self.0[kind.unwrap_or(KINDS)][taken.unwrap_or(KINDS)] += 1;
    }

    /// Of things that were shown in the studio.
    #[must_use]
    pub fn of(trials: &[Trial]) -> Self {
        let mut all = Self::default();
        trials.iter().for_each(|trial| all.add(trial.kind, trial.taken));
        all
    }

    /// Things that were taken for what they were, misnamed, and rejected; of the kinds.
    #[must_use]
    pub fn counts(&self) -> [u32; 3] {
        let mut counts = [0; 3];
        for (kind, row) in self.0.iter().enumerate().take(KINDS) {
            for (taken, count) in row.iter().enumerate() {
                let which = if taken == kind {
                    0
                } else if taken == KINDS {
                    2
                } else {
                    1
                };
                counts[which] += count;
            }
        }
        counts
    }
}

/// A line of the summary: one run, or several.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// Nominal speed of the belt [m/s], and mean time between parts \[s\].
    pub speed: f64,
    /// See [`speed`](Self::speed).
    pub every: f64,
    /// Parts of the kinds, how many were sorted, how many things came into a wrong bin, and which parts were missed.
    pub parts: usize,
    /// See [`parts`](Self::parts).
    pub sorted: usize,
    /// See [`parts`](Self::parts).
    pub wrong: usize,
    /// Why those that were missed were.
    pub missed: Vec<Miss>,
    /// Strangers that came, how many of them passed, as they should, and how many a hand took, though they came into no bin.
    pub strangers: usize,
    /// See [`strangers`](Self::strangers).
    pub passed: usize,
    /// See [`strangers`](Self::strangers).
    pub gripped: usize,
    /// How many grasps each arm made.
    pub taken: [usize; STATIONS.len()],
    /// The least distance of two arms \[m\].
    pub closest: Option<f64>,
    /// Share of the cycle-time bound at which parts came, where that was measured.
    pub load: Option<f64>,
    /// Distances of places and angles that the camera told from the true ones \[m, rad\].
    pub places: Vec<f64>,
    /// See [`places`](Self::places).
    pub angles: Vec<f64>,
    /// Of those the ones along the belt, with their sign \[m\].
    pub along: Vec<f64>,
    /// Distances of grasps from the middle \[m\].
    pub off: Vec<f64>,
    /// How often a finger came down on a part.
    pub crashes: u32,
    /// How often a hand closed on nothing, and was opened again.
    pub failed: u32,
    /// Simulated time, and how long it took \[s\].
    pub time: f64,
    /// See [`time`](Self::time).
    pub wall: f64,
}

impl Line {
    /// Of a run.
    #[must_use]
    pub fn of(settings: &Settings, outcome: &Outcome) -> Self {
        let known = |look: &&Look| look.taken.is_some();
        let looks = || outcome.looks.iter().filter(known);
        let strangers = outcome.came.iter().filter(|(_, kind)| *kind == KINDS).count();
        Self {
            speed: settings.speed,
            every: settings.every,
            parts: outcome.fates.len() - strangers,
            strangers,
            passed: outcome.count(Fate::Passed),
            gripped: outcome.count(Fate::Gripped),
            sorted: outcome.count(Fate::Sorted),
            wrong: outcome.count(Fate::Wrong),
            missed: outcome.misses(settings.arms),
            taken: core::array::from_fn(|arm| outcome.grips.iter().filter(|grip| grip.arm == arm).count()),
            closest: outcome.closest.as_ref().map(|closest| closest.nearest.distance),
            load: None,
            places: looks().map(|look| look.off[0].hypot(look.off[1])).collect(),
            angles: looks().map(|look| look.turned).collect(),
            along: looks().map(|look| look.off[0]).collect(),
            off: outcome.grips.iter().map(|grip| grip.off.abs()).collect(),
            crashes: outcome.crashes,
            failed: outcome.failed,
            time: outcome.report.as_ref().map_or(0.0, |report| report.time.as_secs_f64()),
            wall: outcome.wall.as_secs_f64(),
        }
    }

    /// Whether nothing is in a wrong bin, no finger came down on a part, and any part was sorted.
    #[must_use]
    pub const fn is_well(&self) -> bool {
        self.wrong == 0 && self.crashes == 0 && self.sorted > 0
    }

    /// Counts the runs of another line with this one's.
    pub fn join(&mut self, other: Self) {
        self.parts += other.parts;
        self.sorted += other.sorted;
        self.wrong += other.wrong;
        self.crashes += other.crashes;
        self.failed += other.failed;
        self.taken.iter_mut().zip(other.taken).for_each(|(taken, other)| *taken += other);
        let least = |a: f64, b: f64| a.min(b);
        self.closest = self.closest.into_iter().chain(other.closest).reduce(least);
        // Numbers go on over the runs.
        let before = self.parts + self.strangers - other.parts;
        self.strangers += other.strangers;
        self.passed += other.passed;
        self.gripped += other.gripped;
        self.missed.extend(other.missed.into_iter().map(|miss| Miss { part: miss.part + before, ..miss }));
        self.places.extend(other.places);
        self.angles.extend(other.angles);
        self.along.extend(other.along);
        self.off.extend(other.off);
        self.time += other.time;
        self.wall += other.wall;
    }
}

/// Several lines.
#[derive(Clone, Debug, Default)]
pub struct Table(pub Vec<Line>);

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "   belt  every  bound  parts  sorted  wrong  missed   place p95    angle p95    off centre [mm]       speed"
        )?;
        writeln!(
            f,
            "    m/s      s      %                                      mm          deg     p50    p95    max"
        )?;
        for line in &self.0 {
            let [p50, p95, most] = [0.5, 0.95, 1.0].map(|share| 1e3 * quantile(&line.off, share));
            let place = 1e3 * quantile(&line.places, 0.95);
            let angle = quantile(&line.angles, 0.95).to_degrees();
            let load = line.load.map_or("-".to_owned(), |load| format!("{:.0}", 100.0 * load));
            let pace = if line.wall > 0.0 { line.time / line.wall } else { 0.0 };
            writeln!(
                f,
                "{:7.2}{:7.1}{load:>7}{:7}{:8}{:7}{:8}{place:12.2}{angle:13.2}{p50:8.2}{p95:7.2}{most:7.2}{pace:10.0} x",
                line.speed,
                line.every,
                line.parts,
                line.sorted,
                line.wrong,
                line.missed.len()
            )?;
        }
        for line in &self.0 {
            if let Some(closest) = line.closest {
                let [one, two] = line.taken;
                writeln!(
                    f,
                    "{:.2} m/s, one every {:.1} s: the first arm took {one}, the second {two}; they were never nearer than {:.3} m",
                    line.speed, line.every, closest
                )?;
            }
        }
        for line in self.0.iter().filter(|line| line.strangers > 0) {
            write!(
                f,
                "{:.2} m/s, one every {:.1} s: besides these parts, strangers: {} came, {} passed, which is right",
                line.speed, line.every, line.strangers, line.passed
            )?;
            if line.gripped > 0 {
                write!(f, "; {} a hand took for parts, and brought to no bin", line.gripped)?;
            }
            writeln!(f)?;
        }
        let missed: usize = self.0.iter().map(|line| line.missed.len()).sum();
        if missed > 0 {
            writeln!(f, "   belt  every   part  kind             came  after   why it was missed")?;
            writeln!(f, "    m/s      s                             s      s")?;
        }
        for line in &self.0 {
            for miss in &line.missed {
                writeln!(f, "{:7.2}{:7.1}{miss}", line.speed, line.every)?;
            }
        }
        let crashes: u32 = self.0.iter().map(|line| line.crashes).sum();
        let failed: u32 = self.0.iter().map(|line| line.failed).sum();
        writeln!(
            f,
            "fingers came down on a part {crashes} times, and closed on nothing and were opened again {failed} times; speed: times \
             faster than real time, on one processor"
        )
    }
}

/// What an examination says.
#[must_use]
pub fn examination(trials: &[Trial]) -> String {
    let confusion = Confusion::of(trials);
    let [right, misnamed, rejected] = confusion.counts();
    let known: Vec<_> =
        trials.iter().filter(|trial| trial.kind.is_some() && trial.taken == trial.kind).collect();
    let of = |value: fn(&Trial) -> f64, share: f64| {
        quantile(&known.iter().map(|trial| value(trial)).collect::<Vec<_>>(), share)
    };
    let all = right + misnamed + rejected;
    let share = 100.0 * f64::from(right) / f64::from(all.max(1));
    let strangers: u32 = confusion.0[KINDS].iter().sum();
    let mut text = format!(
        "{all} parts: {right} recognised ({share:.2} %), {misnamed} misnamed, {rejected} rejected\nplace off by {:.2} mm (p95), {:.2} mm at most; angle by {:.2} deg (p95), {:.2} deg at most\n",
        1e3 * of(|trial| trial.off, 0.95),
        1e3 * of(|trial| trial.off, 1.0),
        of(|trial| trial.turned, 0.95).to_degrees(),
        of(|trial| trial.turned, 1.0).to_degrees(),
    );
    let fit = known.iter().map(|trial| trial.fit).fold(1.0, f64::min);
    let strange =
        trials.iter().filter(|trial| trial.kind.is_none()).map(|trial| trial.fit).fold(0.0, f64::max);
    text += &format!("fit of outlines: of parts at least {fit:.3}");
    if strangers > 0 {
        text += &format!(
            "; {strangers} strangers: {} rejected; the best fit of one {strange:.3}",
            confusion.0[KINDS][KINDS]
        );
    }
    text += "\n";
    let kinds = kinds();
    for trial in trials.iter().filter(|trial| trial.taken != trial.kind).take(10) {
        let name = |kind: Option<usize>| kind.map_or("none of the kinds", |kind| kinds[kind].class.name);
        text += &format!(
            "{} taken for {}: score {:.2}, fit {:.3}\n",
            name(trial.kind),
            name(trial.taken),
            trial.score,
            trial.fit
        );
    }
    text
}
