//! The examples draw every kind of robot that a `cell.toml` may name, as well-formed SVG.

#[path = "../examples/response/main.rs"]
#[allow(dead_code)]
mod response;
#[path = "../examples/show/main.rs"]
#[allow(dead_code)]
mod show;

use roxmltree::{Document, Node};

/// The numbers in an attribute, which must be finite.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split([' ', ',']).filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words.map(|word| word.parse().expect("a number")).collect();
    assert!(numbers.iter().all(|number: &f64| number.is_finite()));
    numbers
}

fn elements<'a>(document: &'a Document<'_>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.has_tag_name(("http://www.w3.org/2000/svg", name)))
}

/// Well-formed, of a size for a screen, and with all that is drawn inside of it.
fn check(svg: &str) -> Document<'_> {
    let document = Document::parse(svg).expect("well-formed XML");
    let size = |name| numbers(document.root_element().attribute(name).expect("a size"))[0];
    let (width, height) = (size("width"), size("height"));
    assert!((200.0..3000.0).contains(&width) && (150.0..3000.0).contains(&height), "{width} x {height}");
    let inside = |x: f64, y: f64| {
        assert!((-1.0..=width + 1.0).contains(&x) && (-1.0..=height + 1.0).contains(&y), "({x}, {y})");
    };
    for line in elements(&document, "line") {
        let at = |name| numbers(line.attribute(name).expect("a coordinate"))[0];
        inside(at("x1"), at("y1"));
        inside(at("x2"), at("y2"));
    }
    for curve in elements(&document, "polyline") {
        for point in numbers(curve.attribute("points").expect("points")).chunks(2) {
            inside(point[0], point[1]);
        }
    }
    for text in elements(&document, "text") {
        assert!(!text.text().unwrap_or_default().contains("NaN"));
    }
    document
}

/// As the command does it: into a file.
fn written(name: &str, svg: &str) -> String {
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, svg).expect("a writable directory");
    std::fs::read_to_string(path).expect("what was written")
}

#[test]
fn the_response_of_every_kind_is_drawn() {
    for kind in response::KINDS.into_iter().chain(["urdf"]) {
        let svg = response::picture(kind).unwrap_or_else(|why| panic!("{kind}: {why}"));
        let svg = written(&format!("response-{kind}.svg"), &svg);
        let document = check(&svg);
        let joints = elements(&document, "polyline").count() / 3;
        assert!((1..=7).contains(&joints), "{kind}: two curves of the step, one of the error: {joints}");
        let titles =
            elements(&document, "text").filter(|text| text.attribute("class") == Some("title")).count();
        assert_eq!(titles, 2 * joints, "{kind}");
    }
    assert!(response::picture("irp7").is_err_and(|why| why.contains("irp6-track")));
}

#[test]
fn every_kind_is_shown() {
    for kind in show::KINDS {
        let svg = show::picture(kind).unwrap_or_else(|why| panic!("{kind}: {why}"));
        let svg = written(&format!("show-{kind}.svg"), &svg);
        let document = check(&svg);
        let links = elements(&document, "line").filter(|line| line.attribute("class") == Some("link"));
        assert!(links.count() >= 2, "{kind}: at least one link in both views");
        let cells = elements(&document, "rect").filter(|rect| rect.attribute("class") == Some("cell"));
        assert!(cells.count() > 3, "{kind}: where the flange gets to");
    }
    assert!(show::picture("irp7").is_err_and(|why| why.contains("irp6-track")));
}

/// The kinds are those that the cell file knows.
#[test]
fn the_examples_know_every_kind() {
    for kind in response::KINDS {
        let text = format!("step_ms = 2\nstop_ms = 5000\n[robots.a]\nkind = \"{kind}\"\n");
        let file = mrroc_launch::cell_file::CellFile::parse("cell.toml", &text).expect("well-formed");
        let Err(why) = file.cell(&mrroc_robots::simulated()) else { panic!("there is no start") };
        assert!(why.to_string().contains("write start"), "{kind}: {why}");
    }
    assert_eq!(response::KINDS, show::KINDS);
    let file =
        mrroc_launch::cell_file::CellFile::parse("cell.toml", "step_ms = 2\n[robots.a]\nkind = \"none\"\n")
            .expect("well-formed");
    let Err(why) = file.cell(&mrroc_robots::simulated()) else { panic!("there is no such kind") };
    println!("{why}");
    assert!(response::KINDS.iter().all(|kind| why.to_string().contains(kind)), "{why}");
}
