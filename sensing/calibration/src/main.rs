//! Calibrates an arm from a table of measurements, without a cell and without a program: `calibrate --help`.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mrroc::console::{complain, refused, say};
use mrroc_calibration::columns::{Angles, Columns, WrongLine};
use mrroc_calibration::data::Data;
use mrroc_calibration::file::{Account, of_chain, text, today};
use mrroc_calibration::report::Report;
use mrroc_calibration::trials::{Errors, Trial, chosen, lengths, scales, trials};
use mrroc_calibration::{Detail, Touches, hand_eye, tip};
use mrroc_launch::files;

/// The longest table of touches \[bytes\].
const MOST: u64 = 1 << 20;

/// What is left of positions is a mistake, and no measurement \[m\].
const WRONG: f64 = 5e-3;

const HELP: &str = "\
calibrate: the true dimensions of an arm, from what an instrument measured of it

usage: calibrate --data FILE.csv [options]
       calibrate bases --data TOUCHES.csv --of ARM --in ARM [--out FILE]
       calibrate tcp --data POSES.csv [--angles ORDER] [--out FILE]
       calibrate hand-eye --data POSES.csv [--angles ORDER] [--out FILE]

bases: where one arm's base is in another's, from at least three points that both have
touched; a table with the columns point, arm, x_mm, y_mm, z_mm, where each arm's
controller says its tip is; --out (ARM.base.toml) is for `base` of a robot in cell.toml

tcp: where the tip of a tool is, from poses of the flange with the tip on one point;
hand-eye: where a camera is on the flange, from where it sees a board meanwhile. A table
with the columns x_mm, y_mm, z_mm of the flange and its orientation: rx_rad, ry_rad,
rz_rad (a rotation vector), qw, qx, qy, qz, or a_deg, b_deg, c_deg with --angles zyx, xyz
or zyz; for hand-eye the same of the board in the camera, as board_x_mm and so on; --out
(tool.toml, camera.toml) is a pose for a tool in cell.toml

  --data FILE     joint positions and measurements; its header says what the columns are
  --test FILE     measurements of the same form that are foretold, and not used
  --detail WHAT   frames, zeros, geometry or encoders: how much is calibrated; by default
                  what foretells best the postures that are left out
  --out FILE      the calibration, for `calibration` of a robot in cell.toml;
                  by default FILE.calibration.toml beside the data
  --check         read the data, say what is wrong with them, and stop

The book's page Calibration says how to write the header.
";

struct Options {
    data: PathBuf,
    test: Option<PathBuf>,
    detail: Option<Detail>,
    out: PathBuf,
    only_checks: bool,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return say(HELP);
    }
    let ran = match arguments.split_first() {
        Some((first, rest)) if first == "bases" => bases(rest),
        Some((first, rest)) if first == "tcp" || first == "hand-eye" => hand(first, rest),
        _ => options(&arguments).map_err(Failed::Before).and_then(|options| run(&options)),
    };
    match ran {
        Ok(text) => say(&text),
        Err(Failed::Before(why)) => refused(&why),
        Err(Failed::Late(why)) => {
            complain(&format!("error: {why}"));
            ExitCode::FAILURE
        }
    }
}

/// Why there is no calibration: what the user wrote, or what came of it.
enum Failed {
    Before(String),
    Late(String),
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let (mut data, mut test, mut detail, mut out, mut only_checks) = (None, None, None, None, false);
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut value =
            || rest.next().cloned().ok_or_else(|| format!("{argument} needs a value\n help: see --help"));
        match argument.as_str() {
            "--data" => data = Some(PathBuf::from(value()?)),
            "--test" => test = Some(PathBuf::from(value()?)),
            "--out" => out = Some(PathBuf::from(value()?)),
            "--check" => only_checks = true,
            "--detail" => {
                let word = value()?;
                detail = Some(match word.as_str() {
                    "frames" => Detail::Frames,
                    "zeros" => Detail::Zeros,
                    "geometry" => Detail::Geometry,
                    "encoders" => Detail::Encoders,
                    _ => {
                        return Err(format!(
                            "no detail `{word}`\n help: write frames, zeros, geometry or encoders"
                        ));
                    }
                });
            }
            other => return Err(format!("no option `{other}`\n help: see --help")),
        }
    }
    let data = data.ok_or("there are no data\n help: write --data FILE.csv, or see --help")?;
    let out = out.unwrap_or_else(|| data.with_extension("calibration.toml"));
    Ok(Options { data, test, detail, out, only_checks })
}

