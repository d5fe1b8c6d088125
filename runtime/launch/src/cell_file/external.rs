//! What `[sensors.NAME.external]` says of a sensor whose readings a program of another sends.

use core::ops::Range;
use core::time::Duration;
use std::net::SocketAddr;
use std::path::Path;
use std::rc::Rc;

use mrroc_core::cell::CellError;

use super::error::{At, Source};
use super::topic::TopicEntry;

/// A sensor whose readings a program of another sends, as the cell file describes it. The file says what may be believed:
/// how often readings come, and what they may be.
#[derive(Clone, Debug)]
pub struct ExternalEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: String,
    pub(super) port: String,
    pub(super) has_port: bool,
    pub(super) address: Option<SocketAddr>,
    pub(super) span: Range<usize>,
    pub(super) step: Duration,
    pub(super) stale_after: Duration,
    pub(super) rate: f64,
    pub(super) least: Option<At<Vec<f64>>>,
    pub(super) largest: Option<At<Vec<f64>>>,
    pub(super) per_second: Option<At<Vec<f64>>>,
    pub(super) topic: Option<TopicEntry>,
}

/// What each number of a reading may be, in the unit of the number.
#[derive(Clone, Debug, PartialEq)]
pub struct Believable {
    /// The least.
    pub least: Vec<f64>,
    /// The largest.
    pub largest: Vec<f64>,
    /// The most by which it may change in a second; `None`: by as much as it likes.
    pub per_second: Option<Vec<f64>>,
}

impl ExternalEntry {
    /// The sensor's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// `port`: the name by which the program finds the sensor; the sensor's own unless it is said.
    #[must_use]
    pub fn port(&self) -> &str {
        &self.port
    }

    /// Whether the file says the port.
    #[must_use]
    pub const fn has_port(&self) -> bool {
        self.has_port
    }

    /// `address`: where this machine waits for the program, which is on another one; `None` for a program on this machine.
    #[must_use]
    pub const fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    /// The path of the cell file, as it was given.
    #[must_use]
    pub fn cell_file(&self) -> &Path {
        Path::new(&self.source.file)
    }

    /// The step of the cell, `Ts`.
    #[must_use]
    pub const fn step(&self) -> Duration {
        self.step
    }

    /// `stale_after_ms`: the age at which a reading is too old to move by.
    #[must_use]
    pub const fn stale_after(&self) -> Duration {
        self.stale_after
    }

    /// `rate_hz`: how many readings the program sends in a second \[Hz\].
    #[must_use]
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// `topic`: the topic of ROS 2 whose messages the bridge sends as readings; `None`: another program sends them.
    #[must_use]
    pub const fn topic(&self) -> Option<&TopicEntry> {
        self.topic.as_ref()
    }

    /// `least`, `largest` and `per_second`, of a reading whose numbers have these names.
    ///
    /// # Errors
    /// `least` or `largest` is missing, or they have another number of values.
    pub fn believable(&self, numbers: &[String]) -> Result<Believable, CellError> {
        let mut errors = Vec::new();
        for (key, list) in [("least", &self.least), ("largest", &self.largest)] {
            if list.is_none() {
                let what = format!("sensor `{}` has a program of another, and no `{key}`", self.name);
                let help = format!("write {key} = [..], a number for each of: {}", numbers.join(", "));
                errors.push(self.source.complain(&self.span, what, help).into());
            }
        }
        let mut values = |key: &str, list: Option<&At<Vec<f64>>>| {
            let Some(list) = list else { return Vec::new() };
            if list.value.len() != numbers.len() {
                let what =
                    format!("`{key}` has {} numbers, a reading has {}", list.value.len(), numbers.len());
                let help = format!("write one for each of: {}", numbers.join(", "));
                errors.push(self.source.complain(&list.span, what, help).into());
            }
            list.value.clone()
        };
        let believable = Believable {
            least: values("least", self.least.as_ref()),
            largest: values("largest", self.largest.as_ref()),
            per_second: self.per_second.as_ref().map(|list| values("per_second", Some(list))),
        };
        CellError::all(errors).map(|()| believable)
    }

    /// Refuses a kind of sensor with a reading of which no bounds can say what may be believed.
    #[must_use]
    pub fn refuse_reading(&self, kind: &str) -> CellError {
        let what = format!(
            "a reading of kind `{kind}` has words that are neither numbers, truth values nor choices"
        );
        let help = "give it fields that are, such as f64, or compute the sensor in the program of the cell";
        self.source.complain(&self.span, what, help.to_owned()).into()
    }

    /// Refuses a sensor that the program of the cell computes.
    pub(super) fn refuse_computed(&self) -> CellError {
        let what = format!("the program of the cell computes sensor `{}` itself", self.name);
        let help = "leave the table out, or use `External` of mrroc-external in the program";
        self.source.complain(&self.span, what, help.to_owned()).into()
    }
}
