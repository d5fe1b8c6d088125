//! What the compiler makes of a flag in an optimised build (decision 24).

use std::path::Path;
use std::process::Command;

/// The compiler beside the cargo that runs these tests.
fn rustc() -> Command {
    Command::new(Path::new(env!("CARGO")).with_file_name("rustc"))
}

#[test]
fn the_form_in_which_the_runtime_sets_a_flag_is_compiled_rightly() {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("flag");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("compiler/flag.rs");
    let version = rustc().arg("--version").output().expect("rustc runs").stdout;
    let version = String::from_utf8(version).expect("text");
    for level in ["1", "2", "3"] {
        let mut command = rustc();
        command
            .args(["--edition", "2024", "-C", &format!("opt-level={level}"), "-o"])
            .arg(&program)
            .arg(&source);
        assert!(command.status().expect("rustc runs").success());
        let output = Command::new(&program).output().expect("the program runs");
        let printed = String::from_utf8(output.stdout).expect("text");
        let (or, branch) = printed.trim().split_once(' ').expect("two words");
        assert_eq!(branch, "false", "opt-level {level} of {version}");
        match or {
            "true" => {
                println!("{}: opt-level {level} sets a flag that nobody has set, by `|=`", version.trim())
            }
            _ => println!("{}: opt-level {level} is right: by `|=`, too", version.trim()),
        }
        // The versions that are known to do it: else the program shows it no more, or the compiler is another one.
        if version.starts_with("rustc 1.95.") && level != "1" {
            assert_eq!(or, "true", "decision 24 is about a compiler that does this");
        }
    }
}
