//! What the template becomes: every combination of its choices has its files, compiles and passes its own tests.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::support::{
    Cargo, Folder, checkout, combinations, covering, generated, label, said, this_checkout,
};
use mrroc_new::choices::{Chosen, Given};
use mrroc_new::project::GENERATION;
use mrroc_new::template::Template;

/// Arms from files differ from an IRp-6 in one file and in cell.toml: they are made with the defaults of the other choices.
fn all() -> Vec<Chosen> {
    let template = Template::built_in().expect("the template's description");
    let is_default = |name: &str, value: &str| {
        let own = ["robot", "urdf", "tip"].contains(&name) || name.starts_with("mrroc_");
        let default = || template.all().find(|(placeholder, _)| placeholder.name == name)?.0.default().ok();
        own || default().is_none_or(|default| default.to_string() == value)
    };
    let mut all = combinations(&template, &this_checkout(&template));
    all.retain(|chosen| {
        let from_file = chosen
            .iter()
            .any(|(name, value)| name == "robot" && ["ur5e", "urdf"].contains(&value.to_string().as_str()));
        !from_file || chosen.iter().all(|(name, value)| is_default(name, &value.to_string()))
    });
    all
}

/// Each in this folder, one after the other.
fn check(place: &str, combinations: &[Chosen]) {
    for chosen in combinations {
        println!("{}", label(chosen));
        let folder = generated(Folder::to_build_in(place), "my-task", chosen);
        let tested = Cargo::new(&folder.path().join("my-task")).check();
        assert!(!tested.contains("warning"), "{tested}");
    }
}

#[test]
fn projects_in_which_every_choice_occurs_pass_their_tests_and_are_tidy() {
    check("projects", &covering(&all()));
}

#[test]
#[ignore = "takes minutes: `just template-all`"]
fn projects_of_all_choices_pass_their_tests_and_are_tidy() {
    check("all-projects", &all());
}

/// The length of a step is a line of `cell.toml`: no file depends on it.
#[test]
fn every_combination_has_its_files() {
    let all = all();
    let step_of = |chosen: &Chosen| chosen.iter().find(|(name, _)| name == "step_ms").cloned();
    let step = |chosen: &&Chosen| step_of(chosen) == step_of(&all[0]);
    let projects: Vec<(String, BTreeSet<String>)> = all
        .iter()
        .filter(step)
        .map(|chosen| {
            (label(chosen), generated(Folder::new(), "my-task", chosen).files().into_iter().collect())
        })
        .collect();
    let in_all = projects.iter().map(|(_, files)| files.clone()).reduce(|a, b| &a & &b).expect("a project");
    let mut text = String::from("in every project:\n");
    for file in &in_all {
        writeln!(text, "    {file}").expect("a text");
    }
    for (label, files) in &projects {
        writeln!(text, "{label}:").expect("a text");
        for file in files - &in_all {
            writeln!(text, "    {file}").expect("a text");
        }
    }
    insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!("files_of_all_combinations", text);
    });
}

/// `cargo generate --path template` reads the folder where it lies, with this program in it.
#[test]
#[cfg(unix)]
fn the_templates_folder_makes_the_same_project_as_this_program() {
    let chosen = all().swap_remove(0);
    let made = generated(Folder::new(), "my-task", &chosen);
    let parts = Folder::new();
    let template = parts.path().join("template");
    std::os::unix::fs::symlink(checkout().join("template"), template).expect("a link");
    let values = chosen.iter().map(|(name, value)| format!("{name} = {:?}\n", value.to_string()));
    parts.write("values.toml", &format!("[values]\n{}", values.collect::<String>()));
    parts.write("settings.toml", "");
    let folder = Folder::new();
    let mut command = folder.mrroc_new();
    command.args([GENERATION, "my-task"]).args([parts.path(), folder.path()]).env("CARGO_NAME", "nobody");
    assert!(command.status().expect("the program starts").success());
    // The versions of other crates are added to what the template makes.
    let mut of_template = made.files();
    of_template.retain(|file| file != "my-task/Cargo.lock");
    assert_eq!(folder.files(), of_template);
    for file in of_template {
        assert_eq!(folder.read(&file), made.read(&file), "{file}");
    }
}

/// The lines by which a project depends on mrroc's crates.
fn dependencies(given: &[&str]) -> Vec<toml::Value> {
    let folder = Folder::new();
    said(&folder.run(&[&["my-task", "--defaults"], given].concat()));
    let manifest: toml::Table = folder.read("my-task/Cargo.toml").parse().expect("a manifest");
    let section = manifest["dependencies"].as_table().expect("the dependencies");
    let ours: Vec<_> = section.iter().filter(|(name, _)| name.starts_with("mrroc")).collect();
    assert!(ours.iter().any(|(name, _)| *name == "mrroc"), "{section}");
    ours.into_iter().map(|(_, value)| value.clone()).collect()
}