/// Options of a command of the shop floor, by name.
fn given<const N: usize>(arguments: &[String], names: [&str; N]) -> Result<[Option<String>; N], Failed> {
    let mut given = [const { None }; N];
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let Some(place) = names.iter().position(|name| name == argument) else {
            let help = format!("the command has {}; see --help", names.join(", "));
            return Err(Failed::Before(format!("no option `{argument}`\n help: {help}")));
        };
        let missing = || Failed::Before(format!("{argument} needs a value\n help: see --help"));
        given[place] = Some(rest.next().ok_or_else(missing)?.clone());
    }
    Ok(given)
}

fn needed(option: Option<String>, what: &str) -> Result<String, Failed> {
    option.ok_or_else(|| Failed::Before(format!("{what} is missing\n help: see --help")))
}

fn table(file: &str) -> Result<String, Failed> {
    let mut text = String::new();
    files::open(file)
        .and_then(|file| file.take(MOST).read_to_string(&mut text))
        .map_err(|why| Failed::Before(format!("{file} cannot be read: {why}")))?;
    Ok(text)
}

fn write(file: &str, text: &str) -> Result<(), Failed> {
    files::check_outputs([Path::new(file)]).map_err(|why| Failed::Before(why.to_string()))?;
    std::fs::write(file, text).map_err(|why| Failed::Late(format!("{file} cannot be written: {why}")))
}

/// `calibrate bases`.
fn bases(arguments: &[String]) -> Result<String, Failed> {
    let [data, of, within, out] = given(arguments, ["--data", "--of", "--in", "--out"])?;
    let (data, of) = (needed(data, "--data TOUCHES.csv")?, needed(of, "--of ARM")?);
    let within = needed(within, "--in ARM")?;
    let found = Touches::parse(&table(&data)?).and_then(|touches| touches.base(&of, &within));
    let found = found.map_err(|why| Failed::Before(format!("{data}: {why}")))?;
    let out = out.unwrap_or_else(|| format!("{of}.base.toml"));
    write(&out, &found.text(&of, &within, &today()))?;
    Ok(format!("the base of {of} in that of {within}\n{found}see {out}\n"))
}

/// `calibrate tcp` and `calibrate hand-eye`.
fn hand(what: &str, arguments: &[String]) -> Result<String, Failed> {
    let [data, angles, out] = given(arguments, ["--data", "--angles", "--out"])?;
    let data = needed(data, "--data POSES.csv")?;
    let order = |name: String| {
        let none = || Failed::Before(format!("no order of angles `{name}`\n help: write zyx, xyz or zyz"));
        Angles::named(&name).ok_or_else(none)
    };
    let angles = angles.map(order).transpose()?;
    let text = table(&data)?;
    let wrong = |why: WrongLine| Failed::Before(format!("{data}: {why}"));
    let columns = Columns::parse(&text, "x_mm,y_mm,z_mm,rx_rad,ry_rad,rz_rad").map_err(wrong)?;
    let flanges = columns.poses("", angles).map_err(wrong)?;
    if flanges.len() < 3 {
        let what = format!(
            "{data}: {} poses of at least 3\n help: turn the hand about two axes between them",
            flanges.len()
        );
        return Err(Failed::Before(what));
    }
    let (name, found) = if what == "tcp" {
        ("tool", tip(&flanges))
    } else {
        let boards = columns.poses("board_", angles).map_err(wrong)?;
        ("camera", hand_eye(&flanges.into_iter().zip(boards).collect::<Vec<_>>()))
    };
    let found = found.map_err(|why| Failed::Late(format!("{data}: {why}")))?;
    if let [_, ..] = &found.unseen[..] {
        let list = found.unseen.join("; ");
        let help = "turn the hand about other axes, too, by 30 degrees or more";
        return Err(Failed::Before(format!("{data}: these poses do not tell all: {list}\n help: {help}")));
    }
    if found.left[0] > WRONG {
        let help =
            "compare the order of the angles, the units, and whether the poses are those of the flange";
        let what = format!("these poses do not fit: {:.1} mm rms are left", 1e3 * found.left[0]);
        return Err(Failed::Before(format!("{data}: {what}\n help: {help}")));
    }
    let out = out.unwrap_or_else(|| format!("{name}.toml"));
    write(&out, &found.text(name, &today()))?;
    Ok(format!("the {name} on the flange\n{found}see {out}\n"))
}

