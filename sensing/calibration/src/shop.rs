//! Commands of a shop floor: cameras, tips, bases, each from a small table or from photos.

use std::path::Path;

use mrroc::pose::Pose;
use mrroc_calibration::columns::{Angles, Columns, Written, WrongLine};
use mrroc_calibration::file::today;
use mrroc_calibration::likely::{Asked, another_scale, causes};
use mrroc_calibration::photo::Photo;
use mrroc_calibration::{
    Eye, Held, InHand, NoFit, Seen, Touches, board_in_camera, camera_of, eye, hand_eye, intrinsics,
    square_seen, text_file, tip, turned,
};
use mrroc_launch::files;
use mrroc_sensors::aggregation::Pattern;
use mrroc_sensors::camera::Camera;

use crate::Failed;

/// Places of a flange or a board are in another unit than the columns say if they are all farther or nearer than this \[m\].
const REACH: [f64; 2] = [0.02, 20.0];

/// A tool or a camera on a flange is seldom farther from it \[m\]. Inverse poses fit as well, and show by that alone.
const FAR: f64 = 0.4;

/// By this share lengths of a board may be wrong without being told.
const SCALE: f64 = 0.005;

/// A pose is suspect that is off by so many times the usual, and by so much \[m, rad\].
const SUSPECT: f64 = 4.0;
const SUSPECT_FROM: [f64; 2] = [1e-3, 4e-3];

/// Photos of a board at least.
const PHOTOS: usize = 3;

/// Options of a command of the shop floor, by name.
pub fn given<const N: usize>(arguments: &[String], names: [&str; N]) -> Result<[Option<String>; N], Failed> {
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

pub fn needed(option: Option<String>, what: &str) -> Result<String, Failed> {
    option.ok_or_else(|| Failed::Before(format!("{what} is missing\n help: see --help")))
}

fn table(file: &str) -> Result<String, Failed> {
    text_file::read(Path::new(file))
        .map_err(|[what, help]| Failed::Before(format!("{file} {what}\n help: {help}")))
}

pub fn write(file: &str, text: &str) -> Result<(), Failed> {
    files::check_outputs([Path::new(file)]).map_err(|why| Failed::Before(why.to_string()))?;
    std::fs::write(file, text).map_err(|why| Failed::Late(format!("{file} cannot be written: {why}")))
}

/// `calibrate bases`.
pub fn bases(arguments: &[String]) -> Result<String, Failed> {
    let [data, of, within, out] = given(arguments, ["--data", "--of", "--in", "--out"])?;
    let (data, of) = (needed(data, "--data TOUCHES.csv")?, needed(of, "--of ARM")?);
    let within = needed(within, "--in ARM")?;
    let found = Touches::parse(&table(&data)?).and_then(|touches| touches.base(&of, &within));
    let found = found.map_err(|why| Failed::Before(format!("{data}: {why}")))?;
    let out = out.unwrap_or_else(|| format!("{of}.base.toml"));
    write(&out, &found.text(&of, &within, &today()))?;
    Ok(format!("the base of {of} in that of {within}\n{found}see {out}\n"))
}

/// `calibrate camera`.
pub fn camera(arguments: &[String]) -> Result<String, Failed> {
    let (photos, options) = apart(arguments);
    let [board, out, table] = given(&options, ["--board", "--out", "--corners"])?;
    let board = Pattern::parse(&needed(board, "--board 9x6:25mm")?).map_err(Failed::Before)?;
    let (mut size, mut seen, mut used, mut left_out) = (None, Vec::new(), Vec::new(), String::new());
    for file in photos {
        let photo = Photo::read(&file).map_err(Failed::Before)?;
        let first = *size.get_or_insert(photo.size);
        if photo.size != first {
            let [[w, h], [own_w, own_h]] = [first, photo.size];
            let what = format!("{file} has {own_w} x {own_h} pixels, and the photos before it {w} x {h}");
            let help = "one camera takes photos of one size: do not turn, crop or scale them";
            return Err(Failed::Before(format!("{what}\n help: {help}")));
        }
        match photo.grey().map(|grey| board.seen(&grey)) {
            Some(Ok(corners)) => {
                seen.push(corners);
                used.push(file);
            }
            Some(Err(why)) => left_out += &format!("left out: {file}: {why}\n"),
            None => left_out += &format!("left out: {file}: it has no pixels\n"),
        }
    }
    let Some(size) = size.filter(|_| seen.len() >= PHOTOS) else {
        let what = format!("the board is seen in {} photos, of at least {PHOTOS}", seen.len());
        let help = "take ten or more, tilted to all sides by 30 degrees and more, that fill the image";
        return Err(Failed::Before(format!("{left_out}{what}\n help: {help}")));
    };
    let untold = |what: &str| {
        let help = Held::of(size, board, &seen);
        Failed::Before(format!("these photos do not tell all of the camera: {what}\n help: {help}"))
    };
    let found = intrinsics(size, board, &seen).map_err(|why| match why {
        NoFit::NoMinimum(_) => untold("no focal length explains them better than all others"),
        other => Failed::Late(other.to_string()),
    })?;
    if !found.is_known() {
        let list: Vec<&str> = found.unseen.iter().chain(&found.unsure).map(String::as_str).collect();
        return Err(untold(&list.join("; ")));
    }
    let out = out.unwrap_or_else(|| "lens.toml".to_owned());
    if let Some(table) = table {
        let mut text = "photo,corner,u_px,v_px\n".to_owned();
        for (file, corners) in used.iter().zip(&seen) {
            for (i, at) in corners.iter().enumerate() {
                text += &format!("{file},{i},{:.4},{:.4}\n", at.x, at.y);
            }
        }
        write(&table, &text)?;
    }
    write(&out, &found.text(&used, board, &today()))?;
    let mut middle = found.left.clone();
    middle.sort_by(f64::total_cmp);
    let usual = middle[middle.len() / 2];
    for (file, left) in used.iter().zip(&found.left).filter(|(_, left)| **left > 3.0 * usual) {
        left_out += &format!(
            "suspect: {file}: {left:.2} px rms are left, usual are {usual:.2}: is it sharp, and the board flat?\n"
        );
    }
    if let Some(note) = Held::of(size, board, &seen).note() {
        left_out += &format!("{note}\n");
    }
    Ok(format!("the camera, from {} photos of a board of {board}\n{found}{left_out}see {out}\n", used.len()))
}

/// The arguments that are no options, and the others: each option has a value.
fn apart(arguments: &[String]) -> (Vec<String>, Vec<String>) {
    let (mut names, mut options) = (Vec::new(), Vec::new());
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument.starts_with("--") {
            options.push(argument.clone());
            options.extend(rest.next().cloned());
        } else {
            names.push(argument.clone());
        }
    }
    (names, options)
}

