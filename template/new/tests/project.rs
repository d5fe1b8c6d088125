//! A new project is made as it was asked for, or not at all.

use std::fs;

use crate::support::{Cargo, Folder, complaint, refusal, said};
use mrroc_new::template::{Kind, Template};

#[test]
fn the_last_words_are_the_next_two_commands() {
    let folder = Folder::new();
    let text = said(&folder.run(&["my-task", "--defaults"]));
    assert!(text.starts_with("my-task is made:\n"), "{text}");
    assert!(text.ends_with("\nNow:\n  cd my-task\n  cargo run\n"), "{text}");
    assert!(folder.files().contains(&"my-task/Cargo.toml".to_owned()));
    let rest = fs::read_dir(folder.path()).expect("the folder").count();
    assert_eq!(rest, 1, "only the project is there");
}

#[test]
fn a_project_in_a_folder_with_blanks_is_quoted_in_the_next_command() {
    let folder = Folder::new();
    fs::create_dir(folder.path().join("my tasks")).expect("a folder");
    let text = said(&folder.run(&["one", "--into", "my tasks"]));
    let quote = if cfg!(windows) { '"' } else { '\'' };
    let path = ["my tasks", "one"].join(std::path::MAIN_SEPARATOR_STR);
    assert!(text.contains(&format!("  cd {quote}{path}{quote}\n")), "{text}");
    assert!(folder.files().contains(&"my tasks/one/Cargo.toml".to_owned()));
}

#[test]
fn without_a_terminal_the_defaults_are_taken() {
    let (asked, defaults) = (Folder::new(), Folder::new());
    assert_eq!(said(&asked.run(&["a"])), said(&defaults.run(&["a", "--defaults"])));
    assert_eq!(asked.read("a/Cargo.toml"), defaults.read("a/Cargo.toml"));
}

#[test]
fn bad_choices_are_refused_before_anything_is_written() {
    let template = Template::built_in().expect("the template's description");
    let (name, value) = template
        .all()
        .find_map(|(placeholder, _)| match &placeholder.kind {
            Kind::OneOf(choices) => Some((placeholder.name.clone(), choices[0].value.clone())),
            Kind::AnyOf(_) | Kind::YesNo | Kind::Text(_) => None,
        })
        .expect("the template has choices");
    let folder = Folder::new();
    for (given, parts) in [
        (
            format!("{name}x={value}"),
            [format!("no choice `{name}x`"), format!("did you mean `{name}`? there are: ")],
        ),
        (
            format!("{name}={value}x"),
            [format!("{name} cannot be"), format!("did you mean `{value}`? it can be: ")],
        ),
        (
            "mrroc_git=https://example.org/x.git".to_owned(),
            ["mrroc_git can".to_owned(), "leave out".to_owned()],
        ),
        ("mrroc_path=.".to_owned(), ["mrroc is not in".to_owned(), "README.md".to_owned()]),
        (name.clone(), ["chooses nothing".to_owned(), "--define name=value".to_owned()]),
    ] {
        let source =
            if given.starts_with("mrroc_git") { "mrroc_source=registry" } else { "mrroc_source=path" };
        let error = refusal(&folder.run(&["a", "-d", source, "-d", &given]));
        assert!(parts.iter().all(|part| error.contains(part)), "{given}: {error}");
        folder.assert_empty();
    }
}

#[test]
fn an_arm_in_xacro_is_refused_with_how_to_expand_it() {
    let folder = Folder::new();
    for declared in ["", "xmlns:xacro='http://www.ros.org/wiki/xacro' "] {
        let link = "<xacro:arg name='prefix'/><link name='tool0'/>";
        folder.write("arm.urdf.xacro", &format!("<robot {declared}name='arm'>{link}</robot>"));
        let error = refusal(&folder.run(&["a", "-d", "robot=urdf", "-d", "urdf=arm.urdf.xacro"]));
        assert!(error.contains("xacro robot.urdf.xacro > robot.urdf"), "{declared}: {error}");
        assert_eq!(folder.files(), ["arm.urdf.xacro"]);
    }
}

