//! The command line.
//!
//! In: the arguments. Out: the options of a run, checked; or what there is to say instead: the help, the version, or what is
//! wrong with them.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::Parser;
use clap::error::ErrorKind;
use mrroc::launch::{Clock, Launch};

use crate::drawing::Reading;
use crate::drawing::gcode::{BlockDelete, DEEPEST, PenLift, Signal, Switches};
use crate::drawing::hershey::Font;
use crate::placement::{Plate, Sizing};
use crate::plate::Cutter;

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
    /// Depth of all grooves \[mm\], > 0; else what the file says.
    pub depth: Option<f64>,
    /// Feed along all strokes [mm/s], > 0; else what the file says.
    pub feed: Option<f64>,
    /// How a file is read.
    pub reading: Reading,
    /// The controller's step \[s\], > 0.
    pub step: f64,
    /// Whether the cell runs as processes of the operating system, and in whose time.
    pub processes: Option<Clock>,
    /// What is said.
    pub talk: Talk,
}

const ABOUT: &str = "\
Engraves a drawing with a simulated IRp-6 arm and shows the result.

FILE is a drawing: .svg, .dxf, or G-code (.ngc .nc .gcode .tap). Without a FILE
and without --text a nameplate that is built in is engraved.";

const CUTS: &str = "\
What is cut: every visible outline of an SVG drawing and its texts; every line,
arc, spline and text of a DXF drawing. Of G-code, whose Z0 is the plate's
surface:
  1. where a feed move (G1 G2 G3 G5 G6.2, a hole) goes below Z0: of all feed
     moves what is below Z0, as deep as Z and as fast as F say;
  2. else, where M280, M300 or the S of M3 lifts a pen: feed moves with it down;
  3. else, feed moves at Z0 or before any Z while M3 or M4 is on;
  4. else, all feed moves at Z0 or before any Z.
G0 is travel. What is read and not applied is said as a warning; so is what a
DXF drawing hides: layers that are off, frozen or not plotted are not cut.
";

/// The command line as it is written.
#[derive(Debug, Parser)]
#[command(
    version,
    about = ABOUT,
    override_usage = "engraving [OPTIONS] [FILE]\n       engraving COMMAND",
    after_help = after_help(),
    args_override_self = true,
    max_term_width = 80
)]
struct Arguments {
    #[arg(value_name = "FILE", hide = true)]
    files: Vec<PathBuf>,

    /// Engrave a text instead of a file; \n begins a new line.
    #[arg(long, value_name = "STRING", allow_hyphen_values = true, help_heading = "Drawing")]
    text: Option<String>,
    #[arg(long, value_name = "NAME", help = font_help(), help_heading = "Drawing")]
    font: Option<String>,
    /// As large as fits into W x H mm.
    #[arg(long, value_name = "WxH", value_parser = sides, group = "sizing", help_heading = "Drawing")]
    size: Option<Sides>,
    /// So many times as large as in the file.
    #[arg(long, value_name = "FACTOR", value_parser = number(1e-6, 1e6), group = "sizing")]
    #[arg(allow_negative_numbers = true, help_heading = "Drawing")]
    scale: Option<f64>,
    /// As large as the plate has room for [default for --text].
    #[arg(long, group = "sizing", help_heading = "Drawing")]
    fit: bool,

    /// Which Z of a G-code program is the plate's surface, in mm.
    #[arg(long, value_name = "Z", value_parser = number(-1e6, 1e6), default_value = "0")]
    #[arg(allow_negative_numbers = true, help_heading = "Drawing")]
    surface: f64,
    /// Whether lines of G-code that begin with / are left out.
    #[arg(long, value_name = "on|off", value_parser = switch, default_value = "on", help_heading = "Drawing")]
    block_delete: BlockDelete,

    /// What lifts the pen in G-code: auto (found by what the program does), z, m3, m280, m300; m280:30 says that S30
    /// is down.
    #[arg(long, value_name = "WORD[:S]", value_parser = pen, default_value = "auto", help_heading = "Drawing")]
    pen: PenLift,

