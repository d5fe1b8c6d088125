//! `calibrate poses`: which postures to measure, from the header of the table that is to come.

use std::path::Path;

use mrroc_calibration::data::Plan;
use mrroc_calibration::{Postures, Wanted};
use nalgebra::{Unit, Vector3};

use crate::Failed;
use crate::shop::{given, needed, write};

/// The command.
pub fn poses(arguments: &[String]) -> Result<String, Failed> {
    let names = ["--data", "--count", "--seed", "--detail", "--floor", "--facing", "--range", "--out"];
    let [data, count, seed, detail, floor, facing, range, out] = given(arguments, names)?;
    let data = needed(data, "--data HEADER.csv")?;
    let wanted = Wanted {
        count: number(&needed(count, "--count 30")?, "--count", "30")?,
        seed: seed.map_or(Ok(1), |seed| number(&seed, "--seed", "1"))?,
        detail: detail.map(|word| crate::detail(&word)).transpose().map_err(Failed::Before)?,
        floor: floor
            .map(|floor| number(&floor, "--floor", "50").map(|floor: f64| 1e-3 * floor))
            .transpose()?,
        facing: facing.map(|text| face(&text)).transpose()?,
        range: range.map(|text| between(&text)).transpose()?,
    };
    let out = out.map_or_else(|| Path::new(&data).with_extension("poses.csv"), Into::into);
    if out == Path::new(&data) {
        return Err(Failed::Before("--out is the file of the header\n help: write another name".to_owned()));
    }
    let plan = Plan::read(Path::new(&data)).map_err(|why| Failed::Before(why.to_string()))?;
    let postures = Postures::choose(plan, &wanted);
    let postures = postures.map_err(|why| Failed::Before(format!("{data}: {why}")))?;
    let out = out.display().to_string();
    write(&out, &postures.table)?;
    Ok(format!("{postures}see {out}: fill in what is measured, then calibrate --data {out}\n"))
}

fn number<T: std::str::FromStr>(text: &str, option: &str, example: &str) -> Result<T, Failed> {
    let wrong =
        |_| Failed::Before(format!("{option} {text} is no number for it\n help: write {option} {example}"));
    text.parse().map_err(wrong)
}

/// Such as `z:60`: the axis of a point's frame that its face looks along, and an angle in degrees.
fn face(text: &str) -> Result<(Unit<Vector3<f64>>, f64), Failed> {
    let wrong = || {
        let help = "write --facing z:60: an axis of the points' frames, x, y, z, -x, -y or -z, and degrees from 0 to 180";
        Failed::Before(format!("--facing {text} is none\n help: {help}"))
    };
    let (axis, angle) = text.split_once(':').ok_or_else(wrong)?;
    let (sign, letter) = axis.strip_prefix('-').map_or((1.0, axis), |letter| (-1.0, letter));
    let axis = match letter {
        "x" => Vector3::x_axis(),
        "y" => Vector3::y_axis(),
        "z" => Vector3::z_axis(),
        _ => return Err(wrong()),
    };
    let angle = angle.parse().ok().filter(|angle| (0.0..=180.0).contains(angle)).ok_or_else(wrong)?;
    let axis = if sign < 0.0 { -axis } else { axis };
    Ok((axis, f64::to_radians(angle)))
}

/// Such as `500:3000`, in mm.
fn between(text: &str) -> Result<[f64; 2], Failed> {
    let both = text.split_once(':').and_then(|(near, far)| Some([near.parse().ok()?, far.parse().ok()?]));
    let both = both.filter(|[near, far]: &[f64; 2]| 0.0 <= *near && near < far);
    let both = both.ok_or_else(|| {
        let help = "write --range 500:3000, the nearer one first, in mm";
        Failed::Before(format!("--range {text} is none\n help: {help}"))
    });
    both.map(|both| both.map(|mm| 1e-3 * mm))
}
