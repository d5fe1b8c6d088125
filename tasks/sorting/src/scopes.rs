//! Where options have an effect: by which sensors, and in which modes. One that has none is refused, by name.

use clap::parser::ValueSource;
use clap::{ArgMatches, ValueEnum};

/// What parts are seen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SensorKind {
    /// Light barriers, a range finder, and a barrier between the fingers.
    Infrared,
    /// A camera over the belt, and the belt's encoder: eight kinds of parts, a queue.
    Camera,
    /// An ultrasonic matrix in place of the camera.
    Ultrasonic,
}

/// What the program is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One run.
    Run,
    /// Runs of many seeds or at several speeds.
    Sweep,
    /// Recognition without a cell.
    Examine,
    /// Recognition of images in files.
    Images,
    /// Features to train a network by.
    DataSet,
}

use Mode::{DataSet, Examine, Images, Run, Sweep};
use SensorKind::{Camera, Infrared, Ultrasonic};

const EACH: &[SensorKind] = &[Infrared, Camera, Ultrasonic];
const OVERHEAD: &[SensorKind] = &[Camera, Ultrasonic];

/// An option, the sensors by which it has an effect, and the modes; one in no line has an effect everywhere.
type Scope = (&'static str, &'static [SensorKind], &'static [Mode]);

const SCOPES: &[Scope] = &[
    ("belt", EACH, &[Run]),
    ("parts", EACH, &[Run]),
    ("parts", OVERHEAD, &[DataSet]),
    ("seed", EACH, &[Run]),
    ("seed", OVERHEAD, &[Sweep, Examine, DataSet]),
    ("arms", OVERHEAD, &[Run, Sweep]),
    ("first_edge", &[Infrared], &[Run]),
    ("sweep", EACH, &[Sweep]),
    ("speeds", OVERHEAD, &[Sweep]),
    ("every", OVERHEAD, &[Run]),
    ("poisson", OVERHEAD, &[Run, Sweep]),
    ("profile", EACH, &[Run]),
    ("profile", OVERHEAD, &[Sweep]),
    ("strangers", OVERHEAD, &[Run, Sweep]),
    ("touching", OVERHEAD, &[Run, Sweep]),
    ("examine", OVERHEAD, &[Examine]),
    ("images", &[Camera], &[Images]),
    ("data_set", OVERHEAD, &[DataSet]),
    ("out", EACH, &[Run, Sweep, Examine, Images]),
];

impl Mode {
    /// The option that asks for it; none asks for a run.
    const fn option(self) -> Option<&'static str> {
        match self {
            Run => None,
            Sweep => Some("sweep"),
            Examine => Some("examine"),
            Images => Some("images"),
            DataSet => Some("data_set"),
        }
    }

    /// What these arguments ask for.
    #[must_use]
    pub fn of(matches: &ArgMatches) -> Self {
        let is_asked = |mode: &Self| mode.option().is_some_and(|option| is_given(matches, option));
        [Sweep, Examine, Images, DataSet].into_iter().find(is_asked).unwrap_or(Run)
    }
}

/// Whether the command line has an option, by its name among the fields of the options.
#[must_use]
pub fn is_given(matches: &ArgMatches, option: &str) -> bool {
    matches.value_source(option) == Some(ValueSource::CommandLine)
}

/// Where this option has an effect.
fn scopes(option: &str) -> impl Iterator<Item = &'static Scope> {
    SCOPES.iter().filter(move |scope| scope.0 == option)
}

/// What is wrong with these arguments: an option that has no effect by this sensor, or in this mode.
#[must_use]
pub fn without_effect(matches: &ArgMatches, sensor: SensorKind, mode: Mode) -> Option<String> {
    let has_effect = |scope: &Scope| scope.1.contains(&sensor) && scope.2.contains(&mode);
    let (option, ..) =
        SCOPES.iter().find(|(option, ..)| is_given(matches, option) && !scopes(option).any(has_effect))?;
    let here = match mode.option().filter(|of| of != option) {
        Some(of) => format!("--sensor {} and {}", name(sensor), flag(of)),
        None => format!("--sensor {}", name(sensor)),
    };
    let goes: Vec<_> = scopes(option).map(goes_with).collect();
    Some(format!("{} has no effect with {here}: it goes with {}", flag(option), goes.join(", or with ")))
}

/// `--sensor camera or ultrasonic, alone or with --sweep`.
fn goes_with((option, sensors, modes): &Scope) -> String {
    let mut names: Vec<_> = sensors.iter().map(|sensor| name(*sensor)).collect();
    let last = names.pop().unwrap_or_default();
    let sensors = match names.len() {
        0 => format!("--sensor {last}"),
        some if some + 1 == EACH.len() => "any --sensor".to_owned(),
        _ => format!("--sensor {} or {last}", names.join(", ")),
    };
    let others = modes.iter().filter(|mode| mode.option() != Some(option));
    let others: Vec<_> = others
        .map(|mode| mode.option().map_or("alone".to_owned(), |of| format!("with {}", flag(of))))
        .collect();
    let others = if others.is_empty() { String::new() } else { format!(", {}", others.join(" or ")) };
    format!("{sensors}{others}")
}

/// An option as it is written.
fn flag(option: &str) -> String {
    format!("--{}", option.replace('_', "-"))
}

const fn name(sensor: SensorKind) -> &'static str {
    match sensor {
        Infrared => "infrared",
        Camera => "camera",
        Ultrasonic => "ultrasonic",
    }
}