/// `calibrate tcp`, `calibrate hand-eye` and `calibrate eye-to-hand`.
pub fn hand(what: &str, arguments: &[String]) -> Result<String, Failed> {
    let [data, angles, lens, board, out] =
        given(arguments, ["--data", "--angles", "--lens", "--board", "--out"])?;
    let data = needed(data, "--data POSES.csv")?;
    let order = |name: String| {
        let none = || Failed::Before(format!("no order of angles `{name}`\n help: write zyx, xyz or zyz"));
        Angles::named(&name).ok_or_else(none)
    };
    let angles = angles.map(order).transpose()?;
    let text = table(&data)?;
    let wrong = |why: WrongLine| Failed::Before(format!("{data}: {why}"));
    let columns = Columns::parse(&text, "x_mm,y_mm,z_mm,rx_rad,ry_rad,rz_rad").map_err(wrong)?;
    let mut asked = Asked {
        flange: columns.written("", angles).map_err(wrong)?,
        board: None,
        is_board_written: false,
        is_beside: what == "eye-to-hand",
    };
    let mut flanges = asked.flange.poses().map_err(wrong)?;
    if flanges.len() < 3 {
        let what = format!(
            "{data}: {} poses of at least 3\n help: turn the hand about two axes between them",
            flanges.len()
        );
        return Err(Failed::Before(what));
    }
    in_reach(&data, "the flange", &asked.flange)?;
    let mounted = if asked.is_beside { Eye::Fixed } else { Eye::OnFlange };
    let (name, mut left_out) = (if what == "tcp" { "tool" } else { "camera" }, String::new());
    let found = match (what, lens, board) {
        ("tcp", ..) => tip(&flanges),
        (_, Some(lens), Some(board)) => {
            let camera = camera_of(&table(&lens)?).map_err(|why| Failed::Before(format!("{lens}: {why}")))?;
            let board = Pattern::parse(&board).map_err(Failed::Before)?;
            if !board.has_ends() {
                let what =
                    "both ends of such a board look alike, so that photos do not tell how it is turned";
                let help = "take a chessboard with an even number of inner corners along one side and an odd one along the other, such as 9x6; or a grid of circles with shifted rows, of which there are an odd number, such as 4x11";
                return Err(Failed::Before(format!("{what}\n help: {help}")));
            }
            let photos = columns.texts("photo").map_err(wrong)?;
            let (seen, rows);
            (seen, rows, left_out) = photographed(&camera, &board, Path::new(&data), &flanges, &photos)?;
            asked.flange = asked.flange.of_rows(&rows);
            flanges = rows.iter().map(|row| flanges[*row]).collect();
            let boards = seen.iter().map(|one| board_in_camera(&camera, board, &one.corners));
            let boards: Option<Vec<Pose>> = boards.collect();
            asked.board = boards.map(|boards| Written::of_poses(&boards));
            if let Ok(Some(square)) = square_seen(&camera, board, mounted, &seen) {
                let [own, believed] = [square, board.step()].map(|side| 1e3 * side);
                let what = format!(
                    "the arm's motions say that {} is {own:.3} mm, and not {believed:.3} mm",
                    board.step_name()
                );
                let help =
                    "measure the board with a calliper, over many squares; or compare the unit of the poses";
                return Err(Failed::Before(format!("{data}: {what}\n help: {help}")));
            }
            eye(&camera, board, mounted, &seen)
        }
        (_, None, None) => {
            let boards = columns.written("board_", angles).map_err(wrong)?;
            let poses = boards.poses().map_err(wrong)?;
            (asked.board, asked.is_board_written) = (Some(boards), true);
            let flange = |flange: &Pose| if mounted == Eye::Fixed { flange.inverse() } else { *flange };
            hand_eye(&flanges.iter().map(flange).zip(poses).collect::<Vec<_>>())
        }
        _ => {
            let help =
                "photos need both: --lens lens.toml, which `calibrate camera` writes, and --board 9x6:25mm";
            return Err(Failed::Before(format!("--lens or --board is missing\n help: {help}")));
        }
    };
    let (found, notes) = evaluated(&data, name, found, &asked, &flanges)?;
    left_out += &notes;
    let out = out.unwrap_or_else(|| format!("{name}.toml"));
    let place = if mounted == Eye::Fixed { "in the arm's base" } else { "on the flange" };
    let text =
        if mounted == Eye::Fixed { found.base_text(name, &today()) } else { found.text(name, &today()) };
    write(&out, &text)?;
    Ok(format!("the {name} {place}\n{found}{left_out}see {out}\n"))
}