#[test]
fn bad_names_are_refused_with_a_good_one() {
    let folder = Folder::new();
    for (name, good) in [
        ("7up", "task-7up"),
        ("my task", "my-task"),
        ("match", "my-match"),
        ("mrroc", "my-mrroc"),
        ("std", "my-std"),
    ] {
        let error = refusal(&folder.run(&[name]));
        assert!(error.contains(&format!("`{good}` can")), "{error}");
        folder.assert_empty();
    }
    assert!(refusal(&folder.run(&["tasks/one"])).contains("--into tasks one"));
    assert!(refusal(&folder.run(&[])).contains("cargo run -p mrroc-new -- my-task"));
    assert!(refusal(&folder.run(&["one", "--into", "tasks"])).contains("mkdir tasks"));
    folder.assert_empty();
}

#[test]
fn nothing_is_overwritten() {
    let folder = Folder::new();
    folder.write("file", "mine");
    fs::create_dir(folder.path().join("empty")).expect("a folder");
    for name in ["file", "empty"] {
        let error = refusal(&folder.run(&[name, "--defaults"]));
        assert!(error.contains("is there already") && error.contains("another name"), "{error}");
    }
    assert_eq!(folder.files(), ["file"]);
    assert_eq!(folder.read("file"), "mine");
}

/// Neither $USER nor git nor rustfmt nor a home: as in a bare container.
#[test]
fn an_empty_environment_is_enough() {
    let folder = Folder::new();
    let mut command = folder.mrroc_new();
    command.env_clear().env("PATH", "").args(["a", "--defaults"]);
    if let Some(root) = std::env::var_os("SystemRoot") {
        command.env("SystemRoot", root);
    }
    said(&command.output().expect("the program starts"));
    assert!(folder.files().contains(&"a/Cargo.toml".to_owned()));
    assert!(!folder.path().join("a/.git").exists());
}

#[test]
fn settings_of_the_users_own_cargo_generate_are_not_taken() {
    let folder = Folder::new();
    let home = Folder::new();
    home.write("cargo-generate.toml", "this is no [ TOML");
    let mut command = folder.mrroc_new();
    command.env("CARGO_HOME", home.path()).env("CARGO_GENERATE_VALUE_MRROC_SOURCE", "nonsense");
    said(&command.args(["a", "--defaults"]).output().expect("the program starts"));
}

#[test]
fn a_project_in_another_workspace_stays_on_its_own() {
    let folder = Folder::new();
    let outer = "[workspace]\nmembers = []\n";
    folder.write("Cargo.toml", outer);
    said(&folder.run(&["a", "--defaults"]));
    assert_eq!(folder.read("Cargo.toml"), outer);
    let project = folder.path().join("a");
    let found = Cargo::new(&project).run("locate-project", &["--workspace", "--message-format", "plain"]);
    assert!(found.trim().ends_with(&["a", "Cargo.toml"].join(std::path::MAIN_SEPARATOR_STR)), "{found}");
}

#[test]
#[cfg(target_os = "linux")]
fn nothing_is_left_behind_by_a_failure() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let complain = |temporary: &std::path::Path| {
        let mut command = folder.mrroc_new();
        command.env("TMPDIR", temporary).args(["a", "--defaults"]);
        complaint(&command.output().expect("the program starts"), 1)
    };
    let error = complain(std::path::Path::new("/no/such/folder"));
    assert!(error.contains("cannot be written"), "{error}");
    folder.assert_empty();
    // cargo-generate takes the template's path as text, and fails when the project's folder is already begun.
    let elsewhere = Folder::new();
    let odd = elsewhere.path().join(std::ffi::OsStr::from_bytes(b"\xff"));
    fs::create_dir(&odd).expect("a folder");
    let error = complain(&odd);
    assert!(error.contains("the template cannot be filled in"), "{error}");
    folder.assert_empty();
    assert_eq!(fs::read_dir(&odd).expect("the folder").count(), 0);
}

#[test]
fn the_choices_are_those_of_the_template() {
    let text = said(&Folder::new().run(&["--choices"]));
    let template = Template::built_in().expect("the template's description");
    for (placeholder, when) in template.all() {
        assert!(text.contains(&format!("{}: {}\n", placeholder.name, placeholder.prompt)), "{text}");
        assert!(when.is_none_or(|when| text.contains(&format!("  only when {when}\n"))), "{text}");
    }
}

#[test]
fn help_and_version_are_printed() {
    let folder = Folder::new();
    assert!(said(&folder.run(&["--help"])).contains("Usage: mrroc-new [OPTIONS] NAME"));
    assert_eq!(said(&folder.run(&["--version"])), concat!("mrroc-new ", env!("CARGO_PKG_VERSION"), "\n"));
}
