//! The command line.

use crate::drawing::hershey::Font;
use crate::placement::{Plate, Sizing};
use crate::plate::Cutter;
use lexopt::prelude::*;
use mrroc::Clock;
use std::ffi::OsString;
use std::path::PathBuf;

/// What is engraved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The nameplate that is built in.
    Nameplate,
    /// A file.
    File(PathBuf),
    /// A text in a single-stroke font.
    Text {
        /// The text; `\n` begins a new line.
        text: String,
        /// The font's name or file.
        font: String,
    },
}

/// How much is said on the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Talk {
    /// Progress and the table.
    Normal,
    /// Errors only.
    Quiet,
}

/// The options of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// What is engraved.
    pub source: Source,
    /// Where the results go.
    pub out: PathBuf,
    /// How large the drawing becomes.
    pub sizing: Sizing,
    /// The plate.
    pub plate: Plate,
    /// The tool's end.
    pub cutter: Cutter,
    /// Depth of the groove \[mm\], > 0.
    pub depth: f64,
    /// Feed \[mm/s\], > 0.
    pub feed: f64,
    /// The controller's step \[s\], > 0.
    pub step: f64,
    /// Whether the cell runs as processes of the operating system, and in whose time.
    pub processes: Option<Clock>,
    /// What is said.
    pub talk: Talk,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            source: Source::Nameplate,
            out: PathBuf::from("engraving"),
            sizing: Sizing::Natural,
            plate: Plate::default(),
            cutter: Cutter::default(),
            depth: 0.3,
            feed: 20.0,
            step: 0.002,
            processes: None,
            talk: Talk::Normal,
        }
    }
}

/// What the command line asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// A run.
    Engrave(Box<Options>),
    /// The help, to be printed.
    Help,
    /// The version, to be printed.
    Version,
}

/// A command line that cannot be followed; the text says what to write instead.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\n help: {help}")]
pub struct OptionsError {
    what: String,
    help: String,
}

/// The text of `--help`.
pub const HELP: &str = "\
Engraves a drawing with a simulated IRp-6 arm and shows the result.

Usage: engraving [OPTIONS] [FILE]

  FILE is a drawing: .svg, .dxf, or G-code (.ngc .nc .gcode .tap).
  Without a FILE and without --text a nameplate that is built in is engraved.

Drawing:
  --text STRING       engrave a text instead of a file; \\n begins a new line
  --font NAME         its font: futural, rowmans, scripts, timesr, or a .jhf
                      [default: futural]
  --size WxH          as large as fits into W x H mm
  --scale FACTOR      so many times as large as in the file
  --fit               as large as the plate has room for [default for --text]

Plate and tool:
  --plate WxH         size of the plate in mm [default: 200x120]
  --margin MM         kept free on every side [default: 10]
  --tool v:DEG        a V of this full angle [default: v:90]
  --tool ball:MM      a ball of this diameter
  --depth MM          depth of the groove [default: 0.3]
  --feed MM/S         speed along the path [default: 20]
  --step-ms MS        step of the controller: 0.5, 1 or a multiple of 2
                      [default: 2]

Processes:
  --processes         run every process of the cell as one of the operating
                      system, in real time (Linux)
  --virtual           the same in lock-step under the virtual clock
  status, suspend, resume, speed 50%, abort, stop, console
                      from another terminal, to the arm that engraves by
                      --processes
  doctor              say what this machine can do for --processes

Results:
  -o, --out DIR       folder for plate.png, paths.svg and summary.json
                      [default: engraving/]
  -q, --quiet         print errors only
  -h, --help          print this text
  -V, --version       print the version

Exit status: 0 if all bounds were kept, 1 if not, 2 if the drawing or the
command line was refused; then nothing has moved.
";

const NAMES: &[&str] = &[
    "text",
    "font",
    "size",
    "scale",
    "fit",
    "plate",
    "margin",
    "tool",
    "depth",
    "feed",
    "step-ms",
    "out",
    "processes",
    "virtual",
    "quiet",
    "help",
    "version",
];

