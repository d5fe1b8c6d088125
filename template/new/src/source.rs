//! Where a project takes mrroc from: the choices `mrroc_source`, `mrroc_path` and `mrroc_git`.

use std::path::{Path, PathBuf};

use crate::choices::{Chosen, Given};
use crate::error::Error;
use crate::template::Template;

/// The checkout that this program was built from, when it is still there and the program is run from it: a copy of the program knows
/// nothing of the folder in which somebody has built it.
#[must_use]
pub fn checkout() -> Option<PathBuf> {
    let built = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = built.ancestors().nth(2)?;
    let is_there = std::env::current_exe().is_ok_and(|program| program.starts_with(root));
    // As cargo tells what it runs, wherever its target folder is.
    let is_run_by_cargo =
        std::env::var_os("CARGO_MANIFEST_DIR").is_some_and(|folder| Path::new(&folder) == built);
    (is_checkout(root) && (is_there || is_run_by_cargo)).then(|| root.to_owned())
}

fn is_checkout(folder: &Path) -> bool {
    ["runtime", "generators-lib", "robots"].iter().all(|part| folder.join(part).join("Cargo.toml").is_file())
}

/// Adds to what was given where mrroc comes from: the checkout that this program was built from.
///
/// # Errors
/// [`Error::Refused`] for a path without mrroc, and when nothing says where it comes from.
pub fn complete(template: &Template, given: &mut Given, checkout: Option<&Path>) -> Result<(), Error> {
    if !template.has("mrroc_source") {
        return Ok(());
    }
    let source = match (given.get("mrroc_source"), given.get("mrroc_path"), given.get("mrroc_git")) {
        (Some(source), ..) => source.clone(),
        (None, Some(_), _) => "path".to_owned(),
        (None, None, Some(_)) => "git".to_owned(),
        (None, None, None) if checkout.is_some() => "path".to_owned(),
        (None, None, None) => {
            let what = "nothing says where mrroc is";
            let help = "say where it lies by `--define mrroc_path=FOLDER`, or take it from elsewhere by `--define mrroc_source=registry` or `mrroc_git=ADDRESS`";
            return Err(Error::refused(what, help));
        }
    };
    if source == "path" {
        let path = match (given.get("mrroc_path"), checkout) {
            // In the project's Cargo.toml a relative path would begin elsewhere.
            (Some(path), _) => std::path::absolute(path).unwrap_or_else(|_| path.into()),
            (None, Some(checkout)) => checkout.to_owned(),
            (None, None) => {
                let what = "mrroc_source=path without mrroc_path";
                return Err(Error::refused(what, "say where mrroc lies by `--define mrroc_path=FOLDER`"));
            }
        };
        let Some(text) = path.to_str().filter(|_| is_checkout(&path)) else {
            let what = format!("mrroc is not in {}", path.display());
            return Err(Error::refused(what, "give the folder in which mrroc's README.md lies"));
        };
        given.insert("mrroc_path".to_owned(), text.to_owned());
    }
    given.insert("mrroc_source".to_owned(), source);
    Ok(())
}

/// The versions of all crates that mrroc's own tests have, of a project that takes mrroc from a folder with that file.
pub fn lock_file(chosen: &Chosen) -> Option<PathBuf> {
    let (_, folder) = chosen.iter().find(|(name, _)| name == "mrroc_path")?;
    let lock = Path::new(&folder.to_string()).join("Cargo.lock");
    lock.is_file().then_some(lock)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn completed(given: &[(&str, &str)], checkout: Option<&Path>) -> Result<Given, String> {
        let template = Template::read("[placeholders.mrroc_source]\nprompt = \"?\"").expect("a description");
        let mut given = given.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        complete(&template, &mut given, checkout).map_err(|error| error.to_string()).map(|()| given)
    }

    #[test]
    fn the_checkout_is_taken_when_it_is_there_and_nothing_is_guessed_otherwise() {
        let checkout = checkout().expect("built from one");
        let here = checkout.to_str().expect("a plain path");
        assert_eq!(completed(&[], Some(&checkout)).expect("complete")["mrroc_path"], here);
        assert!(completed(&[], None).expect_err("nothing given").contains("mrroc_path=FOLDER"));
        assert_eq!(completed(&[("mrroc_path", "../..")], None).expect("complete")["mrroc_source"], "path");
        let git = completed(&[("mrroc_git", "https://x")], Some(&checkout)).expect("complete");
        assert_eq!((git["mrroc_source"].as_str(), git.get("mrroc_path")), ("git", None));
    }

    #[test]
    fn a_path_without_mrroc_is_refused() {
        assert!(completed(&[("mrroc_path", "src")], None).expect_err("none").contains("mrroc is not in"));
        assert!(
            completed(&[("mrroc_source", "path")], None).expect_err("none").contains("mrroc_path=FOLDER")
        );
    }
}
