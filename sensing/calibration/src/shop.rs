//! Commands of a shop floor: cameras, tips, bases, each from a small table or from photos.

use std::io::Read;
use std::path::Path;

use mrroc::pose::Pose;
use mrroc_calibration::columns::{Angles, Columns, WrongLine};
use mrroc_calibration::file::today;
use mrroc_calibration::photo::Photo;
use mrroc_calibration::{Eye, Seen, Touches, camera_of, eye, hand_eye, intrinsics, square_seen, tip};
use mrroc_launch::files;
use mrroc_sensors::aggregation::Board;
use mrroc_sensors::camera::Camera;

use crate::Failed;

/// The longest table \[bytes\].
const MOST: u64 = 1 << 20;

/// What is left of positions \[m\], or of corners in photos \[pixel\], is a mistake then, and no measurement.
const WRONG: f64 = 5e-3;
const WRONG_PIXELS: f64 = 8.0;

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
    let mut text = String::new();
    files::open(file)
        .and_then(|file| file.take(MOST).read_to_string(&mut text))
        .map_err(|why| Failed::Before(format!("{file} cannot be read: {why}")))?;
    Ok(text)
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
    let board = Board::parse(&needed(board, "--board 9x6:25mm")?).map_err(Failed::Before)?;
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
    let found = intrinsics(size, &board, &seen).map_err(|why| Failed::Late(why.to_string()))?;
    if let [_, ..] = &found.unseen[..] {
        let list = found.unseen.join("; ");
        let help = "tilt the board by 30 degrees and more, to all sides";
        return Err(Failed::Before(format!("these photos do not tell all: {list}\n help: {help}")));
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
    write(&out, &found.text(&used, &board, &today()))?;
    let mut middle = found.left.clone();
    middle.sort_by(f64::total_cmp);
    let usual = middle[middle.len() / 2];
    for (file, left) in used.iter().zip(&found.left).filter(|(_, left)| **left > 3.0 * usual) {
        left_out += &format!(
            "suspect: {file}: {left:.2} px rms are left, usual are {usual:.2}: is it sharp, and the board flat?\n"
        );
    }
    let [across, down] = board.corners;
    Ok(format!(
        "the camera, from {} photos of a board of {across} x {down} corners\n{found}{left_out}see {out}\n",
        used.len()
    ))
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
    let flanges = columns.poses("", angles).map_err(wrong)?;
    if flanges.len() < 3 {
        let what = format!(
            "{data}: {} poses of at least 3\n help: turn the hand about two axes between them",
            flanges.len()
        );
        return Err(Failed::Before(what));
    }
    let mounted = if what == "eye-to-hand" { Eye::Fixed } else { Eye::OnFlange };
    let (name, mut left_out) = (if what == "tcp" { "tool" } else { "camera" }, String::new());
    let found = match (what, lens, board) {
        ("tcp", ..) => tip(&flanges),
        (_, Some(lens), Some(board)) => {
            let camera = camera_of(&table(&lens)?).map_err(|why| Failed::Before(format!("{lens}: {why}")))?;
            let board = Board::parse(&board).map_err(Failed::Before)?;
            if !board.has_ends() {
                let what =
                    "both ends of such a board look alike, so that photos do not tell how it is turned";
                let help = "take one with an even number of inner corners along one side and an odd one along the other, such as 9x6";
                return Err(Failed::Before(format!("{what}\n help: {help}")));
            }
            let photos = columns.texts("photo").map_err(wrong)?;
            let seen;
            (seen, left_out) = photographed(&camera, &board, Path::new(&data), &flanges, &photos)?;
            if let Ok(Some(square)) = square_seen(&camera, &board, mounted, &seen) {
                let [own, believed] = [square, board.square].map(|side| 1e3 * side);
                let what = format!(
                    "the arm's motions say that a square of the board is {own:.3} mm, and not {believed:.3} mm"
                );
                let help =
                    "measure the board with a calliper, over many squares; or compare the unit of the poses";
                return Err(Failed::Before(format!("{data}: {what}\n help: {help}")));
            }
            eye(&camera, &board, mounted, &seen)
        }
        (_, None, None) => {
            let boards = columns.poses("board_", angles).map_err(wrong)?;
            let flange = |flange: Pose| if mounted == Eye::Fixed { flange.inverse() } else { flange };
            hand_eye(&flanges.into_iter().map(flange).zip(boards).collect::<Vec<_>>())
        }
        _ => {
            let help =
                "photos need both: --lens lens.toml, which `calibrate camera` writes, and --board 9x6:25mm";
            return Err(Failed::Before(format!("--lens or --board is missing\n help: {help}")));
        }
    };
    let found = found.map_err(|why| Failed::Late(format!("{data}: {why}")))?;
    if let [_, ..] = &found.unseen[..] {
        let list = found.unseen.join("; ");
        let help = "turn the hand about other axes, too, by 30 degrees or more";
        return Err(Failed::Before(format!("{data}: these poses do not tell all: {list}\n help: {help}")));
    }
    let left = match found.pixels {
        Some(pixels) if pixels > WRONG_PIXELS => Some(format!("{pixels:.1} px rms")),
        Some(_) => None,
        None => (found.left[0] > WRONG).then(|| format!("{:.1} mm rms", 1e3 * found.left[0])),
    };
    if let Some(left) = left {
        let help = match found.pixels {
            None => {
                "compare the order of the angles, the units, and whether the poses are those of the flange"
            }
            Some(_) => {
                "compare the size of the squares, which photo belongs to which row, the order of the angles, the units, and whether the poses are those of the flange"
            }
        };
        return Err(Failed::Before(format!(
            "{data}: these poses do not fit: {left} are left\n help: {help}"
        )));
    }
    let out = out.unwrap_or_else(|| format!("{name}.toml"));
    let place = if mounted == Eye::Fixed { "in the arm's base" } else { "on the flange" };
    let text =
        if mounted == Eye::Fixed { found.base_text(name, &today()) } else { found.text(name, &today()) };
    write(&out, &text)?;
    Ok(format!("the {name} {place}\n{found}{left_out}see {out}\n"))
}

/// What the camera saw, by row of the table; and photos in which it saw no board.
fn photographed(
    camera: &Camera,
    board: &Board,
    data: &Path,
    flanges: &[Pose],
    photos: &[&str],
) -> Result<(Vec<Seen>, String), Failed> {
    let (mut seen, mut left_out) = (Vec::new(), String::new());
    for (flange, photo) in flanges.iter().zip(photos) {
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
            Some(Ok(corners)) => seen.push(Seen { flange: *flange, corners }),
            Some(Err(why)) => left_out += &format!("left out: {photo}: {why}\n"),
            None => left_out += &format!("left out: {photo}: it has no pixels\n"),
        }
    }
    if seen.len() < PHOTOS {
        let what = format!("the board is seen in {} photos, of at least {PHOTOS}", seen.len());
        return Err(Failed::Before(format!("{left_out}{what}\n help: keep all of it in the image")));
    }
    Ok((seen, left_out))
}
