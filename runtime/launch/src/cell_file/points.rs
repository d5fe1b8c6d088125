//! Reads the points of a file: lines of coordinates, or PLY or PCD as text.
//!
//! In: the text; the ending of the file's name says which form it has. Out: points \[m\], or the line that is none. Binary PLY and
//! PCD are refused. What a line has besides its coordinates, such as a colour, is not used.

use std::path::Path;

use mrroc_core::nalgebra::Vector3;

type Points = Vec<Vector3<f64>>;

/// The points of a file `.xyz`, `.ply` or `.pcd`; of any other the coordinates in its lines.
pub(super) fn parse(path: &Path, text: &str) -> Result<Points, String> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("ply") => ply(text),
        Some("pcd") => pcd(text),
        Some(_) | None => xyz(text),
    }
}

/// Lines that are numbered from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().map(str::trim).enumerate().map(|(index, line)| (index + 1, line))
}

/// Lines of x, y and z; empty lines and those that begin with `#` are left out.
fn xyz(text: &str) -> Result<Points, String> {
    let told = lines(text).filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    told.map(|(number, line)| point(number, line, [0, 1, 2])).collect()
}

/// The point of a line, whose coordinates are in these places.
fn point(number: usize, line: &str, places: [usize; 3]) -> Result<Vector3<f64>, String> {
    let words: Vec<_> =
        line.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty()).collect();
    let coordinate = |place: usize| {
        let word = words.get(place).ok_or_else(|| {
            format!("line {number} has {} numbers where coordinates x, y, z [m] are due", words.len())
        })?;
        let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| {
            format!("line {number}: `{word}` is not a finite number; leave out points that were not measured")
        })
    };
    let [x, y, z] = places;
    Ok(Vector3::new(coordinate(x)?, coordinate(y)?, coordinate(z)?))
}

/// The places of x, y and z among the names of columns.
fn places(names: &[&str]) -> Result<[usize; 3], String> {
    let place = |axis: &str| {
        names.iter().position(|name| *name == axis).ok_or_else(|| format!("its points have no `{axis}`"))
    };
    Ok([place("x")?, place("y")?, place("z")?])
}

/// The points of `count` lines.
fn table<'t>(
    lines: impl Iterator<Item = (usize, &'t str)>,
    count: usize,
    places: [usize; 3],
) -> Result<Points, String> {
    let points: Points =
        lines.take(count).map(|(number, line)| point(number, line, places)).collect::<Result<_, _>>()?;
    if points.len() < count {
        return Err(format!("it ends after {} of {count} points", points.len()));
    }
    Ok(points)
}

/// The Stanford format, as text: the vertices must be its first element.
fn ply(text: &str) -> Result<Points, String> {
    let mut lines = lines(text);
    if lines.next().map(|(_, line)| line) != Some("ply") {
        return Err("its first line is not `ply`".to_owned());
    }
    let (mut count, mut names) = (None, Vec::new());
    let mut is_vertex = false;
    for (number, line) in lines.by_ref() {
        let words: Vec<_> = line.split_whitespace().collect();
        match words[..] {
            ["format", "ascii", _] | ["comment" | "obj_info", ..] => {}
            ["format", other, ..] => return Err(format!("its format is {other}: save it as ascii")),
            ["element", "vertex", given] if count.is_none() => {
                is_vertex = true;
                count = Some(
                    given
                        .parse()
                        .map_err(|_| format!("line {number}: `{given}` is no number of vertices"))?,
                );
            }
            ["element", _, _] if count.is_some() => is_vertex = false,
            ["element", ..] => return Err(format!("line {number}: the vertices must be its first element")),
            ["property", "list", ..] if is_vertex => {
                return Err(format!("line {number}: a vertex with a list"));
            }
            ["property", _, name] if is_vertex => names.push(name),
            ["property", ..] => {}
            ["end_header"] => {
                let count = count.ok_or("it has no `element vertex`")?;
                return table(lines, count, places(&names)?);
            }
            _ => return Err(format!("line {number}: `{line}` in a header of PLY")),
        }
    }
    Err("it has no `end_header`".to_owned())
}

