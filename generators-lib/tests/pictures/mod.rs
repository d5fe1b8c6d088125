//! Every generator, every combinator and every example of a motion has its picture, and all in it are numbers.

mod examples;
mod generators;
mod sheet;
mod stage;

use std::error::Error;
use std::fs;

use sheet::Sheet;

use crate::usage::registry::rows;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/pictures");

/// Examples without a picture: the point of one is who orders whom, of the other where parts are in the end.
const UNDRAWN: [&str; 2] = ["08_cells_of_cells", "09_pallet"];

/// Generators with which an arm stands, or with one constant: their pictures would be level lines.
const LEVEL: [&str; 6] = ["await_operator", "constant_order", "delay", "settle", "sleep", "tell"];

/// Generators that demand what `transmit_displacement` does, until they stop or where they need not yield.
const SAME: [&str; 2] = ["watched_transmit", "yielding_transmit"];

/// Names of the files of a folder of this crate.
fn names(folder: &str) -> Vec<String> {
    let files = fs::read_dir(format!("{}/{folder}", env!("CARGO_MANIFEST_DIR"))).expect("a folder");
    let name = |file: fs::DirEntry| file.file_name().into_string().expect("a plain name");
    let files = files.map(|file| name(file.expect("an entry")));
    files
        .filter_map(|file| file.strip_suffix(".rs").map(str::to_owned))
        .filter(|name| name != "mod")
        .collect()
}

/// A name and a sheet for each.
fn pictures() -> Result<Vec<(&'static str, Sheet)>, Box<dyn Error>> {
    let mut all = generators::pictures()?;
    all.extend(examples::pictures()?);
    Ok(all)
}

#[test]
fn everything_is_drawn_and_nothing_that_is_no_number() {
    let drawn = pictures().expect("the inputs are in range");
    let readme = include_str!("../../pictures/README.md");
    let generators = rows().into_iter().map(|row| row.name.to_owned());
    let names = generators.chain(["src/combinators", "examples"].into_iter().flat_map(names));
    for name in names.filter(|name| ![&LEVEL[..], &SAME, &UNDRAWN].concat().contains(&&**name)) {
        let (_, sheet) =
            drawn.iter().find(|(drawn, _)| *drawn == name).unwrap_or_else(|| panic!("no picture of {name}"));
        // What is no number, an SVG has as 0.
        assert!(sheet.numbers().all(f64::is_finite), "{name}");
        let least = sheet.lengths().min().unwrap_or(0);
        assert!(least > 40, "a line of {name} has only {least} values");
        let svg = sheet.draw();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        let points = svg.matches(',').count();
        assert!(points > 40, "{name} is empty: {points} points");
    }
    let mut kept = fs::read_dir(FOLDER).expect("a folder").flatten().filter(|file| {
        let path = file.path();
        path.extension().is_some_and(|end| end == "svg")
            && !drawn.iter().any(|(name, _)| path.file_stem().is_some_and(|stem| stem == *name))
    });
    assert!(kept.next().is_none(), "a picture is kept of what is not drawn");
    for (name, sheet) in drawn {
        assert!(readme.contains(&format!("({name}.svg)")), "{name} is not shown in pictures/README.md");
        let kept = fs::read_to_string(format!("{FOLDER}/{name}.svg"));
        let kept = kept.unwrap_or_else(|error| panic!("pictures/{name}.svg is not kept: {error}"));
        if let Some(differ) = difference(&kept, &sheet.draw()) {
            panic!("pictures/{name}.svg is of another motion: {differ}: draw_all_pictures_anew");
        }
    }
}

/// Numbers, and what stands between them.
fn parts(svg: &str) -> Vec<&str> {
    let is_number = |letter: char| letter.is_ascii_digit() || letter == '.' || letter == '-';
    let mut parts = Vec::new();
    let mut begin = 0;
    for (at, letter) in svg.char_indices().skip(1) {
        let before = svg[..at].chars().next_back();
        if before.is_some_and(is_number) != is_number(letter) {
            parts.push(&svg[begin..at]);
            begin = at;
        }
    }
    parts.push(&svg[begin..]);
    parts
}

/// Where two pictures differ by more than a number's last digit: mathematical functions of other machines may round otherwise.
fn difference(kept: &str, drawn: &str) -> Option<String> {
    let (kept, drawn) = (parts(kept), parts(drawn));
    let near = |a: &str, b: &str| {
        a == b || a.parse::<f64>().ok().zip(b.parse::<f64>().ok()).is_some_and(|(a, b)| (a - b).abs() < 0.11)
    };
    if kept.len() != drawn.len() {
        return Some(format!("{} parts are kept, {} are drawn", kept.len(), drawn.len()));
    }
    let apart = kept.iter().zip(&drawn).find(|(a, b)| !near(a, b));
    apart.map(|(a, b)| format!("{a} is kept, {b} is drawn"))
}

/// Not a test: writes the pictures that are kept.
#[test]
#[ignore = "writes the folder `pictures`"]
fn draw_all_pictures_anew() {
    for (name, sheet) in pictures().expect("the inputs are in range") {
        fs::write(format!("{FOLDER}/{name}.svg"), sheet.draw()).expect("the folder can be written");
    }
}
