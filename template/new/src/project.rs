//! Makes a project: the template filled in by cargo-generate.
//!
//! cargo-generate runs in a process of its own, which is this program again: it says more than a newcomer wants to
//! read, and is told by environment variables who the author is. It works in a folder beside the project's, which
//! becomes the project's only when all of it is there.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, io};

use cargo_generate::{GenerateArgs, TemplatePath, Vcs};
use toml::Table;

use crate::choices::Chosen;
use crate::error::{Error, FULL};
use crate::template::FILES;
use crate::urdf::Arm;
use crate::{name, shell, source};

/// The first argument by which this program starts itself for the generation.
pub const GENERATION: &str = "--as-cargo-generate";

/// Makes the project `name` in the folder `into`; returns where it is.
///
/// # Errors
/// [`Error::Refused`] for a name that cannot be or a folder that is there already; [`Error::Failed`] when it cannot be
/// written. Nothing is left behind.
pub fn make(name: &str, into: &Path, chosen: &Chosen) -> Result<PathBuf, Error> {
    let project = place(name, into)?;
    let arm = Arm::of(chosen)?;
    let parts = tempfile::tempdir().map_err(|error| no_room(&env::temp_dir(), &error))?;
    unpack(parts.path(), chosen, arm.as_ref()).map_err(|error| no_room(parts.path(), &error))?;
    let workshop = tempfile::Builder::new().prefix(".mrroc-new-").tempdir_in(into);
    let workshop = workshop.map_err(|error| unwritable(into, &error))?;
    generate_apart(name, parts.path(), workshop.path())?;
    let made = workshop.path().join(name);
    arm.map_or(Ok(()), |arm| add(&arm, &made)).map_err(|error| unwritable(&made, &error))?;
    // Cargo adds the project itself to it, and takes out what the project does not use.
    let copied = source::lock_file(chosen).map_or(Ok(0), |lock| fs::copy(lock, made.join("Cargo.lock")));
    copied.map_err(|error| unwritable(&made, &error))?;
    fs::rename(made, &project).map_err(|error| unwritable(&project, &error))?;
    Ok(project)
}

/// Where the project `name` will be: nothing may be there yet.
///
/// # Errors
/// [`Error::Refused`], as for [`make`].
pub fn place(name: &str, into: &Path) -> Result<PathBuf, Error> {
    name::check(name)?;
    if !into.is_dir() {
        let what = format!("{} is no folder", into.display());
        return Err(Error::refused(what, format!("make it first: mkdir {}", shell::quoted(into))));
    }
    let project = if into == Path::new(".") { PathBuf::from(name) } else { into.join(name) };
    if project.symlink_metadata().is_ok() {
        let what = format!("{} is there already", project.display());
        return Err(Error::refused(what, "take another name, or move it away first: nothing is overwritten"));
    }
    Ok(project)
}

fn unwritable(path: &Path, error: &io::Error) -> Error {
    let what = format!("{}: cannot be written", path.display());
    Error::of_system(what, error, "give a folder that can be written by `--into FOLDER`")
}

/// The error of a folder for temporary files.
fn no_room(path: &Path, error: &io::Error) -> Error {
    let what = format!("{}: cannot be written", path.display());
    Error::of_system(what, error, "set TMPDIR to a folder that can be written")
}

const TEMPLATE: &str = "template";
const VALUES: &str = "values.toml";
const SETTINGS: &str = "settings.toml";

/// Adds an arm from a file of the user's: the file, and its number of joints.
fn add(arm: &Arm, project: &Path) -> io::Result<()> {
    fs::write(project.join("arm.urdf"), &arm.text)?;
    let kind = project.join("src/arm.rs");
    let text = fs::read_to_string(&kind)?.replace("Serial<6>", &format!("Serial<{}>", arm.joints.len()));
    fs::write(kind, text)
}