/// The format of the Point Cloud Library, as text.
fn pcd(text: &str) -> Result<Points, String> {
    let mut lines = lines(text);
    let (mut count, mut names, mut is_wide) = (None, Vec::new(), false);
    for (number, line) in lines.by_ref() {
        let words: Vec<_> = line.split_whitespace().collect();
        match words[..] {
            ["FIELDS", ref fields @ ..] => names = fields.to_vec(),
            ["COUNT", ref counts @ ..] => is_wide = counts.iter().any(|count| *count != "1"),
            ["POINTS", given] => {
                count = Some(
                    given.parse().map_err(|_| format!("line {number}: `{given}` is no number of points"))?,
                );
            }
            ["DATA", "ascii"] if is_wide => return Err("a field has a COUNT other than 1".to_owned()),
            ["DATA", "ascii"] => {
                let count = count.ok_or("it has no `POINTS`")?;
                return table(lines, count, places(&names)?);
            }
            ["DATA", other] => return Err(format!("its data are {other}: save it as ascii")),
            ["VERSION" | "SIZE" | "TYPE" | "WIDTH" | "HEIGHT" | "VIEWPOINT", ..] | [] => {}
            _ if line.starts_with('#') => {}
            _ => return Err(format!("line {number}: `{line}` in a header of PCD")),
        }
    }
    Err("it has no `DATA ascii`".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(name: &str, text: &str) -> Result<Points, String> {
        parse(Path::new(name), text)
    }

    fn two() -> Points {
        vec![Vector3::new(1.0, 2.0, 3.0), Vector3::new(-0.5, 0.0, 1e-3)]
    }

    #[test]
    fn every_form_gives_its_points() {
        let xyz = "# x y z\n1 2 3\n\n-0.5, 0, 1e-3, 255\n";
        let ply = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 2\nproperty uchar red\nproperty float x\n\
                   property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n9 1 2 3\n9 -0.5 0 1e-3\n3 0 1 1\n";
        let pcd = "# .PCD v0.7\nVERSION 0.7\nFIELDS z x y\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n\
                   VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n3 1 2\n1e-3 -0.5 0\n";
        for (name, text) in [("a.xyz", xyz), ("a", xyz), ("a.PLY", ply), ("a.pcd", pcd)] {
            assert_eq!(parsed(name, text), Ok(two()), "{name}");
        }
    }

    #[test]
    fn what_is_no_point_is_refused_with_its_line() {
        let cases = [
            ("a.xyz", "1 2 3\n1 2\n", "line 2 has 2 numbers where coordinates x, y, z [m] are due"),
            (
                "a.xyz",
                "1 2 nan\n",
                "line 1: `nan` is not a finite number; leave out points that were not measured",
            ),
            (
                "a.xyz",
                "x y z\n",
                "line 1: `x` is not a finite number; leave out points that were not measured",
            ),
            (
                "a.ply",
                "ply\nformat binary_little_endian 1.0\n",
                "its format is binary_little_endian: save it as ascii",
            ),
            ("a.ply", "1 2 3\n", "its first line is not `ply`"),
            (
                "a.ply",
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                "its points have no `y`",
            ),
            ("a.ply", "ply\nformat ascii 1.0\n", "it has no `end_header`"),
            ("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA binary\n", "its data are binary: save it as ascii"),
            ("a.pcd", "FIELDS x y z\nPOINTS 3\nDATA ascii\n1 2 3\n", "it ends after 1 of 3 points"),
            (
                "a.pcd",
                "FIELDS x y z\nCOUNT 1 1 2\nPOINTS 1\nDATA ascii\n",
                "a field has a COUNT other than 1",
            ),
        ];
        for (name, text, expected) in cases {
            assert_eq!(parsed(name, text), Err(expected.to_owned()), "{text}");
        }
    }
}