fn run(options: &Options) -> Result<String, Failed> {
    let before = |why: &dyn std::fmt::Display| Failed::Before(why.to_string());
    let late = |why: &dyn std::fmt::Display| Failed::Late(why.to_string());
    let data = Data::read(&options.data).map_err(|why| before(&why))?;
    let test = options.test.as_deref().map(Data::read).transpose().map_err(|why| before(&why))?;
    if options.only_checks {
        return Ok(format!(
            "{} postures, {} measurements, nothing wrong\n",
            data.postures(),
            data.measurements()
        ));
    }
    if options.out == options.data {
        return Err(Failed::Before("--out is the file of the data\n help: write another name".to_owned()));
    }
    let wanted = options.detail.or(data.detail());
    let trials = trials(&data, wanted).map_err(|why| late(&why))?;
    let chosen = chosen(&trials, wanted);
    let trial = &trials[chosen];
    let scales = scales(&data, trial).map_err(|why| late(&why))?;
    let name = |path: &Path| path.display().to_string();
    let tested = test.as_ref().map(|test| {
        let errors = |trial: &Trial| {
            let other = data.with_rows_of(test, trial).map_err(|why| before(&why))?;
            let raw = trial.fit.foretold(&other);
            Ok::<_, Failed>(Errors::of(lengths(&other, &raw).into_iter().map(|(_, error)| error)))
        };
        let file = options.test.as_deref().map(name).unwrap_or_default();
        Ok::<_, Failed>((file, errors(&trials[0])?, errors(trial)?))
    });
    let test = tested.transpose()?;
    let file = name(&options.data);
    let report = Report { data: &data, file: &file, trials: &trials, chosen, scales: &scales, test };
    let mut frames = vec![("base".to_owned(), trial.fit.frame(trial.stated.base))];
    let named =
        data.instruments().zip(trial.stated.instruments.iter().map(|id| trial.stated.problem.place_of(*id)));
    let points = data.points().zip(trial.stated.points.iter().map(|id| trial.stated.problem.frame_of(*id)));
    frames.extend(named.chain(points).map(|(name, frame)| (name.to_owned(), trial.fit.frame(frame))));
    let account = Account {
        robot: data.arm().name.clone(),
        data: options.data.file_name().map(|name| name.to_string_lossy().into_owned()),
        made: today(),
        within: trial.within,
        foretold: trial.foretold,
        frames,
    };
    let calibration = of_chain(&trial.stated.model, trial.fit.arm(trial.stated.arm));
    let written = text(&calibration, &trial.fit, trial.stated.arm, &account);
    std::fs::write(&options.out, written)
        .map_err(|why| Failed::Late(format!("{} cannot be written: {why}", options.out.display())))?;
    Ok(format!("{}\nsee {}\n", report.text(), options.out.display()))
}
