//! Calibrates an arm from a table of measurements, without a cell and without a program: `calibrate --help`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mrroc::console::{complain, refused, say};
use mrroc_calibration::data::Data;
use mrroc_calibration::file::{Account, of_chain, text, today};
use mrroc_calibration::known::{FRAME, FRAME_TURN, is_unknown};
use mrroc_calibration::report::Report;
use mrroc_calibration::trials::{Errors, Trial, chosen, folds, lengths, scales, trials};
use mrroc_calibration::{Detail, Fit, bent};
use mrroc_robots::LocalCorrection;

mod poses;
mod shop;

const HELP: &str = "\
calibrate: the true dimensions of an arm, from what an instrument measured of it

usage: calibrate --data FILE.csv [options]
       calibrate poses --data HEADER.csv --count N [options]
       calibrate camera --board BOARD PHOTOS.. [--out FILE] [--corners FILE]
       calibrate bases --data TOUCHES.csv --of ARM --in ARM [--out FILE]
       calibrate tcp --data POSES.csv [--angles ORDER] [--out FILE]
       calibrate hand-eye --data POSES.csv [--angles ORDER] [--out FILE]
                          [--lens FILE --board BOARD]
       calibrate eye-to-hand (as hand-eye)

poses: which N postures to measure, of those within the joints' limits: so that points on
the flange are known best anywhere. HEADER.csv is the header of the table to come, with
where instruments and points are about, and sigma; --out (HEADER.poses.csv) is that table
with joint positions, in which what is measured is filled in. --seed of what is drawn (1);
--detail as below; --floor MM: all that moves stays above that height in the base;
--facing z:60: the points' z looks towards the instrument, 60 degrees aside at most;
--range 500:3000: so near and so far the points are from it, in mm

camera: focal lengths, centre and distortion, from JPEG or PNG photos of a board: ten or
more, tilted by about 30 degrees to all sides, that fill the image. BOARD is 9x6:25mm, a
chessboard with so many inner corners and squares of that size; circles:7x6:25mm, dark
circles in rows, so many in a row, and from one row to the next; or
asymmetric-circles:4x11:20mm, of which every second row is shifted by half a step; or
charuco:8x6:30mm:22mm:DICT_5X5_100: squares, sides of a square and of a marker, dictionary;
--out (lens.toml) is for hand-eye; --corners FILE writes where corners or circles were seen

bases: where one arm's base is in another's, from at least three points that both have
touched; a table with the columns point, arm, x_mm, y_mm, z_mm, where each arm's
controller says its tip is; --out (ARM.base.toml) is for `base` of a robot in cell.toml

tcp: where the tip of a tool is, from poses of the flange with the tip on one point;
hand-eye: where a camera is on the flange, from where it sees a fixed board meanwhile;
eye-to-hand: where one beside the arm is, that sees a board on the flange. A table
with the columns x_mm, y_mm, z_mm of the flange and its orientation: rx_rad, ry_rad,
rz_rad (a rotation vector), qw, qx, qy, qz, or a_deg, b_deg, c_deg with --angles zyx, xyz
or zyz; for cameras the same of the board in the camera, as board_x_mm and so on, or with --lens
(of `calibrate camera`) and --board a column photo, with files beside the table; --out
(tool.toml, camera.toml) is a pose for a tool in cell.toml, or for a frame

  --data FILE     joint positions and measurements; its header says what the columns are
  --test FILE     measurements of the same form that are foretold, and not used
  --detail WHAT   frames, zeros, geometry or encoders: how much is calibrated; by default
                  what foretells best the postures that are left out
  --out FILE      the calibration, for `calibration` of a robot in cell.toml;
                  by default FILE.calibration.toml beside the data
  --no-local      leave out the local corrector: what dimensions cannot say, corrected in
                  the region that was measured, and only where it helps at postures left out
  --check         read the data, say what is wrong with them, and stop

What is known too badly is not written: standard deviations of more than 1 mm of a tip,
2 mm and 5 mrad of a camera's place, 1 mm and 2 mrad of a base, 1 % of the focal length of a
lens (of fx and fy themselves, of cx, cy and of how far the lens bends where the board was),
5 mm and 20 mrad of frames of an arm. Of touches at least 0.1 mm counts as noise, of boards
0.1 mm and 0.3 mrad, of corners 0.1 px. Parameters of an arm are named as unknown if more
than half of their tolerance is left. Poses do not fit of which more than 5 mm, 20 mrad or
8 px rms are left, or three times that of one; then the likely mistake is named: units, the
order of angles or of a quaternion's parts, inverse poses, the board's size, a wrong pose.

The book's page Calibration says how to write the header.
";

struct Options {
    data: PathBuf,
    test: Option<PathBuf>,
    detail: Option<Detail>,
    out: PathBuf,
    may_be_local: bool,
    only_checks: bool,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return say(HELP);
    }
    let ran = match arguments.split_first() {
        Some((first, rest)) if first == "bases" => shop::bases(rest),
        Some((first, rest)) if first == "poses" => poses::poses(rest),
        Some((first, rest)) if first == "camera" => shop::camera(rest),
        Some((first, rest)) if ["tcp", "hand-eye", "eye-to-hand"].contains(&&**first) => {
            shop::hand(first, rest)
        }
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
    let (mut data, mut test, mut detail, mut out) = (None, None, None, None);
    let (mut may_be_local, mut only_checks) = (true, false);
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut value =
            || rest.next().cloned().ok_or_else(|| format!("{argument} needs a value\n help: see --help"));
        match argument.as_str() {
            "--data" => data = Some(PathBuf::from(value()?)),
            "--test" => test = Some(PathBuf::from(value()?)),
            "--out" => out = Some(PathBuf::from(value()?)),
            "--no-local" => may_be_local = false,
            "--check" => only_checks = true,
            "--detail" => detail = Some(self::detail(&value()?)?),
            other => return Err(format!("no option `{other}`\n help: see --help")),
        }
    }
    let data = data.ok_or("there are no data\n help: write --data FILE.csv, or see --help")?;
    let out = out.unwrap_or_else(|| data.with_extension("calibration.toml"));
    Ok(Options { data, test, detail, out, may_be_local, only_checks })
}

