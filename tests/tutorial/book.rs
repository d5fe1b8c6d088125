//! Checks the book in `docs/`: its code, links, paths, commands and edits fit the repository.

use std::path::{Path, PathBuf};
use std::process::Command;

#[cfg(unix)]
use super::page::{Edit, Step, chapters, included, links, pages, read, root, shown, steps};
use super::support::matches;

#[test]
fn every_code_that_is_shown_is_that_of_its_file() {
    let mut blocks = 0;
    for (name, text) in pages() {
        for (what, code) in shown(&text) {
            let there = included(&root(), what).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(code, there, "{name} shows another text than {what}");
            blocks += 1;
        }
    }
    assert!(blocks >= 8, "{blocks} blocks");
}

#[test]
fn every_relative_link_is_there() {
    let book = pages().into_iter().map(|(name, text)| (root().join("docs/src").join(name), text));
    let decisions = std::fs::read_dir(root().join("docs/decisions")).expect("a folder");
    let decisions = decisions.map(|entry| entry.expect("an entry").path());
    let beside =
        ["README.md", "ARCHITECTURE.md", "SAFETY.md", "docs/performance.md", "docs/maintaining/mutants.md"];
    let beside = beside.map(|name| root().join(name)).into_iter().chain(decisions);
    for (path, text) in book.chain(beside.map(|path| (path.clone(), read(path)))) {
        for link in links(&text) {
            let there = path.parent().expect("a folder").join(&link).exists();
            assert!(there, "{}: the link to {link} leads nowhere", path.display());
        }
    }
}

#[test]
fn every_page_is_in_the_summary_once() {
    let summary = links(&read(root().join("docs/src/SUMMARY.md")));
    let names: Vec<_> =
        pages().into_iter().map(|(name, _)| name).filter(|name| name != "SUMMARY.md").collect();
    let mut listed = summary.clone();
    listed.sort();
    assert_eq!(listed, names);
}

/// `path/to/file.rs`, `mrroc::module::Item` and `mrroc_robots::Item` in the tables for those who come from elsewhere.
#[test]
fn every_place_to_look_is_there() {
    let interface = |krate: &str| read(root().join(krate).join("src/lib.rs"));
    // The modules that are layers name their own items.
    let layers = ["cell", "link", "observe", "operator"];
    let layer = |name: &str| read(root().join("runtime/core/src").join(name).join("mod.rs"));
    let core = layers.map(layer).concat() + &interface("runtime/core") + &interface("runtime");
    let crates = [("mrroc::", core), ("mrroc_robots::", interface("robots"))];
    for (name, text) in pages().into_iter().filter(|(name, _)| name.starts_with("from-")) {
        let mut found = 0;
        for row in text.lines().filter(|line| line.starts_with("| ")) {
            let place = row.trim_end_matches([' ', '|']).rsplit('|').next().expect("a cell");
            for code in place.split('`').skip(1).step_by(2) {
                found += 1;
                match crates.iter().find_map(|(krate, text)| Some((code.strip_prefix(krate)?, text))) {
                    Some((item, text)) => {
                        let is_named = |part: &str| words(text).any(|word| word == part);
                        assert!(item.split("::").all(is_named), "{name}: no `{code}`");
                    }
                    None => assert!(root().join(code).is_file(), "{name}: no file {code}"),
                }
            }
        }
        assert!(found > 20, "{name}: {found} places");
    }
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
}

#[test]
fn the_tutorial_is_short() {
    // The first five are the ten minutes; the sixth goes to a real robot.
    let words: usize = chapters()
        .iter()
        .take(5)
        .map(|(_, text)| {
            text.split("```").step_by(2).map(|prose| prose.split_whitespace().count()).sum::<usize>()
        })
        .sum();
    assert!(words <= 1300, "{words} words");
}

/// Whether `choice` of the template can be `value`.
fn can_be_chosen(choice: &str, value: &str) -> bool {
    let description = read(root().join("template/cargo-generate.toml"));
    let section = description.split("\n[").find(|section| {
        section.lines().next().is_some_and(|header| header.ends_with(&format!("placeholders.{choice}]")))
    });
    let choices = section.and_then(|section| section.lines().find(|line| line.starts_with("choices = ")));
    choices.is_some_and(|choices| choices.contains(&format!("\"{value}\"")))
}