    /// Size of the plate in mm.
    #[arg(long, value_name = "WxH", value_parser = sides, default_value = "200x120")]
    #[arg(help_heading = "Plate and tool")]
    plate: Sides,
    /// Kept free on every side.
    #[arg(long, value_name = "MM", value_parser = number(0.0, 1000.0), default_value = "10")]
    #[arg(allow_negative_numbers = true, help_heading = "Plate and tool")]
    margin: f64,
    /// The tool's end: v:DEG, a V of this full angle, or ball:MM, a ball of this diameter.
    #[arg(long, value_name = "END", value_parser = tool, default_value = "v:90", help_heading = "Plate and tool")]
    tool: Cutter,
    /// Depth of all grooves [default: as the file's Z says, else 0.3].
    #[arg(long, value_name = "MM", value_parser = number(0.001, DEEPEST))]
    #[arg(allow_negative_numbers = true, help_heading = "Plate and tool")]
    depth: Option<f64>,
    /// Speed along the path [default: as the file's F says, else 20].
    #[arg(long, value_name = "MM/S", value_parser = number(0.01, 1000.0))]
    #[arg(allow_negative_numbers = true, help_heading = "Plate and tool")]
    feed: Option<f64>,
    /// Step of the controller: 0.5, 1 or a multiple of 2.
    #[arg(long = "step-ms", value_name = "MS", value_parser = step, default_value = "2")]
    #[arg(allow_negative_numbers = true, help_heading = "Plate and tool")]
    step: f64,

    /// Run every process of the cell as one of the operating system, in real time (Linux).
    #[arg(long, help_heading = "Processes")]
    processes: bool,
    /// The same in lock-step under the virtual clock.
    #[arg(long = "virtual", help_heading = "Processes")]
    lock_step: bool,

    /// Folder for plate.png, paths.svg and summary.json.
    #[arg(short, long, value_name = "DIR", default_value = "engraving", help_heading = "Results")]
    out: PathBuf,
    /// Print errors only.
    #[arg(short, long, help_heading = "Results")]
    quiet: bool,
}

fn font_help() -> String {
    format!("Its font: {}, or a .jhf file [default: {DEFAULT_FONT}]", fonts())
}

fn after_help() -> String {
    let launch = Launch::help();
    format!(
        "{CUTS}
{launch}

Exit status: 0 if all bounds were kept, 1 if not, 2 if the drawing or the
command line was refused; then nothing has moved.

Examples:
  engraving                                  the nameplate
  engraving drawing.svg --fit --out plate/   a drawing as large as there is room
  engraving --text \"Hello\" --font scripts    a text
  engraving drawing.svg --processes          in real time; meanwhile, elsewhere:
  engraving speed 50%"
    )
}

/// Width and height \[mm\], > 0.
#[derive(Clone, Copy, Debug)]
struct Sides {
    width: f64,
    height: f64,
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead ([`Launch::answer`]): the help, the version, or what is wrong and what to write.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    let read = Arguments::try_parse_from(iter::once(OsString::from("engraving")).chain(arguments))?;
    let plate = Plate { width: read.plate.width, height: read.plate.height, margin: read.margin };
    let room = plate.room();
    if room.x <= 0.0 || room.y <= 0.0 {
        let what = format!("a margin of {} mm leaves nothing of the plate", plate.margin);
        return Err(refuse(&what, "give a smaller --margin or a larger --plate"));
    }
    Ok(Options {
        sizing: read.sizing(),
        processes: read.clock(),
        source: source(&read.files, read.text, read.font)?,
        out: read.out,
        plate,
        cutter: read.tool,
        depth: read.depth,
        feed: read.feed,
        reading: Reading {
            gcode: Switches { block_delete: read.block_delete, surface: read.surface, pen: read.pen },
            ..Reading::default()
        },
        step: read.step,
        talk: if read.quiet { Talk::Quiet } else { Talk::Normal },
    })
}

impl Arguments {
    fn sizing(&self) -> Sizing {
        match (self.size, self.scale) {
            (Some(Sides { width, height }), _) => Sizing::Within { width, height },
            (None, Some(factor)) => Sizing::Scale(factor),
            (None, None) if self.fit || self.text.is_some() => Sizing::Fill,
            (None, None) => Sizing::Natural,
        }
    }

    fn clock(&self) -> Option<Clock> {
        match (self.processes, self.lock_step) {
            (_, true) => Some(Clock::Virtual),
            (true, false) => Some(Clock::Real),
            (false, false) => None,
        }
    }
}

/// The longest text: it fills the largest plate that the arm reaches.
const MOST_CHARACTERS: usize = 2000;

const DEFAULT_FONT: &str = "futural";