/// Writes what cargo-generate reads.
fn unpack(parts: &Path, chosen: &Chosen, arm: Option<&Arm>) -> io::Result<()> {
    let template = parts.join(TEMPLATE);
    for (name, content) in FILES {
        let file = template.join(name);
        fs::create_dir_all(file.parent().unwrap_or(&template))?;
        fs::write(file, content)?;
    }
    let chosen = chosen.iter().map(|(name, value)| (name.clone(), value.to_string()));
    let read = arm.map(Arm::values).into_iter().flatten();
    let values = chosen.chain(read).map(|(name, value)| (name, value.into())).collect::<Table>();
    fs::write(parts.join(VALUES), Table::from_iter([("values".to_owned(), values.into())]).to_string())?;
    // Not those of the user's own cargo-generate.
    fs::write(parts.join(SETTINGS), "")
}

fn generate_apart(name: &str, parts: &Path, workshop: &Path) -> Result<(), Error> {
    let fault = |why: String| {
        Error::failed(
            format!("the template cannot be filled in: {why}"),
            "this is a fault of the template: report it, please",
        )
    };
    let again = |error: io::Error| {
        let help = "see whether the program is still where it was started";
        Error::of_system("mrroc-new cannot be started a second time", &error, help)
    };
    let myself = env::current_exe().map_err(again)?;
    let mut command = Command::new(myself);
    command.arg(GENERATION).arg(name).arg(parts).arg(workshop).stdin(Stdio::null());
    for (variable, _) in env::vars_os() {
        // They would be values that nobody has checked.
        if variable.to_string_lossy().starts_with("CARGO_GENERATE_") {
            command.env_remove(variable);
        }
    }
    if env::var("CARGO_NAME").is_err() {
        // It looks no farther, and fails when it finds no name at all, as in a container without $USER.
        command.env("CARGO_NAME", env::var("USER").unwrap_or_else(|_| "nobody".to_owned()));
    }
    let output = command.env_remove("CLICOLOR_FORCE").output().map_err(again)?;
    match output.status.code() {
        Some(0) => return Ok(()),
        Some(code) if code == i32::from(NO_ROOM) => {
            return Err(Error::failed(
                format!("{}: there is no room for the project", workshop.display()),
                FULL,
            ));
        }
        _ => {}
    }
    let said = if output.stdout.is_empty() { output.stderr } else { output.stdout };
    Err(fault(String::from_utf8_lossy(&said).trim().to_owned()))
}

/// Exit status of the process that is started with [`GENERATION`] when the disk is full.
const NO_ROOM: u8 = 3;

/// Why cargo-generate made no project.
#[derive(Debug)]
pub struct NotGenerated {
    /// What it says.
    pub text: String,
    /// The exit status that tells the other process.
    pub status: u8,
}

impl From<String> for NotGenerated {
    fn from(text: String) -> Self {
        NotGenerated { text, status: 1 }
    }
}

/// Runs cargo-generate: what the process does that is started with [`GENERATION`].
///
/// # Errors
/// [`NotGenerated`]: what cargo-generate says.
pub fn generate(arguments: impl IntoIterator<Item = OsString>) -> Result<(), NotGenerated> {
    let arguments: Vec<_> = arguments.into_iter().collect();
    let [name, parts, workshop] = arguments.as_slice() else {
        return Err("three arguments".to_owned().into());
    };
    let text =
        |path: PathBuf| path.into_os_string().into_string().map_err(|path| format!("{path:?} is no text"));
    let parts = Path::new(parts);
    let arguments = GenerateArgs {
        template_path: TemplatePath { path: Some(text(parts.join(TEMPLATE))?), ..TemplatePath::default() },
        name: Some(text(name.into())?),
        // As it is, not in kebab case.
        force: true,
        quiet: true,
        template_values_file: Some(text(parts.join(VALUES))?),
        silent: true,
        config: Some(parts.join(SETTINGS)),
        vcs: Some(Vcs::None),
        // As from the command line.
        lib: false,
        destination: Some(workshop.into()),
        no_workspace: true,
        ..GenerateArgs::default()
    };
    cargo_generate::generate(arguments).map(drop).map_err(|error| {
        let causes = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
        let is_full = causes.map(io::Error::kind).any(|kind| kind == io::ErrorKind::StorageFull);
        NotGenerated { text: format!("{error:#}"), status: if is_full { NO_ROOM } else { 1 } }
    })
}
