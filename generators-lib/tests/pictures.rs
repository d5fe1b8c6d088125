//! Every generator and every combinator has its picture, and all in it are numbers.

#[path = "../examples/pictures/main.rs"]
mod pictures;

/// Names of the files of a folder of the sources.
fn names(folder: &str) -> Vec<String> {
    let files = std::fs::read_dir(format!("{}/src/{folder}", env!("CARGO_MANIFEST_DIR"))).expect("a folder");
    let name = |file: std::fs::DirEntry| file.file_name().into_string().expect("a plain name");
    let files = files.map(|file| name(file.expect("an entry")));
    files
        .filter_map(|file| file.strip_suffix(".rs").map(str::to_owned))
        .filter(|name| !["mod", "joined"].contains(&name.as_str()))
        .collect()
}

/// How many points the first element of a text has.
fn points(text: &str) -> usize {
    let points = text.split_once("points=\"").and_then(|(_, rest)| rest.split_once('"'));
    points.map_or(0, |(points, _)| points.split_whitespace().filter(|point| point.contains(',')).count())
}

#[test]
fn every_generator_is_drawn_and_nothing_that_is_no_number() {
    let drawn = pictures::pictures().expect("the inputs are in range");
    let readme = include_str!("../pictures/README.md");
    for name in names("generators").into_iter().chain(names("combinators")) {
        let (_, svg) =
            drawn.iter().find(|(drawn, _)| *drawn == name).unwrap_or_else(|| panic!("no picture of {name}"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        // Of each tool its way and three derivatives along three axes, and its path from two sides.
        let curves: Vec<usize> = svg.split("<polyline").skip(1).map(points).collect();
        assert!(curves.len() == 14 || curves.len() == 28, "{name} has {} curves", curves.len());
        assert!(curves.iter().all(|points| *points >= 2), "{name} has an empty curve: {curves:?} points");
        assert!(readme.contains(&format!("({name}.svg)")), "{name} is not shown in pictures/README.md");
        let kept = format!("{}/pictures/{name}.svg", env!("CARGO_MANIFEST_DIR"));
        assert!(std::path::Path::new(&kept).exists(), "pictures/{name}.svg is not kept");
    }
}