fn source(files: &[PathBuf], text: Option<String>, font: Option<String>) -> Result<Source, clap::Error> {
    match (files, text, font) {
        ([first, second, ..], ..) => Err(refuse(
            &format!("two files: {} and {}", first.display(), second.display()),
            "give one; quote a path that has blanks",
        )),
        ([file], Some(_), _) => Err(refuse(
            &format!("{} and --text: both say what to engrave", file.display()),
            "give one of them",
        )),
        (_, None, Some(_)) => Err(refuse("--font without --text", "give the text by --text \"..\"")),
        ([], Some(text), font) => {
            let text = text.replace("\\n", "\n");
            let characters = text.chars().count();
            if characters > MOST_CHARACTERS {
                let what = format!("--text has {characters} characters, more than {MOST_CHARACTERS}");
                return Err(refuse(&what, "engrave it in parts: no plate has room for more"));
            }
            Ok(Source::Text { text, font: font.unwrap_or_else(|| DEFAULT_FONT.to_owned()) })
        }
        ([file], None, None) => Ok(Source::File(file.clone())),
        ([], None, None) => Ok(Source::Nameplate),
    }
}

fn refuse(what: &str, help: &str) -> clap::Error {
    clap::Error::raw(ErrorKind::ValueValidation, format!("{what}\n help: {help}\n"))
}

/// A parser of numbers in these bounds.
fn number(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse::<f64>() {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => Err(format!("give a number from {low} to {high}")),
    }
}

/// A step \[ms\] in seconds: a multiple of the arm's servo period of 2 ms, or an even part of it.
fn step(text: &str) -> Result<f64, String> {
    const SERVO_MS: f64 = 2.0;
    let step_ms = number(0.5, 100.0)(text)?;
    let periods = (step_ms / SERVO_MS).max(SERVO_MS / step_ms);
    if (periods - periods.round()).abs() < 1e-9 {
        return Ok(step_ms * 1e-3);
    }
    Err("the arm's servo period of 2 ms does not divide it, nor it the period: give 1 or a multiple of 2"
        .to_owned())
}

fn switch(text: &str) -> Result<BlockDelete, &'static str> {
    match text {
        "on" => Ok(BlockDelete::On),
        "off" => Ok(BlockDelete::Off),
        _ => Err("give on or off"),
    }
}

fn pen(text: &str) -> Result<PenLift, &'static str> {
    const HELP: &str = "give auto, z, m3, m280 or m300, or with the S of a pen that is down, as m280:30";
    let text = text.to_ascii_lowercase();
    let (word, down) = match text.split_once(':') {
        Some((word, down)) => (word, Some(down.trim_start_matches('s').parse::<f64>().map_err(|_| HELP)?)),
        None => (&*text, None),
    };
    if down.is_some_and(|down| !down.is_finite()) {
        return Err(HELP);
    }
    let signal = match (word, down) {
        ("auto", None) => return Ok(PenLift::Auto),
        ("z", None) => return Ok(PenLift::Height),
        ("m3", _) => Signal::Spindle,
        ("m280", _) => Signal::Servo,
        ("m300", _) => Signal::Tone,
        _ => return Err(HELP),
    };
    Ok(PenLift::Word { signal, down })
}

fn sides(text: &str) -> Result<Sides, &'static str> {
    let sides: Result<Vec<f64>, _> = text.split(['x', 'X', '×']).map(|side| side.trim().parse()).collect();
    match sides.as_deref() {
        Ok(&[width, height]) if width > 0.0 && height > 0.0 && width <= 2000.0 && height <= 2000.0 => {
            Ok(Sides { width, height })
        }
        _ => Err("give width and height in mm up to 2000, as 200x120"),
    }
}

fn tool(text: &str) -> Result<Cutter, &'static str> {
    let (kind, number) = text.split_once(':').unwrap_or((text, ""));
    match (kind, number.parse::<f64>()) {
        ("v", Ok(degrees)) if (10.0..=170.0).contains(&degrees) => {
            Ok(Cutter::Vee { angle: degrees.to_radians() })
        }
        ("ball", Ok(diameter)) if (0.1..=20.0).contains(&diameter) => {
            Ok(Cutter::Ball { radius: diameter / 2.0 })
        }
        _ => Err("give v:90 for a V of 90 degrees (10 to 170), or ball:1.5 for a ball of 1.5 mm (0.1 to 20)"),
    }
}

/// The names of the shipped fonts, for messages.
#[must_use]
pub fn fonts() -> String {
    Font::shipped().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