/// Reads the arguments after the program's name.
///
/// # Errors
/// [`OptionsError`] with what to write instead.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Request, OptionsError> {
    let mut parser = lexopt::Parser::from_args(arguments);
    let mut options = Options::default();
    let (mut file, mut text, mut font) = (None, None, None);
    let mut sizing: Option<(&str, Sizing)> = None;
    while let Some(argument) = parser.next().map_err(|e| refuse(e.to_string(), "see --help"))? {
        let name = match argument {
            Short('h') => return Ok(Request::Help),
            Short('V') => return Ok(Request::Version),
            Short('q') => "quiet".to_owned(),
            Short('o') => "out".to_owned(),
            Short(other) => return Err(unknown(&format!("-{other}"), "")),
            Long(name) => name.to_owned(),
            Value(value) => {
                if let Some(first) = file.replace(PathBuf::from(&value)) {
                    let what = format!("two files: {} and {}", first.display(), value.display());
                    return Err(refuse(what, "give one; quote a path that has blanks"));
                }
                continue;
            }
        };
        let mut new_sizing = None;
        match name.as_str() {
            "help" => return Ok(Request::Help),
            "version" => return Ok(Request::Version),
            "quiet" => options.talk = Talk::Quiet,
            "processes" => options.processes = options.processes.or(Some(Clock::Real)),
            "virtual" => options.processes = Some(Clock::Virtual),
            "fit" => new_sizing = Some(("--fit", Sizing::Fill)),
            "text" => text = Some(value(&mut parser, "--text")?.replace("\\n", "\n")),
            "font" => font = Some(value(&mut parser, "--font")?),
            "out" => options.out = PathBuf::from(value(&mut parser, "--out")?),
            "size" => {
                let (width, height) = size(&value(&mut parser, "--size")?, "--size")?;
                new_sizing = Some(("--size", Sizing::Within { width, height }));
            }
            "scale" => {
                new_sizing = Some(("--scale", Sizing::Scale(number(&mut parser, "--scale", 1e-6, 1e6)?)))
            }
            "plate" => {
                (options.plate.width, options.plate.height) =
                    size(&value(&mut parser, "--plate")?, "--plate")?
            }
            "margin" => options.plate.margin = number(&mut parser, "--margin", 0.0, 1000.0)?,
            "tool" => options.cutter = tool(&value(&mut parser, "--tool")?)?,
            "depth" => options.depth = number(&mut parser, "--depth", 0.001, 20.0)?,
            "feed" => options.feed = number(&mut parser, "--feed", 0.01, 1000.0)?,
            "step-ms" => options.step = step(number(&mut parser, "--step-ms", 0.5, 100.0)?)?,
            other => return Err(unknown(&format!("--{other}"), other)),
        }
        if let Some(new) = new_sizing
            && let Some((first, _)) = sizing.replace(new)
        {
            return Err(refuse(
                format!("{first} and {}: both say how large", new.0),
                "give one of --size, --scale, --fit",
            ));
        }
    }
    options.source = source(file, text, font)?;
    options.sizing = match (sizing, &options.source) {
        (Some((_, sizing)), _) => sizing,
        (None, Source::Text { .. }) => Sizing::Fill,
        (None, Source::File(_) | Source::Nameplate) => Sizing::Natural,
    };
    let room = options.plate.room();
    if room.x <= 0.0 || room.y <= 0.0 {
        let what = format!("a margin of {} mm leaves nothing of the plate", options.plate.margin);
        return Err(refuse(what, "give a smaller --margin or a larger --plate"));
    }
    Ok(Request::Engrave(Box::new(options)))
}

/// The longest text: it fills the largest plate that the arm reaches.
const MOST_CHARACTERS: usize = 2000;

fn source(file: Option<PathBuf>, text: Option<String>, font: Option<String>) -> Result<Source, OptionsError> {
    match (file, text, font) {
        (Some(file), Some(_), _) => Err(refuse(
            format!("{} and --text: both say what to engrave", file.display()),
            "give one of them",
        )),
        (None, Some(text), _) if text.chars().count() > MOST_CHARACTERS => Err(refuse(
            format!("--text has {} characters, more than {MOST_CHARACTERS}", text.chars().count()),
            "engrave it in parts: no plate has room for more",
        )),
        (None, Some(text), font) => {
            Ok(Source::Text { text, font: font.unwrap_or_else(|| "futural".to_owned()) })
        }
        (_, None, Some(_)) => Err(refuse("--font without --text", "give the text by --text \"..\"")),
        (Some(file), None, None) => Ok(Source::File(file)),
        (None, None, None) => Ok(Source::Nameplate),
    }
}

fn refuse(what: impl Into<String>, help: impl Into<String>) -> OptionsError {
    OptionsError { what: what.into(), help: help.into() }
}

fn unknown(shown: &str, name: &str) -> OptionsError {
    let nearest = NAMES.iter().map(|known| (distance(known, name), known)).min();
    match nearest {
        Some((d, known)) if !name.is_empty() && d <= 2 => {
            refuse(format!("no option {shown}"), format!("did you mean --{known}?"))
        }
        _ => refuse(format!("no option {shown}"), "--help lists them all"),
    }
}

/// How many letters differ: Levenshtein's distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let above = row[j + 1];
            row[j + 1] = (diagonal + usize::from(x != *y)).min(above + 1).min(row[j] + 1);
            diagonal = above;
        }
    }
    row[b.len()]
}

fn value(parser: &mut lexopt::Parser, option: &str) -> Result<String, OptionsError> {
    let value = parser
        .value()
        .map_err(|_| refuse(format!("{option} without a value"), format!("see {option} in --help")))?;
    value.into_string().map_err(|_| refuse(format!("{option}: not a text in UTF-8"), "use plain characters"))
}

fn number(parser: &mut lexopt::Parser, option: &str, low: f64, high: f64) -> Result<f64, OptionsError> {
    let text = value(parser, option)?;
    match text.parse::<f64>() {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => Err(refuse(format!("{option} {text}"), format!("give a number from {low} to {high}"))),
    }
}

