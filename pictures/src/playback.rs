//! The clock of the animation.
//!
//! In: when the run began and ended \[s\]. Out: the times of its frames, and SMIL's `dur`, `keyTimes`: real time, or faster
//! so that it lasts [`LONGEST`]; then a pause, then again from the beginning.

use std::fmt::Write as _;

use crate::svg::Svg;

/// The longest that a run is shown \[s\].
const LONGEST: f64 = 10.0;

/// The pause at its end \[s\].
const PAUSE: f64 = 1.5;

/// Frames per second between which the viewer draws straight lines.
const RATE: f64 = 15.0;

/// Frames of all robots of a picture together.
const MOST_FRAMES: usize = 360;

/// When what is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Playback {
    start: f64,
    end: f64,
    shown: f64,
    frames: usize,
}

impl Playback {
    /// Of a run of `robots` robots; none of a run that is over in an instant.
    pub fn of(start: f64, end: f64, robots: usize) -> Option<Playback> {
        let duration = end - start;
        if !duration.is_finite() || duration < 0.02 {
            return None;
        }
        let shown = duration.min(LONGEST);
        let most = (MOST_FRAMES / robots.max(1)).clamp(24, 120);
        Some(Playback { start, end, shown, frames: ((shown * RATE).ceil() as usize).clamp(4, most) })
    }

    /// How many times faster than the motion it plays, at least 1.
    pub fn faster(&self) -> f64 {
        (self.end - self.start) / self.shown
    }

    /// The times of the run that the frames show \[s\], the first and the last among them.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        let start = self.start;
        let length = self.end - start;
        let steps = self.frames - 1;
        (0..=steps).map(move |i| start + length * i as f64 / steps as f64)
    }

    /// Moves `attribute` of the enclosing element through one value per frame, and holds the last for the pause.
    pub fn animate(&self, svg: &mut Svg, attribute: &str, mut values: Vec<String>) {
        let Some(last) = values.last().cloned() else { return };
        let steps = values.len().saturating_sub(1).max(1);
        let mut key_times = String::new();
        for i in 0..values.len() {
            let share = self.shown / (self.shown + PAUSE) * i as f64 / steps as f64;
            let _ = write!(key_times, "{share:.4};");
        }
        key_times.push('1');
        values.push(last);
        svg.element(
            "animate",
            format_args!(
                " attributeName=\"{attribute}\" dur=\"{:.2}s\" repeatCount=\"indefinite\" keyTimes=\"{key_times}\" values=\"{}\"",
                self.shown + PAUSE,
                values.join(";")
            ),
        );
    }

    /// Sets `attribute` of the enclosing element where animations are shown.
    pub fn set(svg: &mut Svg, attribute: &str, value: &str) {
        svg.element(
            "set",
            format_args!(" attributeName=\"{attribute}\" to=\"{value}\" begin=\"0s\" dur=\"indefinite\""),
        );
    }
}

/// What `content` draws, shown only where animations are: it stands for what else is drawn at rest.
pub(crate) fn moving(svg: &mut Svg, content: impl FnOnce(&mut Svg)) {
    svg.containing("g", format_args!(" class=\"moving\" display=\"none\""), |svg| {
        Playback::set(svg, "display", "inline");
        content(svg);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_plays_in_real_time_and_long_runs_faster() {
        let short = Playback::of(1.0, 5.0, 1).unwrap();
        assert_eq!(short.faster(), 1.0);
        let times: Vec<f64> = short.times().collect();
        assert_eq!((times[0], times[times.len() - 1]), (1.0, 5.0));
        let long = Playback::of(0.0, 3600.0, 8).unwrap();
        assert!((long.faster() - 360.0).abs() < 1e-9);
        assert!(long.times().count() * 8 <= MOST_FRAMES);
        assert_eq!(Playback::of(0.5, 0.502, 1), None);
        assert_eq!(Playback::of(f64::INFINITY, f64::NEG_INFINITY, 0), None);
    }
}