#[test]
fn every_command_is_one_that_there_is() {
    let library = read(root().join("generators-lib/src/generators/mod.rs"));
    for (name, text) in chapters() {
        let mut here = 0_i32; // folders below the one in which mrroc lies
        let starts_beside = name.starts_with("tutorial/1");
        if !starts_beside {
            here = 1;
        }
        for command in steps(&name, &text).into_iter().flat_map(|step| match step {
            Step::Run(commands, _) | Step::Beside(commands, _) | Step::ByHand(commands) => commands,
            Step::Edit(..) => Vec::new(),
        }) {
            let words: Vec<_> = command.split(' ').collect();
            match words.as_slice() {
                ["cd", ".."] => here -= 1,
                ["cd", _] => here += 1,
                ["cargo", "run" | "test"]
                | ["cargo", "test", _]
                | ["cargo", "run", "--", "--dry-run" | "--simulated" | "--processes"]
                | ["cargo", "run", "--", "--processes", "--reduced"]
                | ["cargo", "run", "--", "doctor" | "hold" | "status"]
                | ["cargo", "run", "--", "speed", "10%"] => assert_eq!(here, 1, "{name}: {command}"),
                // As tests/peers/drives/franka installs it.
                ["python3", "-m", "venv", _] => assert_eq!(here, 0, "{name}: {command}"),
                [_, "install", "--quiet", simulator] | [_, "install", "--quiet", "--no-deps", simulator] => {
                    assert_eq!(here, 0, "{name}: {command}");
                    let tried = read(root().join("tests/peers/drives/franka"));
                    assert!(tried.contains(&format!("'{simulator}'")), "{name}: {command}");
                }
                [_, script, "franka-sim"] => {
                    let path = script.strip_prefix("mrroc/").expect("a script of mrroc");
                    assert!(here == 0 && root().join(path).is_file(), "{name}: {command}");
                }
                ["cargo", "run", "--manifest-path", manifest, "-p", "mrroc-new", "--", arguments @ ..] => {
                    let expected = if here == 0 { "mrroc/Cargo.toml" } else { "../mrroc/Cargo.toml" };
                    assert_eq!(*manifest, expected, "{name}: {command}");
                    match arguments {
                        ["generator", "--list"] => {}
                        ["generator", generator, "--as", _] => {
                            assert!(library.contains(&format!("mod {generator};")), "{name}: {command}");
                        }
                        [_, "--defaults", defined @ ..] => {
                            for pair in defined.chunks(2) {
                                let [option, definition] = pair else { panic!("{name}: {command}") };
                                assert_eq!(*option, "--define", "{name}: {command}");
                                let (choice, value) = definition.split_once('=').expect("choice=value");
                                assert!(can_be_chosen(choice, value), "{name}: {command}");
                            }
                        }
                        _ => panic!("{name}: {command}"),
                    }
                }
                _ => panic!("{name}: `{command}` is not in the list of commands that a tutorial may use"),
            }
            assert!((0..=1).contains(&here), "{name}: {command} leads astray");
        }
        assert_eq!(here, 1, "{name} ends in the project's folder");
    }
}

/// The files of the template that may become this file of a project.
fn originals(file: &str) -> Vec<String> {
    let copied = "src/generators/my_line.rs";
    if file == copied {
        return vec![read(root().join("generators-lib/src/generators/straight_line.rs"))];
    }
    let sets = std::fs::read_dir(root().join("template/sets")).expect("the sets");
    let in_sets = sets.filter_map(|set| Some(set.ok()?.path().join(file.strip_prefix("src/")?)));
    let names = [file.to_owned(), format!("{file}.liquid")];
    let all = names.iter().map(|name| root().join("template").join(name)).chain(in_sets);
    // Without the conditions at the ends of comments.
    let plain = |text: String| {
        text.lines().map(|line| format!("{}\n", line.split("{%").next().unwrap_or(line))).collect()
    };
    all.filter(|path| path.is_file()).map(|path| plain(read(path))).collect()
}

#[test]
fn every_edit_changes_what_the_template_has() {
    let mut count = 0;
    for (name, text) in chapters() {
        let mut edited: Vec<(String, String)> = Vec::new();
        for step in steps(&name, &text) {
            let Step::Edit(file, edit) = step else { continue };
            count += 1;
            let earlier: Vec<_> =
                edited.iter().filter(|(path, _)| *path == file).map(|(_, text)| text.clone()).collect();
            let texts = if earlier.is_empty() { originals(&file) } else { earlier };
            assert!(!texts.is_empty(), "{name}: no file {file}");
            let new: Vec<_> = texts.iter().filter_map(|text| edit.apply(text).ok()).collect();
            assert!(!new.is_empty(), "{name}: {file}: {edit:?} fits none of the template's files");
            edited.retain(|(path, _)| *path != file);
            edited.extend(new.into_iter().map(|new| (file.clone(), new)));
        }
    }
    assert!(count > 10, "{count} edits");
}