/// A step [ms] in seconds: a multiple of the arm's servo period of 2 ms, or an even part of it.
fn step(step_ms: f64) -> Result<f64, OptionsError> {
    const SERVO_MS: f64 = 2.0;
    let periods = (step_ms / SERVO_MS).max(SERVO_MS / step_ms);
    if (periods - periods.round()).abs() < 1e-9 {
        return Ok(step_ms * 1e-3);
    }
    Err(refuse(
        format!("--step-ms {step_ms}: the arm's servo period of 2 ms does not divide it, nor it the period"),
        "give 1 or a multiple of 2",
    ))
}

fn size(text: &str, option: &str) -> Result<(f64, f64), OptionsError> {
    let sides: Result<Vec<f64>, _> = text.split(['x', 'X', '×']).map(|side| side.trim().parse()).collect();
    match sides.as_deref() {
        Ok(&[w, h]) if w > 0.0 && h > 0.0 && w <= 2000.0 && h <= 2000.0 => Ok((w, h)),
        _ => Err(refuse(
            format!("{option} {text}"),
            format!("give width and height in mm up to 2000, as {option} 200x120"),
        )),
    }
}

fn tool(text: &str) -> Result<Cutter, OptionsError> {
    let help = "give v:90 for a V of 90 degrees (10 to 170), or ball:1.5 for a ball of 1.5 mm (0.1 to 20)";
    let (kind, number) = text.split_once(':').unwrap_or((text, ""));
    match (kind, number.parse::<f64>()) {
        ("v", Ok(degrees)) if (10.0..=170.0).contains(&degrees) => {
            Ok(Cutter::Vee { angle: degrees.to_radians() })
        }
        ("ball", Ok(diameter)) if (0.1..=20.0).contains(&diameter) => {
            Ok(Cutter::Ball { radius: diameter / 2.0 })
        }
        _ => Err(refuse(format!("--tool {text}"), help)),
    }
}

/// The names of the shipped fonts, for messages.
#[must_use]
pub fn fonts() -> String {
    Font::shipped().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(line: &str) -> Result<Request, OptionsError> {
        parse(line.split_whitespace().map(OsString::from))
    }

    fn options(line: &str) -> Options {
        match run(line).unwrap() {
            Request::Engrave(options) => *options,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_text_longer_than_any_plate_is_refused() {
        let long = "a".repeat(MOST_CHARACTERS + 1);
        let error = parse(["--text".into(), long.into()]).expect_err("too long");
        assert!(error.to_string().contains("2001 characters"), "{error}");
    }

    #[test]
    fn no_argument_engraves_the_nameplate() {
        assert_eq!(options(""), Options::default());
    }

    #[test]
    fn all_options_are_read() {
        let found = options(
            "a.svg --plate 300x200 --margin 5 --size=100x50 --tool ball:2 --depth 0.5 --feed 30 --step-ms 1 -o x -q",
        );
        assert_eq!(found.source, Source::File("a.svg".into()));
        assert_eq!(found.plate, Plate { width: 300.0, height: 200.0, margin: 5.0 });
        assert_eq!(found.sizing, Sizing::Within { width: 100.0, height: 50.0 });
        assert_eq!(found.cutter, Cutter::Ball { radius: 1.0 });
        assert_eq!((found.depth, found.feed, found.step), (0.5, 30.0, 0.001));
        assert_eq!((found.out, found.talk), ("x".into(), Talk::Quiet));
        assert_eq!(found.processes, None);
        assert_eq!(options("--processes").processes, Some(Clock::Real));
        for both in ["--virtual", "--processes --virtual", "--virtual --processes"] {
            assert_eq!(options(both).processes, Some(Clock::Virtual));
        }
        assert_eq!(options("--text Hi").sizing, Sizing::Fill);
        assert_eq!(run("--help"), Ok(Request::Help));
    }

    #[test]
    fn wrong_options_say_what_to_write() {
        for (line, part) in [
            ("--plat 3x4", "did you mean --plate?"),
            ("--zzzzzz", "--help lists them all"),
            ("--depth -1", "0.001 to 20"),
            ("--depth nan", "0.001 to 20"),
            ("--plate 3", "as --plate 200x120"),
            ("--plate 3xx4", "as --plate 200x120"),
            ("--plate 3x4xy", "as --plate 200x120"),
            ("--step-ms 3", "a multiple of 2"),
            ("--step-ms 1.5", "a multiple of 2"),
            ("--size 3x4 --fit", "both say how large"),
            ("a.svg b.svg", "two files"),
            ("a.svg --text x", "both say what to engrave"),
            ("--font x", "--font without --text"),
            ("--feed", "--feed without a value"),
            ("--margin 90", "leaves nothing"),
            ("--tool spoon", "v:90"),
        ] {
            let message = run(line).unwrap_err().to_string();
            assert!(message.contains(part), "{line}: {message}");
        }
    }

    #[test]
    fn the_help_names_every_option_and_font() {
        for name in NAMES {
            assert!(HELP.contains(&format!("--{name}")), "{name}");
        }
        assert!(HELP.contains(&fonts()));
        assert!(HELP.lines().all(|line| line.len() <= 80));
    }
}