/// What was found, if the poses fit and tell enough, with notes on it.
fn evaluated(
    data: &str,
    name: &str,
    found: Result<InHand, NoFit>,
    asked: &Asked,
    flanges: &[Pose],
) -> Result<(InHand, String), Failed> {
    let found = match found {
        Ok(found) => found,
        Err(NoFit::NoMinimum(_) | NoFit::NoStart { .. }) => {
            return Err(misfit(data, &format!("no place of the {name} explains them"), asked));
        }
        Err(why) => return Err(Failed::Late(format!("{data}: {why}"))),
    };
    if let Some(what) = found.misfit() {
        return Err(misfit(data, &what, asked));
    }
    let list: Vec<&str> = found.unseen.iter().chain(&found.unsure).map(String::as_str).collect();
    if !list.is_empty() {
        let [most, aside] = turned(flanges).map(f64::to_degrees);
        let what = format!("these poses do not tell all: {}", list.join("; "));
        let help = format!(
            "turn the hand by 30 degrees or more between poses, about two axes at least (it is turned by {most:.1} degrees at most, and about other axes than the main one by {aside:.1}); \
             and take more poses"
        );
        return Err(Failed::Before(format!("{data}: {what}\n help: {help}")));
    }
    if let Some(board) = asked.board.as_ref().filter(|_| asked.is_board_written) {
        in_reach(data, "the board", board)?;
        if let Some(cause) = another_scale(asked, SCALE) {
            let what = "these poses fit much better if the board has another size";
            return Err(Failed::Before(format!("{data}: {what}\n help: likely {cause}")));
        }
    }
    let mut notes = suspects(&found, &asked.flange.lines);
    let far = found.frame.translation.vector.norm();
    if !asked.is_beside && far > FAR {
        notes += &format!(
            "note: the {name} is {far:.2} m from the flange: if it is not, the poses are inverse: those of the base in the flange{}\n",
            if asked.board.is_none() { "" } else { ", and of the camera in the board" }
        );
    }
    Ok((found, notes))
}