#[test]
fn mrroc_from_the_registry_is_of_this_version() {
    for line in dependencies(&["-d", "mrroc_source=registry"]) {
        let version = line.as_str().or_else(|| line.get("version")?.as_str()).expect("a version");
        assert!(env!("CARGO_PKG_VERSION").starts_with(version.trim_start_matches(['^', '='])), "{version}");
        assert!(line.get("path").is_none() && line.get("git").is_none(), "{line}");
    }
}

#[test]
fn mrroc_from_git_has_the_address_that_was_given() {
    for line in dependencies(&["-d", "mrroc_source=git", "-d", "mrroc_git=https://example.org/x.git"]) {
        assert_eq!(line["git"].as_str(), Some("https://example.org/x.git"));
        assert!(line.get("path").is_none() && line.get("version").is_none(), "{line}");
    }
}

#[test]
#[cfg(unix)]
fn mrroc_in_a_folder_with_blanks_quotes_and_backslashes_is_found() {
    let elsewhere = Folder::new();
    let odd = elsewhere.path().join(r#"my "own" 'mrroc' \ ż #{{x}}"#);
    std::os::unix::fs::symlink(checkout(), &odd).expect("a link");
    for line in dependencies(&["-d", &format!("mrroc_path={}", odd.display())]) {
        let path = std::path::Path::new(line["path"].as_str().expect("a path"));
        assert_eq!(path.parent(), Some(odd.as_path()));
        assert!(path.join("Cargo.toml").is_file(), "{}", path.display());
    }
}

#[test]
fn a_project_begins_with_the_versions_of_other_crates_that_mrroc_is_tested_with() {
    let folder = Folder::new();
    said(&folder.run(&["from-folder", "--defaults"]));
    said(&folder.run(&["from-registry", "--defaults", "-d", "mrroc_source=registry"]));
    let tested = std::fs::read_to_string(checkout().join("Cargo.lock")).expect("the workspace's Cargo.lock");
    assert_eq!(folder.read("from-folder/Cargo.lock"), tested);
    assert!(!folder.path().join("from-registry/Cargo.lock").exists());
}

#[test]
fn the_covering_set_holds_every_value_and_the_product_every_combination() {
    let template = Template::read(
        r#"
        [placeholders.a]
        prompt = "?"
        choices = ["1", "2", "3"]
        [placeholders.b]
        type = "bool"
        prompt = "?"
        [conditional.'b'.placeholders.c]
        type = "array"
        prompt = "?"
        choices = ["x", "y"]
        "#,
    )
    .expect("a description");
    let all = combinations(&template, &Given::new());
    // 3 * (1 + 4)
    assert_eq!(all.iter().map(label).collect::<BTreeSet<_>>().len(), 15);
    let few = covering(&all);
    let labels = few.iter().map(label).collect::<Vec<_>>().join(" ");
    for pair in ["a=1", "a=2", "a=3", "b=true", "b=false", "c=x", "c=y", "c=x,y"] {
        assert!(labels.split(' ').any(|found| found == pair), "{pair} is not in {labels}");
    }
    assert!(few.len() <= 5, "{labels}");
}

#[test]
fn the_minimal_project_has_one_binary_and_at_most_sixty_lines_of_rust() {
    let minimal = ["task=empty", "robots=one", "robot=irp6", "levels=mp", "sensor=none"];
    let of_minimal = |chosen: &&Chosen| {
        let label = label(chosen);
        minimal.iter().all(|choice| label.split(' ').any(|chosen| chosen == *choice))
    };
    let project =
        generated(Folder::new(), "my-task", all().iter().find(of_minimal).expect("there is such a project"));
    let files = project.files();
    assert_eq!(files.iter().filter(|file| file.ends_with("main.rs") || file.contains("/bin/")).count(), 1);
    // Comments count, blank lines do not.
    let lines = |file: &String| project.read(file).lines().filter(|line| !line.trim().is_empty()).count();
    let lines: usize = files.iter().filter(|file| file.starts_with("my-task/src/")).map(lines).sum();
    assert!(lines <= 60, "{lines} lines");
}

#[test]
fn a_project_takes_the_same_nalgebra_as_mrroc() {
    let folder = Folder::new();
    said(&folder.run(&["my-task", "--defaults"]));
    let manifest: toml::Table = folder.read("my-task/Cargo.toml").parse().expect("a manifest");
    let workspace = std::fs::read_to_string(checkout().join("Cargo.toml")).expect("the workspace's");
    let workspace: toml::Table = workspace.parse().expect("a manifest");
    assert_eq!(manifest["dependencies"]["nalgebra"], workspace["workspace"]["dependencies"]["nalgebra"]);
}
