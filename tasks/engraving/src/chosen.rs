//! What was chosen for the cutting, and who chose it: an option before the file, the file before the default.

use serde::Serialize;

use crate::drawing::{Drawing, Stroke};
use crate::ecp::travel_height;
use crate::options::Options;

/// Depth where neither file nor option says one \[mm\].
pub const DEFAULT_DEPTH: f64 = 0.3;
/// Feed where neither file nor option says one [mm/s].
pub const DEFAULT_FEED: f64 = 20.0;
/// The slowest feed that is followed [mm/s].
const SLOWEST_FEED: f64 = 0.01;

/// Who said a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum By {
    /// Nobody.
    Default,
    /// The file, for all strokes or for some: the others have the default.
    File,
    /// The command line.
    Option,
}

/// A value of all strokes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chosen {
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
    /// Who said it.
    pub by: By,
    /// Strokes where the arm's limits allow less than was asked for.
    pub limited: usize,
}

impl Chosen {
    /// Whether nobody said it.
    #[must_use]
    pub fn is_default(&self) -> bool {
        self.by == By::Default && self.limited == 0
    }

    fn over(values: impl Iterator<Item = f64>, by: By) -> Self {
        let (least, greatest) = values.fold((f64::MAX, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        Chosen { least: least.min(greatest), greatest, by, limited: 0 }
    }

    /// For a table: values of this unit, and who said them; `option` is what it is called on the command line.
    #[must_use]
    pub fn told(&self, unit: &str, option: &str) -> String {
        let digits = |value: f64| {
            let text = format!("{value:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        };
        let (least, greatest) = (digits(self.least), digits(self.greatest));
        let values = if least == greatest { greatest } else { format!("{least} to {greatest}") };
        let by = match self.by {
            By::Default => "by default",
            By::File => "from the file",
            By::Option => option,
        };
        let limited = match self.limited {
            0 => String::new(),
            1 => ", one stroke at the arm's limit".to_owned(),
            n => format!(", {n} strokes at the arm's limit"),
        };
        format!("{values} {unit}, {by}{limited}")
    }
}

/// What holds for the cutting of a drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// How deep each stroke goes \[mm\].
    pub depth: Chosen,
    /// Feed [mm/s].
    pub feed: Chosen,
    /// Height at which the tool travels \[mm\].
    pub travel: Chosen,
}

/// The drawing at its depth and with its feeds, of which none is greater than its limit [mm/s]; and what was chosen.
/// `limits` gives a stroke's limit, when it is at its depth.
///
/// # Errors
/// What `limits` finds wrong.
pub fn chosen<E>(
    drawing: Drawing,
    options: &Options,
    limits: impl Fn(&Stroke) -> Result<f64, E>,
) -> Result<(Drawing, Cutting), E> {
    let says = |said: fn(&Stroke) -> bool| {
        if drawing.strokes.iter().any(said) { By::File } else { By::Default }
    };
    let depth_by = options.depth.map_or(says(|stroke| stroke.heights().is_some()), |_| By::Option);
    let feed_by = options.feed.map_or(says(|stroke| stroke.manner().feed.is_some()), |_| By::Option);
    let travel_by = says(|stroke| stroke.manner().approach.is_some());
    let mut drawing = match options.depth {
        Some(depth) => drawing.flattened_to(depth),
        None => drawing.sunk(DEFAULT_DEPTH),
    };
    let mut limited = 0;
    let mut feeds = Vec::with_capacity(drawing.strokes.len());
    for stroke in &mut drawing.strokes {
        let manner = *stroke.manner();
        let asked = options.feed.or(manner.feed).unwrap_or(DEFAULT_FEED);
        let feed = asked.min(limits(stroke)?).max(SLOWEST_FEED);
        limited += usize::from(feed != asked);
        feeds.push(feed);
        *stroke = stroke.clone().cut_so(crate::drawing::Manner { feed: Some(feed), ..manner });
    }
    let depths = drawing.strokes.iter().map(|stroke| -stroke.height_range().0);
    let travels = drawing.strokes.iter().filter(|stroke| !stroke.manner().goes_on);
    let cutting = Cutting {
        depth: Chosen::over(depths, depth_by),
        feed: Chosen { limited, ..Chosen::over(feeds.into_iter(), feed_by) },
        travel: Chosen::over(travels.map(|stroke| travel_height(stroke.manner()) * 1e3), travel_by),
    };
    Ok((drawing, cutting))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Limits, read_str};

    fn cut(program: &str, line: &str) -> (Drawing, Cutting) {
        let options = crate::options::parse(line.split_whitespace().map(Into::into)).unwrap();
        let drawing = read_str("a.ngc", program, Limits::default()).unwrap().drawing;
        chosen(drawing, &options, |_| Ok::<_, ()>(100.0)).unwrap()
    }

    #[test]
    fn the_file_comes_before_the_default_and_an_option_before_the_file() {
        let program = "G21 G0 X0 Y0 Z5\nG1 Z-5 F100\nG1 X10 F600\nG0 Z5";
        let (drawing, cutting) = cut(program, "");
        assert_eq!((cutting.depth.greatest, cutting.depth.by), (5.0, By::File));
        // F100 and F600 are millimetres in a minute.
        assert!(
            (cutting.feed.least - 100.0 / 60.0).abs() < 1e-12 && (cutting.feed.greatest - 10.0).abs() < 1e-12
        );
        assert_eq!((cutting.travel.greatest, cutting.travel.by), (5.0, By::File));
        assert_eq!(drawing.strokes.len(), 2);
        assert_eq!(drawing.strokes[1].height_range(), (-5.0, -5.0));
        let (drawing, cutting) = cut(program, "--depth 0.5 --feed 30");
        assert_eq!((cutting.depth.greatest, cutting.depth.by), (0.5, By::Option));
        assert_eq!((cutting.feed.least, cutting.feed.greatest, cutting.feed.by), (30.0, 30.0, By::Option));
        assert!(drawing.strokes.iter().all(|stroke| stroke.height_range().0 == -0.5));
        let (drawing, cutting) = cut("G21 G1 X10", "");
        assert!(cutting.depth.is_default() && cutting.feed.is_default() && cutting.travel.is_default());
        assert_eq!(drawing.strokes[0].height_range(), (-0.3, -0.3));
    }

    #[test]
    fn a_feed_beyond_the_limit_is_the_limit_and_told() {
        let (drawing, cutting) = cut("G21 G1 X10 F60000\nX20 F600", "");
        assert_eq!(drawing.strokes[0].manner().feed, Some(100.0));
        assert_eq!((cutting.feed.limited, cutting.feed.greatest), (1, 100.0));
        let told = cutting.feed.told("mm/s", "by --feed");
        assert_eq!(told, "10 to 100 mm/s, from the file, one stroke at the arm's limit");
    }
}