/// Whether places are as far from the base, or the camera, as arms and boards are; otherwise their unit is another one.
fn in_reach(data: &str, what: &str, written: &Written) -> Result<(), Failed> {
    let (far, [near, most]) = (written.farthest(), REACH);
    let (is, not) = if far > most {
        ("mm", "m")
    } else if far < near {
        ("m", "mm")
    } else {
        return Ok(());
    };
    let what = format!("{what} is {far:.3} m away at most");
    let help = format!("its numbers are likely {is}, and the columns' names say {not}: rename the columns");
    Err(Failed::Before(format!("{data}: {what}\n help: {help}")))
}

/// Poses that do not fit, with why that is, as far as it can be found.
fn misfit(data: &str, what: &str, asked: &Asked) -> Failed {
    let causes = causes(asked);
    let help = match &causes[..] {
        [] => {
            "no single mistake explains it: compare the order of the angles, the units, whether the poses are those of the flange, and whether each row has what was seen there"
                .to_owned()
        }
        [one] => format!("likely {one}"),
        several => format!("likely one of these:\n  - {}", several.join("\n  - ")),
    };
    Failed::Before(format!("{data}: these poses do not fit: {what}\n help: {help}"))
}

/// Poses that are off by much more than the others, though all fit.
fn suspects(found: &InHand, lines: &[usize]) -> String {
    let mut text = String::new();
    let usual = |part: usize| {
        let mut all: Vec<f64> = found.poses.iter().map(|left| left[part]).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    let usual = [usual(0), usual(1)];
    for (line, left) in lines.iter().zip(&found.poses) {
        let is_off = |part: usize| {
            left[part] > SUSPECT * usual[part] && (found.pixels.is_some() || left[part] > SUSPECT_FROM[part])
        };
        if !is_off(0) && !is_off(1) {
            continue;
        }
        let by = match found.pixels {
            Some(_) => format!("{:.2} px, usual are {:.2}", left[0], usual[0]),
            None => format!(
                "{:.2} mm and {:.1} mrad, usual are {:.2} and {:.1}",
                1e3 * left[0],
                1e3 * left[1],
                1e3 * usual[0],
                1e3 * usual[1]
            ),
        };
        text += &format!("suspect: line {line} is off by {by}: is it measured, or written down, wrongly?\n");
    }
    text
}

/// What the camera saw, with the row of the table; and photos in which it saw no board.
fn photographed(
    camera: &Camera,
    board: &Pattern,
    data: &Path,
    flanges: &[Pose],
    photos: &[&str],
) -> Result<(Vec<Seen>, Vec<usize>, String), Failed> {
    let (mut seen, mut rows, mut left_out) = (Vec::new(), Vec::new(), String::new());
    for (row, (flange, photo)) in flanges.iter().zip(photos).enumerate() {
        let file = data.parent().unwrap_or(Path::new("")).join(photo);
        let read = Photo::read(&file).map_err(Failed::Before)?;
        if read.size != camera.size {
            let [[w, h], [own_w, own_h]] = [camera.size, read.size];
            let what = format!("{photo} has {own_w} x {own_h} pixels, and the camera of --lens {w} x {h}");
            return Err(Failed::Before(format!(
                "{what}\n help: take photos of the size of those that it was found from"
            )));
        }
        match read.grey().map(|grey| board.seen(&grey)) {
            Some(Ok(corners)) => {
                seen.push(Seen { flange: *flange, corners });
                rows.push(row);
            }
            Some(Err(why)) => left_out += &format!("left out: {photo}: {why}\n"),
            None => left_out += &format!("left out: {photo}: it has no pixels\n"),
        }
    }
    if seen.len() < PHOTOS {
        let what = format!("the board is seen in {} photos, of at least {PHOTOS}", seen.len());
        return Err(Failed::Before(format!("{left_out}{what}\n help: keep all of it in the image")));
    }
    Ok((seen, rows, left_out))
}
