//! The table of classes is true, and every class of the paper has a generator.

mod table;

use mrroc::generator::Class;
use table::table;

use super::registry::rows;

#[test]
fn the_table_in_the_documentation_is_that_of_the_code() {
    let documented = include_str!("../../classes.md");
    assert!(
        documented == table(),
        "write it anew: cargo test -p mrroc-generators --lib -- --ignored write_the_table_anew"
    );
}

/// Not a test: writes the table that is kept.
#[test]
#[ignore = "writes `classes.md`"]
fn write_the_table_anew() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/classes.md");
    std::fs::write(file, table()).expect("the file can be written");
}

/// Section 6 of the paper: five classes of the coordinator, eight of an effector's controller. A generator is of the class of
/// its next steps.
#[test]
fn every_class_of_the_paper_has_a_generator() {
    let functions = [
        "MP f**() = const",
        "MP f*0(c0)",
        "MP f*1(c0, v)",
        "MP f*2(c0, e)",
        "MP f*3(c0, e, v)",
        "ECP f*0(c)",
        "ECP f*1(c, v)",
        "ECP f*2(c, e)",
        "ECP f*3(c, e, v)",
        "ECP f*4(c0, c)",
        "ECP f*5(c0, c, v)",
        "ECP f*6(c0, c, e)",
        "ECP f*7(c0, c, e, v)",
    ];
    for function in functions {
        let is_it = |class: &Class| Class::new(class.level, class.next).to_string() == function;
        assert!(rows().iter().any(|row| is_it(&row.class)), "no generator of class {function}");
    }
}

/// The page of the book lists them by class; what needs nothing but path time is listed in part.
#[test]
fn the_page_of_the_book_has_every_generator_at_its_class() {
    let page = include_str!("../../../docs/src/generators.md");
    let documented = include_str!("../../classes.md");
    for row in documented.lines().skip(2) {
        let cells: Vec<_> = row.split(" | ").collect();
        let generator = cells[0].trim_matches(['|', ' ', '[', ']', '`']);
        let named = format!("`{generator}`");
        assert!(page.contains(&named), "{generator} is missing");
        let class = format!("| {} | {} |", cells[2], cells[3]);
        let listed = page.lines().find(|line| line.starts_with(&class)).expect("a row of each class");
        assert!(listed.contains(&named) || cells[3] == "`f*0(c)`", "{generator} is not listed as {class}");
    }
}
