//! The Python side of a sensor whose readings a program of another sends.
//!
//! In: a project, and the name of a sensor of its cell. Out: a folder `python` in the project, with the module that the project's
//! program prints by `external NAME`, and beside it a program and its test, to be filled in. Only the module is ever written
//! anew.

use std::fs;
use std::io;
use std::path::Path;
use std::process::Command;

use crate::error::Error;

const PROGRAM: &str = include_str!("external/program.py");
const TEST: &str = include_str!("external/test.py");

/// What a program on the cell's machine needs.
const PACKAGE: &str = "iceoryx2==0.10.0";

/// The folder of the Python files in a project.
const FOLDER: &str = "python";

/// Writes the Python side of a sensor into the project in which the folder `here` lies; returns what there is to say.
///
/// # Errors
/// [`Error::Refused`] when there is no project, or its program refuses the sensor; [`Error::Failed`] when a file cannot be written.
pub fn write(sensor: &str, here: &Path) -> Result<String, Error> {
    let project = here
        .ancestors()
        .find(|folder| folder.join("cell.toml").is_file() && folder.join("Cargo.toml").is_file());
    let project = project.ok_or_else(|| {
        let what =
            format!("no project here: Cargo.toml and cell.toml are neither in {} nor above", here.display());
        Error::refused(what, "go into a project by `cd`, or make one by `mrroc-new my-task`")
    })?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run =
        Command::new(cargo).args(["run", "--quiet", "--", "external", sensor]).current_dir(project).output();
    let run = run.map_err(|error| {
        Error::of_system("cargo cannot be started", &error, "see whether `cargo check` runs")
    })?;
    if !run.status.success() {
        let said = String::from_utf8_lossy(&run.stderr);
        let said = said.trim().trim_start_matches("error: ").to_owned();
        return Err(Error::Usage(said));
    }
    files(sensor, &String::from_utf8_lossy(&run.stdout), project)
}

/// Writes the files around a module.
fn files(sensor: &str, module: &str, project: &Path) -> Result<String, Error> {
    // The module's own example of a reading.
    let example =
        module.split("port.send(").nth(1).and_then(|rest| rest.split(", time.monotonic_ns())").next());
    let example = example.ok_or_else(|| {
        let help = "bring mrroc-new and the project's mrroc to the same version";
        Error::refused("the project's program prints no module of this version", help)
    })?;
    // What it needs of PyPI: another package for a program on another machine.
    let needs = module.split("Needs ").nth(1).and_then(|rest| rest.split(',').next()).unwrap_or(PACKAGE);
    let folder = project.join(FOLDER);
    let failed = |path: &Path| {
        let what = format!("{} cannot be written", path.display());
        move |error: io::Error| Error::of_system(what, &error, "see whether you may write there")
    };
    fs::create_dir_all(&folder).map_err(failed(&folder))?;
    let path = folder.join(format!("{sensor}_port.py"));
    fs::write(&path, module).map_err(failed(&path))?;
    let mut said = format!("{FOLDER}/{sensor}_port.py is made: the port, for nobody to change\n");
    for (name, text, what) in [
        (format!("{sensor}.py"), PROGRAM, "write into it how a reading is measured"),
        (format!("test_{sensor}.py"), TEST, "its test"),
    ] {
        let path = folder.join(&name);
        let text = text.replace("@NAME@", sensor).replace("@EXAMPLE@", example).replace("@NEEDS@", needs);
        match fs::File::create_new(&path)
            .and_then(|mut file| io::Write::write_all(&mut file, text.as_bytes()))
        {
            Ok(()) => said += &format!("{FOLDER}/{name} is made: {what}\n"),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                said += &format!("{FOLDER}/{name} is yours already, and stays as it is\n");
            }
            Err(error) => return Err(failed(&path)(error)),
        }
    }
    if needs != PACKAGE {
        said += &format!(
            "\nCopy {FOLDER} to the program's machine, and there as {FOLDER}/certificates what `cargo run -- certificates keys` puts \
             into keys/sensor.{sensor}.\n"
        );
    }
    Ok(format!(
        "{said}\nNow:\n  python3 -m venv venv && venv/bin/pip install {needs}\n  venv/bin/python {FOLDER}/{sensor}.py\n  \
         cargo run --release -- --processes    # in another terminal\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODULE: &str =
        "\"\"\"..\n        port.send(Reading(x=0.0, seen=True), time.monotonic_ns())\n\"\"\"\n";

    #[test]
    fn the_module_is_made_anew_and_what_somebody_may_have_changed_stays() {
        let project = tempfile::tempdir().expect("a folder");
        let said = files("camera", MODULE, project.path()).expect("it can be written");
        assert!(
            said.contains("python/camera.py is made") && said.contains("test_camera.py is made"),
            "{said}"
        );
        let read = |name: &str| fs::read_to_string(project.path().join("python").join(name)).expect("a file");
        assert!(read("camera.py").contains("    return Reading(x=0.0, seen=True)\n"));
        assert!(read("camera.py").contains("from camera_port import"));
        fs::write(project.path().join("python/camera.py"), "mine").expect("written");
        fs::write(project.path().join("python/camera_port.py"), "old").expect("written");
        let said = files("camera", MODULE, project.path()).expect("it can be written");
        assert!(said.contains("python/camera.py is yours already"), "{said}");
        assert_eq!((read("camera.py").as_str(), read("camera_port.py").as_str()), ("mine", MODULE));
    }

    #[test]
    fn a_program_on_another_machine_is_told_what_it_needs_and_where_its_certificates_go() {
        let project = tempfile::tempdir().expect("a folder");
        let module = MODULE.replacen("..", "Needs eclipse-zenoh==1.10.2, on any machine.", 1);
        let said = files("camera", &module, project.path()).expect("it can be written");
        assert!(
            said.contains("pip install eclipse-zenoh==1.10.2") && said.contains("keys/sensor.camera"),
            "{said}"
        );
        let program = fs::read_to_string(project.path().join("python/camera.py")).expect("a file");
        assert!(program.contains("Needs eclipse-zenoh==1.10.2:"), "{program}");
    }

    #[test]
    fn what_is_no_module_and_what_is_no_project_are_refused() {
        let project = tempfile::tempdir().expect("a folder");
        let told = files("camera", "usage: ..", project.path()).expect_err("no module").to_string();
        assert!(told.contains("prints no module of this version"), "{told}");
        assert!(!project.path().join("python").exists());
        let told = write("camera", project.path()).expect_err("no project").to_string();
        assert!(told.contains("no project here"), "{told}");
    }
}
