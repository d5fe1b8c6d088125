//! What lifts a plotter's pen: Z, a servo (M280), the word that drivers of pens took over (M300), or the S of M3.
//!
//! A pen that a word lifts has two places, two values of S; values between them count as the nearer one. Which of them is
//! down, the file does not say. It is found by what the program does: rapid moves (G0) are made with the pen up. Where none
//! tells, most of three do: the first move over the plate is made with the pen up, the program begins by lifting it, and it
//! ends by lifting it.

use super::steps::{Move, Pace, Said, Signal, Signals, Step};

/// What lifts the pen of a program, as it is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PenLift {
    /// What the program does tells.
    #[default]
    Auto,
    /// Z alone.
    Height,
    /// A word; with the value of S that is down, where it is given.
    Word {
        /// The word.
        signal: Signal,
        /// The S of a pen that is down.
        down: Option<f64>,
    },
}

/// A pen that a word lifts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    pub signal: Signal,
    pub down: f64,
    pub up: f64,
}

impl Pen {
    /// Whether the pen is down while these are in force.
    pub fn is_down(&self, signals: &Signals) -> bool {
        // Before the first word it is up.
        signals.of(self.signal).is_some_and(|value| self.means_down(value))
    }

    fn means_down(&self, value: f64) -> bool {
        (value - self.down).abs() < (value - self.up).abs()
    }

    /// The pen of this word, where its values are `said`; `None` where the program does not move it.
    pub fn find(signal: Signal, down: Option<f64>, said: &Said, steps: &[Step]) -> Option<Self> {
        let values = said.of(signal);
        let low = values.iter().copied().reduce(f64::min)?;
        let high = values.iter().copied().reduce(f64::max)?;
        if let Some(down) = down {
            let up = if (down - low).abs() < (down - high).abs() { high } else { low };
            return Some(Self { signal, down, up });
        }
        if low >= high {
            return None;
        }
        let low_is_down = Self { signal, down: low, up: high };
        let high_is_down = Self { signal, down: high, up: low };
        let state = |signals: &Signals| signals.of(signal).map(|value| low_is_down.means_down(value));
        let mut rapid = [false; 2];
        for one in sideways(steps).filter(|one| one.pace == Pace::Rapid) {
            if let Some(low) = state(&one.signals) {
                rapid[usize::from(low)] = true;
            }
        }
        let low_is_up = match rapid {
            [false, true] => true,
            [true, false] => false,
            _ => {
                let begins_low = low_is_down.means_down(*values.first()?);
                let [first_move, begin] = match said.first_move.as_ref().and_then(state) {
                    Some(low) => [low, begins_low],
                    // Nothing was said before the first move: what is said first puts the pen down.
                    None => [!begins_low; 2],
                };
                let end = state(&said.end).unwrap_or(begin);
                [first_move, begin, end].into_iter().filter(|low| *low).count() >= 2
            }
        };
        Some(if low_is_up { high_is_down } else { low_is_down })
    }

    /// The pen that the S of M3 lifts, where M3 is on all the time and nothing else than a pen does what it does: with a
    /// laser, travel is rapid or with the beam off.
    pub fn find_on_spindle(said: &Said, steps: &[Step]) -> Option<Self> {
        let values = said.of(Signal::Spindle);
        if said.spindle_alone || values.len() != 2 || values.contains(&0.0) {
            return None;
        }
        let pen = Self::find(Signal::Spindle, None, said, steps)?;
        let feeds: Vec<&Move> = sideways(steps)
            .filter(|one| one.pace == Pace::Feed)
            .skip_while(|one| one.signals.spindle.is_none())
            .collect();
        let always_on = feeds.iter().all(|one| one.on);
        let both = feeds.iter().any(|one| pen.is_down(&one.signals))
            && feeds.iter().any(|one| !pen.is_down(&one.signals));
        let rapid_with_pen_down =
            sideways(steps).any(|one| one.pace == Pace::Rapid && pen.is_down(&one.signals));
        (always_on && both && !rapid_with_pen_down).then_some(pen)
    }
}

/// Moves over the plate.
fn sideways(steps: &[Step]) -> impl Iterator<Item = &Move> {
    steps.iter().filter_map(|step| match step {
        Step::Move(one) if one.pieces.iter().any(|(piece, _)| piece.length() > 1e-6) => Some(one),
        Step::Move(_) | Step::Dwell(..) => None,
    })
}
