//! A generator of the library, copied into a project, is the project's own: it compiles there, passes its test, and is
//! tidy.

use std::fs;

use crate::support::{Cargo, Folder, checkout, refusal, said};
use mrroc_new::catalogue::CATALOGUE;

/// A project in a folder, without the template.
fn project(folder: Folder) -> Folder {
    let mut manifest = String::from(
        "[package]\nname = \"my-task\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[workspace]\n\n[dependencies]\n",
    );
    for (name, path) in
        [("mrroc", "runtime"), ("mrroc-generators", "generators-lib"), ("mrroc-robots", "robots")]
    {
        let path = checkout().join(path);
        let path = toml::Value::from(path.to_str().expect("a plain path"));
        manifest += &format!("{name} = {{ path = {path} }}\n");
    }
    folder.write(
        "Cargo.toml",
        &(manifest + "nalgebra = { version = \"0.35\", default-features = false, features = [\"std\"] }\n"),
    );
    let versions =
        std::fs::read_to_string(checkout().join("Cargo.lock")).expect("the workspace's Cargo.lock");
    folder.write("Cargo.lock", &versions);
    folder.write("src/lib.rs", "//! A task.\n\npub mod generators;\n");
    folder.write("src/generators/mod.rs", "//! Generators of this task.\n");
    folder
}

#[test]
fn every_generator_is_copied_under_another_name_and_passes_its_test() {
    let folder = project(Folder::to_build_in("generators"));
    let mut tests = 0;
    for (i, entry) in CATALOGUE.iter().enumerate() {
        // Shorter and longer than the library's, so that rustfmt breaks lines elsewhere.
        let name = if i % 2 == 0 { format!("g{i}") } else { format!("my_own_copy_of_the_{}", entry.name) };
        let mut command = folder.mrroc_new();
        command.current_dir(folder.path().join("src"));
        let text = said(
            &command.args(["generator", entry.name, "--as", &name]).output().expect("the program starts"),
        );
        assert!(text.contains(&format!("use crate::generators::{name}::")), "{text}");
        let copy = folder.read(&format!("src/generators/{name}.rs"));
        assert!(copy.contains("#[test]"), "{name} has no test");
        tests += copy.matches("#[test]").count();
        let mut words = copy.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        assert!(words.all(|word| word != entry.type_name && word != entry.name), "{copy}");
    }
    let tested = Cargo::new(folder.path()).check();
    assert!(tested.contains(&format!("{tests} passed")) && !tested.contains("warning"), "{tested}");
}

#[test]
fn without_another_name_the_copy_has_the_librarys() {
    let folder = project(Folder::new());
    fs::write(folder.path().join("src/generators/mod.rs"), "mod a;\n\npub use a::A;\n").expect("a file");
    let text = said(&folder.run(&["generator", "straight_line"]));
    assert!(text.contains("use crate::generators::StraightLine;"), "{text}");
    assert!(text.contains("mp.move_robot(&mut robot, (), StraightLine::to(X_WE, limits))?;"), "{text}");
    assert_eq!(
        folder.read("src/generators/mod.rs"),
        "mod a;\nmod straight_line;\n\npub use a::A;\npub use straight_line::StraightLine;\n"
    );
}

#[test]
fn a_move_is_shown_of_the_program_that_the_project_has() {
    let folder = project(Folder::new());
    // What reads orders moves nothing from the coordinator.
    let ordered = said(&folder.run(&["generator", "reach_state"]));
    assert!(
        ordered.contains("It reads orders, in the program of an ECP, which this project has none of"),
        "{ordered}"
    );
    folder.write("src/ecp.rs", "");
    let text = said(&folder.run(&["generator", "straight_line"]));
    assert!(text.contains("ecp.move_robot((), StraightLine::to(X_WE, limits))?;"), "{text}");
}

#[test]
fn bad_requests_are_refused_with_good_ones() {
    let folder = project(Folder::new());
    folder.write("src/generators/mine.rs", "");
    folder.write("src/generators/mod.rs", "mod inline {}\n");
    let before = folder.files();
    for (arguments, parts) in [
        (
            &["generator", "stright_line"][..],
            ["no generator `stright_line`", "did you mean `straight_line`?"],
        ),
        (&["generator", "straight_line", "--as", "MyLine"], ["`MyLine` cannot name", "`my_line`"]),
        (&["generator", "straight_line", "--as", "move"], ["`move` cannot name", "`my_move`"]),
        (
            &["generator", "straight_line", "--as", "demand"],
            ["which the generator itself uses", "`my_demand`"],
        ),
        (&["generator", "straight_line", "--as", "mine"], ["mine.rs is there already", "--as my_mine"]),
        (
            &["generator", "straight_line", "--as", "inline"],
            ["has a module `inline` already", "--as my_inline"],
        ),
        (&["generator"], ["no generator given", "--list"]),
    ] {
        let error = refusal(&folder.run(arguments));
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert_eq!(folder.files(), before);
    }
    let error = refusal(&Folder::new().run(&["generator", "straight_line"]));
    assert!(error.contains("no project here") && error.contains("by `cd`"), "{error}");
}

#[test]
fn a_project_that_lacks_a_dependency_is_told_the_line() {
    let folder = project(Folder::new());
    let manifest = folder.read("Cargo.toml");
    for (name, section) in [("nalgebra", "dependencies"), ("mrroc-robots", "dev-dependencies")] {
        let is_its = |line: &&str| line.starts_with(&format!("{name} "));
        let line = manifest.lines().find(is_its).expect("the line");
        folder.write("Cargo.toml", &manifest.replace(&format!("{line}\n"), ""));
        let error = refusal(&folder.run(&["generator", "guarded_approach"]));
        assert!(error.contains(&format!("does not depend on {name}")), "{error}");
        let shown = error.split_once(&format!("below [{section}]: ")).expect("the line to add").1;
        let table: toml::Table = shown.parse().expect("a line of TOML");
        assert_eq!(table, line.parse().expect("a line of TOML"));
    }
}

#[test]
fn the_list_shows_every_generator_with_its_class() {
    let text = said(&Folder::new().run(&["generator", "--list"]));
    for entry in CATALOGUE {
        assert!(text.contains(entry.name) && text.contains(entry.summary()), "{text}");
        assert!(text.contains(entry.class), "{text}");
    }
}
