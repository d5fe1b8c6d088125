//! Every generator of the library keeps what a generator must keep: those of the [registry](super::registry), and what is made of them.

mod combinators;
mod kinds;
pub mod kit;
mod violators;

/// Every combinator is named in their file as a module, and its allocations are counted.
#[test]
fn every_combinator_of_the_library_is_held_to_this() {
    let text = include_str!("combinators.rs");
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src/combinators"));
    for entry in folder.expect("a folder") {
        let file = entry.expect("an entry").file_name().into_string().expect("a plain name");
        let Some(name) = file.strip_suffix(".rs") else { continue };
        assert!(name == "mod" || text.contains(&format!("\n    {name}: ")), "{name} is held to nothing");
    }
    let blocks = text.matches("generator_conformance! {").count();
    assert_eq!(text.matches("    allocated: bytes,\n").count(), blocks);
}
