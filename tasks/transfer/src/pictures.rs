//! Pictures of the runs: the arms with the bar, moving; and what the bar bears, over time.

use mrroc::cell::RunPicture;
use mrroc::prelude::*;
use mrroc_pictures::{Film, Line, Plot};

use crate::monitor::{RunMeasurements, Sample};
use crate::places::{EDGES, TABLE_EDGES, table};
use crate::summary::Summary;
use crate::variant::{Bases, Ready, Sensors, Variant};

/// A film of a run.
///
/// # Errors
/// The first cause when the run ends with a fault.
pub fn film(variant: Variant, file: &CellFile) -> Result<Film, CellError> {
    let (film, cell) = filmed(variant.ready(file)?);
    cell.run()?;
    Ok(film)
}

/// A film, and the cell that it watches.
#[must_use]
pub fn filmed(ready: Ready) -> (Film, Cell) {
    // The hands are on the arms, which show them.
    let mut film = Film::new().without(&["rnt-hand", "polycrank-hand"]);
    if let Some(plant) = ready.plant {
        film = film.with_block(TABLE_EDGES, table).with_block(EDGES, move || plant.world.body().pose);
    }
    let cell = film.watch(ready.cell);
    (film, cell)
}

/// What is drawn of a sample.
type Quantity = fn(&Sample) -> f64;

/// The charts: heading, unit, what of a sample.
const CHARTS: [(&str, &str, Quantity); 5] = [
    ("Internal force of the bar", "N", |sample| sample.internal),
    ("True relative position of the hands, from where they closed", "mm", |sample| {
        sample.strain.distance * 1e3
    }),
    ("True relative orientation of the hands, from where they closed", "mrad", |sample| {
        sample.strain.angle * 1e3
    }),
    ("Relative position error of the tools, as the encoders say", "mm", |sample| {
        sample.measured.distance * 1e3
    }),
    ("Relative orientation error of the tools, as the encoders say", "mrad", |sample| {
        sample.measured.angle * 1e3
    }),
];

/// A plot of relative pose errors and of the internal force, of the three variants with a bar.
#[must_use]
pub fn plot(summary: &Summary) -> Plot {
    let variants = [
        ("without sensors", Bases::Off, Sensors::Unused),
        ("with sensors", Bases::Off, Sensors::Used),
        ("base not off", Bases::Calibrated, Sensors::Unused),
    ];
    let seen: Vec<(&str, &RunMeasurements)> = variants
        .into_iter()
        .filter_map(|(name, bases, sensors)| Some((name, summary.seen(Variant::Bar { bases, sensors })?)))
        .collect();
    // The run that measures its sensors' bias takes a little longer.
    let longest = seen.iter().map(|(_, seen)| &seen.samples).max_by_key(|samples| samples.len());
    let times: Vec<f64> = longest.into_iter().flatten().map(|sample| sample.time).collect();
    let title = "What a bar between two arms bears";
    let subtitle = "Polycrank's base is 1 mm and 0.1 degree off: without force sensors, and with them; or it is where it is believed to be";
    CHARTS.iter().fold(Plot::new(title, subtitle), |plot, (heading, unit, quantity)| {
        let line = |&(name, seen): &(&str, &RunMeasurements)| -> Line {
            (name.to_owned(), seen.samples.iter().map(quantity).collect())
        };
        plot.chart(heading, unit, times.clone(), seen.iter().map(line))
    })
}