/// What the chapters' tests compile is what the edits make of the template's and the library's files.
#[test]
fn what_is_tested_is_what_a_newcomer_gets() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tutorial");
    let edit = |chapter: &str, file: &str| {
        let (name, text) =
            chapters().into_iter().find(|(name, _)| name.ends_with(chapter)).expect("a chapter");
        let mut found = steps(&name, &text).into_iter().filter_map(|step| match step {
            Step::Edit(path, edit @ (Edit::Function(..) | Edit::Line(..))) if path == file => Some(edit),
            Step::Edit(..) | Step::Run(..) | Step::Beside(..) | Step::ByHand(..) => None,
        });
        found.next().expect("an edit")
    };
    let without_anchors = |path: &str| {
        let text = read(here.join(path));
        text.lines()
            .filter(|line| !line.contains("ANCHOR"))
            .map(|line| format!("{line}\n"))
            .collect::<String>()
    };
    let line = read(root().join("template/sets/mp_one/generators/point_to_point.rs"));
    let circle = edit("1-line.md", "src/generators/point_to_point.rs").apply(&line).expect("it fits");
    assert_eq!(circle, without_anchors("1_line/point_to_point.rs"));

    let library = read(root().join("generators-lib/src/generators/straight_line.rs"));
    // A copy has no example, which would use the library's.
    let (about, example) = library.split_once("///\n/// ```\n").expect("an example");
    let (_, code) = example.split_once("/// ```\n").expect("its end");
    let copy = format!("{about}{code}").replace("StraightLine", "MyLine").replace("straight_line", "my_line");
    let bow = edit("4-own.md", "src/generators/my_line.rs").apply(&copy).expect("it fits");
    let generator = |text: &str| text.split("#[cfg(test)]").next().expect("a part").trim_end().to_owned();
    assert_eq!(generator(&bow), generator(&without_anchors("4_own/my_line.rs")));
}

/// Does all that the tutorial says, word for word: `just tutorial`.
///
/// Builds six projects, which takes minutes, and installs what the sixth chapter does.
#[test]
#[ignore = "builds six projects, which takes minutes"]
#[cfg(unix)]
fn the_tutorial_works_word_for_word() {
    let beside = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tutorial");
    let _ = std::fs::remove_dir_all(&beside);
    std::fs::create_dir_all(&beside).expect("a folder");
    let mrroc = root().canonicalize().expect("the repository");
    std::os::unix::fs::symlink(mrroc, beside.join("mrroc")).expect("a link");
    let target = beside.with_file_name("tutorial-target");
    let mut folder: PathBuf = beside;
    for (name, text) in chapters() {
        let mut others = Vec::new();
        for step in steps(&name, &text) {
            match step {
                Step::Edit(file, edit) => {
                    let path = folder.join(&file);
                    let new =
                        edit.apply(&read(&path)).unwrap_or_else(|error| panic!("{name}: {file}: {error}"));
                    std::fs::write(path, new).expect("written");
                }
                Step::Beside(commands, shown) => {
                    others.extend(commands.iter().map(|command| Beside::start(command, &folder, &shown)));
                }
                Step::ByHand(_) => {}
                Step::Run(commands, shown) => {
                    let mut printed = String::new();
                    let mut success = true;
                    for command in &commands {
                        println!("{name}: {command}");
                        if let Some(place) = command.strip_prefix("cd ") {
                            folder = folder.join(place).canonicalize().expect("the folder is there");
                            continue;
                        }
                        let (ended_well, said) = run(command, &folder, &target);
                        success &= ended_well;
                        printed += &said;
                    }
                    let fails = shown.iter().any(|line| line.starts_with("error"));
                    assert_eq!(success, !fails, "{name}: {commands:?}\n{printed}");
                    for line in &shown {
                        let found = printed.lines().any(|printed| matches(line, printed));
                        assert!(found, "{name}: {commands:?} does not print\n{line}\nbut\n{printed}");
                    }
                }
            }
        }
    }
}

/// Whether a command ended well, and what it said.
#[cfg(unix)]
fn run(command: &str, folder: &Path, target: &Path) -> (bool, String) {
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).current_dir(folder).env("CARGO_TARGET_DIR", target);
    let output = shell.env("CARGO_TERM_COLOR", "never").output().expect("a shell");
    let said = [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned());
    (output.status.success(), said.concat())
}

/// A command in a second terminal.
#[cfg(unix)]
struct Beside(std::process::Child);

#[cfg(unix)]
impl Beside {
    /// Starts it, and waits until it says the first line that is shown.
    fn start(command: &str, folder: &Path, shown: &[String]) -> Beside {
        use std::io::BufRead;

        println!("beside: {command}");
        let words: Vec<_> = command.split(' ').collect();
        let mut started = Command::new(folder.join(words[0]));
        started.args(&words[1..]).current_dir(folder);
        started.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
        let mut child = started.spawn().expect("it starts");
        let said = std::io::BufReader::new(child.stdout.take().expect("piped"));
        let ready = said.lines().map_while(Result::ok).any(|said| said == shown[0]);
        let beside = Beside(child);
        assert!(ready, "{command} does not say {}", shown[0]);
        beside
    }
}

#[cfg(unix)]
impl Drop for Beside {
    fn drop(&mut self) {
        // The end of its input ends it.
        drop(self.0.stdin.take());
        let _ = self.0.wait();
    }
}
