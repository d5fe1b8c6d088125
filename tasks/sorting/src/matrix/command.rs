//! What the command line asks of the task with the matrix, besides runs.

use std::path::Path;

use mrroc_sensors::aggregation::HeardObject;

use super::picture::reliefs;
use super::run::network;
use super::studio::{Conditions, Trial, data_set, examine};
use crate::camera::charts::confusion;
use crate::camera::command::{Said, save};
use crate::camera::kinds::{KINDS, kinds};
use crate::camera::studio::Untrained;
use crate::camera::summary::Confusion;
use crate::options::Options;
use crate::summary::quantile;

/// So many reliefs are drawn.
const RELIEFS: usize = 6;

/// A table for the training script.
///
/// # Errors
/// The file cannot be written.
pub fn collect(options: &Options, file: &Path) -> Said {
    let table = data_set(options.parts as usize, options.seed.into(), Box::new(Untrained))?;
    std::fs::write(file, table).map_err(|error| format!("{}: cannot be written: {error}", file.display()))?;
    Ok((format!("{} parts in {}\n", options.parts, file.display()), true))
}

/// Which kind things were taken for.
#[must_use]
pub fn counted(trials: &[Trial]) -> Confusion {
    let mut counts = Confusion::default();
    trials
        .iter()
        .for_each(|trial| counts.add(trial.kind, trial.heard.as_ref().and_then(|heard| heard.class)));
    counts
}

/// Recognition of parts that it has never heard, one in ten a stranger: in a quiet room, and with a tenth of the echoes lost and 5 K.
///
/// # Errors
/// A picture cannot be written.
pub fn test_recognition(options: &Options, count: usize) -> Said {
    let (mut text, mut well) = (String::new(), true);
    for (name, conditions) in [("usual", Conditions::USUAL), ("hard", Conditions::HARD)] {
        let conditions = Conditions { stranger: 10, ..conditions };
        let mut kept = Vec::new();
        let seed = u64::from(options.seed) + 1_000_000;
        let trials = examine(count, seed, &conditions, Box::new(network()?), |_, relief, heard| {
            if kept.len() < RELIEFS {
                kept.push((relief.clone(), heard.clone()));
            }
        })?;
        let counts = counted(&trials);
        save(&options.out, &format!("confusion-{name}.svg"), &confusion(&counts))?;
        save(&options.out, &format!("reliefs-{name}.svg"), &reliefs(&kept))?;
        let strangers: u32 = counts.0[KINDS][..KINDS].iter().sum();
        let [right, misnamed, _] = counts.counts();
        well &= right > 0 && misnamed == 0 && strangers == 0;
        text += &format!("{name}: {}", examination(&trials));
    }
    let folder = options.out.display();
    Ok((
        format!("{text}see {folder}/confusion-usual.svg, {folder}/reliefs-usual.svg and those of -hard\n"),
        well,
    ))
}

/// What an examination says.
#[must_use]
pub fn examination(trials: &[Trial]) -> String {
    let counts = counted(trials);
    let [right, misnamed, rejected] = counts.counts();
    let all = right + misnamed + rejected;
    let known: Vec<_> = trials
        .iter()
        .filter(|trial| {
            trial.kind.is_some() && trial.heard.as_ref().and_then(|heard| heard.class) == trial.kind
        })
        .collect();
    let off: Vec<f64> = known.iter().map(|trial| trial.off[0].hypot(trial.off[1])).collect();
    let turned: Vec<f64> = known.iter().map(|trial| trial.turned.to_degrees()).collect();
    let share = 100.0 * f64::from(right) / f64::from(all.max(1));
    let strangers: u32 = counts.0[KINDS].iter().sum();
    let mut text = format!(
        "{all} parts: {right} recognised ({share:.2} %), {misnamed} misnamed, {rejected} rejected; {strangers} strangers, {} rejected\n",
        counts.0[KINDS][KINDS],
    );
    text += &format!(
        "place off by {:.2} mm (root mean square), {:.2} mm (p95), {:.2} mm at most; angle by {:.2} deg (p95), {:.2} deg at most\n",
        1e3 * rms(&off),
        1e3 * quantile(&off, 0.95),
        1e3 * quantile(&off, 1.0),
        quantile(&turned, 0.95),
        quantile(&turned, 1.0),
    );
    let misfit = |is_known: bool, trial: &&Trial| {
        (trial.kind.is_some() == is_known).then(|| trial.heard.as_ref().map(|h: &HeardObject| h.misfit))
    };
    let misfits: Vec<f64> = trials.iter().filter_map(|trial| misfit(true, &trial).flatten()).collect();
    let strange =
        trials.iter().filter_map(|trial| misfit(false, &trial).flatten()).fold(f64::INFINITY, f64::min);
    text += &format!(
        "misfit of parts {:.2} (p95), {:.2} at most; of strangers at least {strange:.2}\n",
        quantile(&misfits, 0.95),
        quantile(&misfits, 1.0),
    );
    let names = kinds();
    let name = |kind: Option<usize>| kind.map_or("none of the kinds", |kind| names[kind].class.name);
    let wrong =
        trials.iter().filter(|trial| trial.heard.as_ref().and_then(|heard| heard.class) != trial.kind);
    for trial in wrong.take(12) {
        let (score, misfit) =
            trial.heard.as_ref().map_or((0.0, f64::NAN), |heard| (heard.score, heard.misfit));
        let taken = trial.heard.as_ref().and_then(|heard| heard.class);
        text += &format!(
            "{} taken for {}: score {score:.2}, misfit {misfit:.2}\n",
            name(trial.kind),
            name(taken)
        );
    }
    text
}

/// The root of the mean square.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
