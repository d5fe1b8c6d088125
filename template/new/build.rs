//! Embeds the template, and the version of nalgebra that goes with this version of mrroc.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR").map_err(io::Error::other)?);
    let template = here.join("..");
    let root = template.join("..");
    // Cargo looks at the whole folder, so new and removed files count too.
    println!("cargo::rerun-if-changed=..");
    println!("cargo::rerun-if-changed=../../Cargo.toml");
    let mut files = Vec::new();
    collect(&template, &template, &mut files)?;
    // This program lies in the template's folder and is not part of it, as the template's description says, too.
    files.retain(|(name, _)| !name.starts_with("new/"));
    files.sort();
    let mut text = String::from("&[\n");
    for (name, path) in &files {
        writeln!(text, "    ({name:?}, include_bytes!({:?})),", path.display().to_string())
            .map_err(io::Error::other)?;
    }
    text.push(']');
    let out = PathBuf::from(env::var("OUT_DIR").map_err(io::Error::other)?);
    fs::write(out.join("template.rs"), text)?;

    let manifest = fs::read_to_string(root.join("Cargo.toml"))?;
    let nalgebra = manifest.lines().find_map(|line| line.strip_prefix("nalgebra = "));
    let nalgebra = nalgebra.ok_or_else(|| io::Error::other("the workspace has no line `nalgebra = ..`"))?;
    println!("cargo::rustc-env=NALGEBRA={nalgebra}");
    Ok(())
}

/// Files by their names with `/` in them; what a build in place has left is none of the template.
fn collect(root: &Path, folder: &Path, files: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            if !path.join("CACHEDIR.TAG").exists() && !path.ends_with(".git") {
                collect(root, &path, files)?;
            }
        } else {
            let name = path.strip_prefix(root).map_err(io::Error::other)?;
            let parts: Vec<_> = name.iter().map(|part| part.to_string_lossy()).collect();
            files.push((parts.join("/"), path.canonicalize()?));
        }
    }
    Ok(())
}