fn detail(word: &str) -> Result<Detail, String> {
    match word {
        "frames" => Ok(Detail::Frames),
        "zeros" => Ok(Detail::Zeros),
        "geometry" => Ok(Detail::Geometry),
        "encoders" => Ok(Detail::Encoders),
        _ => Err(format!("no detail `{word}`\n help: write frames, zeros, geometry or encoders")),
    }
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
    let name = |path: &Path| path.display().to_string();
    let file = name(&options.data);
    let of_another = |what: &dyn std::fmt::Display| {
        let help = "compare the units, the order and the signs of the joints' columns, the units of the measures, and the description of the arm";
        Failed::Before(format!("{file}: {what}\n help: {help}"))
    };
    let trials = trials(&data, wanted).map_err(|why| of_another(&why))?;
    let chosen = chosen(&trials, wanted);
    let trial = &trials[chosen];
    if !trial.is_of_this_arm() {
        let left = 1e3 * trial.within.rms;
        return Err(of_another(&format!(
            "these measurements are not of the arm as it is described: {left:.0} mm (or mrad) rms are left"
        )));
    }
    let scales = scales(&data, trial).map_err(|why| late(&why))?;
    let kinds: Vec<_> = data.arm().chain.joints.iter().map(|joint| joint.kind).collect();
    // An arm of which nothing is calibrated, or errors of encoders, has none.
    let may_be_local = options.may_be_local && [Detail::Zeros, Detail::Geometry].contains(&trial.detail);
    let local = may_be_local.then(|| trial.fit.local(trial.stated.arm, &kinds, folds(data.postures())));
    let local = local.transpose().map_err(|why| late(&why))?;
    let taken = local.as_ref().and_then(|local| local.taken.as_ref());
    let correction = taken.map(|(correction, _)| correction.clone());
    let fit = taken.map_or(&trial.fit, |(_, fit)| fit);
    // What was believed of the arm stands in for what is unknown of it; nothing stands in for a frame.
    let frames = fit.found().filter(|found| found.parameter.tolerance.is_none() && is_unknown(found));
    let frames: Vec<String> = frames
        .map(|found| {
            let (unit, factor) = found.parameter.unit.shown();
            format!("{} is known to {:.0} {unit} only", found.parameter.name, factor * found.sigma)
        })
        .collect();
    if !frames.is_empty() {
        let what = format!(
            "these measurements do not tell where all stands: {}, of {:.0} mm or {:.0} mrad at most",
            frames.join("; "),
            1e3 * FRAME,
            1e3 * FRAME_TURN
        );
        let help = "measure more postures, in which every joint turns over more of its range, and points farther from each other";
        return Err(Failed::Before(format!("{file}: {what}\n help: {help}")));
    }
    let tested = test.as_ref().map(|test| {
        let errors = |trial: &Trial, fit: &Fit, correction: Option<&LocalCorrection>| {
            let mut other = data.with_rows_of(test, &trial.stated).map_err(|why| before(&why))?;
            if let Some(correction) = correction {
                other = bent(&other, trial.stated.arm, correction);
            }
            let raw = fit.foretold(&other);
            Ok::<_, Failed>(Errors::of(lengths(&other, &raw).into_iter().map(|(_, error)| error)))
        };
        let file = options.test.as_deref().map(name).unwrap_or_default();
        Ok::<_, Failed>((
            file,
            errors(&trials[0], &trials[0].fit, None)?,
            errors(trial, fit, correction.as_ref())?,
        ))
    });
    let test = tested.transpose()?;
    let report = Report {
        data: &data,
        file: &file,
        trials: &trials,
        chosen,
        scales: &scales,
        local: local.as_ref(),
        test,
    };
    let mut frames = vec![("base".to_owned(), fit.frame(trial.stated.base))];
    let named =
        data.instruments().zip(trial.stated.instruments.iter().map(|id| trial.stated.problem.place_of(*id)));
    let points = data.points().zip(trial.stated.points.iter().map(|id| trial.stated.problem.frame_of(*id)));
    frames.extend(named.chain(points).map(|(name, frame)| (name.to_owned(), fit.frame(frame))));
    let account = Account {
        robot: data.arm().name.clone(),
        data: options.data.file_name().map(|name| name.to_string_lossy().into_owned()),
        made: today(),
        within: trial.within,
        foretold: local
            .as_ref()
            .filter(|local| local.taken.is_some())
            .map_or(trial.foretold, |local| local.with),
        frames,
    };
    let calibration = of_chain(&trial.stated.model, fit.arm(trial.stated.arm), correction);
    let written = text(&calibration, fit, trial.stated.arm, &account);
    std::fs::write(&options.out, written)
        .map_err(|why| Failed::Late(format!("{} cannot be written: {why}", options.out.display())))?;
    Ok(format!("{}\nsee {}\n", report.text(), options.out.display()))
}
